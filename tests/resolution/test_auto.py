"""Numbers that a run finds by itself, to meet a tolerance."""

from __future__ import annotations

import importlib.util
import json
import logging
import tomllib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed, toml
from mpi4py import MPI

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.point import FAILED, RESONANT, VERIFIED, ExpectedErrors, Verdict
from fenics_nnm.errors import StudyError
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.nonlinear.reduction_error import ReductionError
from fenics_nnm.nonlinear.series_error import SeriesError
from fenics_nnm.resolution.accuracy import Accuracy, accuracy
from fenics_nnm.resolution.auto import choice
from fenics_nnm.resolution.finer import Finer, least
from fenics_nnm.results import branch_file
from fenics_nnm.run import run_study
from fenics_nnm.running.auto_report import doubt_of
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import Study, study_from
from fenics_nnm.study.resolution import Resolution

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

ALL_AUTO: dict[str, Any] = {
    "mode": {"harmonics": "auto", "samples": "auto"},
    "reduction": {"modes": "auto"},
}

#: The small rod, whose modes are few.
SMALL = changed(
    ROD,
    {
        **ALL_AUTO,
        "mode": {**ALL_AUTO["mode"], "tolerance": 3e-3},
        "continuation": {
            "energies": {"from": 0.8, "to": 1.4, "step": 0.2},
            "report_at": [],
            "shooting": False,
        },
    },
)


def study_of(values: dict[str, Any], folder: Path = Path()) -> Study:
    return study_from(tomllib.loads(toml(values)), folder / "study.toml")


@pytest.fixture(scope="module")
def bilinear() -> ModuleType:
    path = Path(__file__).parents[2] / "demos" / "bilinear" / "bilinear.py"
    spec = importlib.util.spec_from_file_location("bilinear", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def bilinear_study(folder: Path, tolerance: float, **mode: Any) -> Study:
    """A mass, and a massless contact point on a spring, as matrices; energies up to 36."""
    np.savez(
        folder / "oscillator.npz",
        K=np.array([[60.0, -50.0], [-50.0, 50.0]]),
        M=np.diag([1.0, 0.0]),
        B=np.array([[0.0, 1.0]]),
    )
    values = {
        "matrices": {"file": "oscillator.npz"},
        "contact": {"gap": 0.01},
        "reduction": {"modes": "auto"},
        "mode": {"harmonics": "auto", "samples": "auto", "tolerance": tolerance, **mode},
        "continuation": {
            "energies": {"from": 1.0005, "to": 12.0, "step": 2.0},
            "report_at": [1.005, 1.01, 1.02, 1.05, 1.1, 1.15, 1.3, 1.5, 2.0],
            "shooting": False,
        },
    }
    return study_of(values, folder)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5])
def test_bilinear_oscillator_meets_its_tolerance(
    bilinear: ModuleType, tmp_path: Path, tolerance: float
) -> None:
    chosen = choice(bilinear_study(tmp_path, tolerance), MPI.COMM_SELF)
    branch = nonlinear_mode(chosen.study, chosen.linear)
    assert branch.complete
    errors = [
        abs(p.motion.frequency / bilinear.exact_frequency(p.motion.energy) - 1)
        for p in branch.points
    ]
    assert tolerance / 100 < max(errors) < tolerance


def test_tighter_tolerances_take_finer_numbers(tmp_path: Path) -> None:
    found = [
        choice(bilinear_study(tmp_path, tolerance), MPI.COMM_SELF).study.resolution
        for tolerance in (1e-2, 1e-4)
    ]
    assert found[0] == Resolution(harmonics=5, samples=64, modes=1)
    assert found[1].harmonics > 5 and found[1].samples > 64 and found[1].modes == 1


def test_given_numbers_are_kept(tmp_path: Path) -> None:
    study = bilinear_study(tmp_path, 1e-4, samples=512)
    found = choice(study, MPI.COMM_SELF).study.resolution
    assert found.samples == 512 and found.harmonics > 5


def test_mesh_study(tmp_path: Path) -> None:
    """The frequency is within the tolerance of that of a much finer series."""
    study = study_of(SMALL)
    result = run_study(study, toml(SMALL), tmp_path / "out", comm=MPI.COMM_SELF)
    auto = result.summary["auto"]
    assert auto["found"] == ["harmonics", "samples", "modes"]
    assert auto["tolerance"] == 3e-3 and auto["met"]
    header, points = branch_file.read(tmp_path / "out" / "branch.h5")
    assert header.resolution == Resolution(
        result.summary["harmonics"], result.summary["samples"], header.model.modes
    )
    fine = study.with_resolution(Resolution(20, 1024, header.resolution.modes))
    reference = nonlinear_mode(fine, linear_analysis(fine, MPI.COMM_SELF))
    for point, exact in zip(points, reference.points, strict=True):
        assert point.motion.frequency == pytest.approx(exact.motion.frequency, rel=3e-3)
    written = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert written["auto"] == {
        name: float(f"{each:.12g}") if isinstance(each, float) else each
        for name, each in auto.items()
    }


def test_fewer_modes_of_an_analysis_are_an_analysis_of_fewer_modes() -> None:
    values = changed(PLATE, {"reduction": {"modes": 12}})
    more = linear_analysis(study_of(values), MPI.COMM_SELF)
    fewer = linear_analysis(study_of(changed(PLATE, {"reduction": {"modes": 4}})), MPI.COMM_SELF)
    assert isinstance(more, LinearAnalysis)
    nested = more.reduction.first_modes(4)
    for name in ("omega", "Phi", "R", "gap"):
        expected = getattr(fewer.model, name)
        np.testing.assert_allclose(getattr(nested.model, name), expected, rtol=1e-7, atol=0)
    for name in ("shapes", "residual_shapes"):
        expected = getattr(fewer.reduction, name)
        size = np.abs(expected).max()
        np.testing.assert_allclose(getattr(nested, name), expected, atol=1e-7 * size)
    for name in ("slope", "curvature"):
        expected = getattr(fewer.reduction.truncation, name)
        np.testing.assert_allclose(getattr(nested.truncation, name), expected, rtol=1e-6)


def test_a_resumed_run_takes_the_numbers_over(tmp_path: Path, monkeypatch: Any) -> None:
    text, folder = toml(SMALL), tmp_path / "out"
    before = run_study(study_of(SMALL), text, folder, comm=MPI.COMM_SELF)
    monkeypatch.setattr("fenics_nnm.resolution.auto._search", None)  # no search any more
    wider = changed(SMALL, {"continuation": {"energies": {"to": 1.6}}})
    after = run_study(study_of(wider), toml(wider), folder, comm=MPI.COMM_SELF, resume=True)
    for name in ("harmonics", "samples"):
        assert after.summary[name] == before.summary[name]
    assert after.branch.points[-1].gamma_ratio == pytest.approx(1.6)
    for point, old in zip(after.branch.points, before.branch.points, strict=False):
        np.testing.assert_array_equal(point.motion.q, old.motion.q)


def test_a_branch_that_is_not_accurate_enough_is_followed_again(
    tmp_path: Path, monkeypatch: Any, caplog: pytest.LogCaptureFixture
) -> None:
    """Probes that see nothing leave the least numbers, which the points show to be too few."""
    monkeypatch.setattr("fenics_nnm.resolution.auto.probes", lambda prepared: ())
    study = bilinear_study(tmp_path, 1e-4)
    with caplog.at_level(logging.INFO, "fenics_nnm"):
        result = run_study(study, "", tmp_path / "out", comm=MPI.COMM_SELF)
    assert "once more with" in caplog.text
    assert result.summary["auto"]["met"]
    assert result.summary["auto"]["branches_followed"] > 1
    header, points = branch_file.read(tmp_path / "out" / "branch.h5")
    assert header.samples == result.summary["samples"] > 64
    assert len(points) == len(result.branch.points)
    assert all(len(point.motion.force) == header.samples // 2 + 1 for point in points)


def test_what_cannot_be_met_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    study = bilinear_study(tmp_path, 1e-5, harmonics=3)
    result = run_study(study, "", tmp_path / "out", comm=MPI.COMM_SELF)
    assert not result.summary["auto"]["met"]
    assert "mode.tolerance = 1e-05 is not met: the expected error" in caplog.text
    assert "from harmonics = 3 (as given); it would take about" in caplog.text


def test_points_that_fail_are_no_met_tolerance(
    tmp_path: Path, monkeypatch: Any, caplog: pytest.LogCaptureFixture
) -> None:
    """Expected errors mean nothing where integration in time contradicts the motion."""
    fail = Verdict(FAILED, "the motion misses its start")
    monkeypatch.setattr("fenics_nnm.backbone.verdict._verdict", lambda *each, **named: fail)
    result = run_study(bilinear_study(tmp_path, 1e-3), "", tmp_path / "out", comm=MPI.COMM_SELF)
    count = len(result.branch.points)
    assert result.summary["auto"]["met"] is False
    assert result.message.endswith(f"but {count} points failed the check in time")
    assert f"mode.tolerance = 0.001 is not known to be met: {count} points failed" in caplog.text
    assert all("raise" not in sentence for sentence in result.summary["advice"])


def test_points_that_are_not_trusted_meet_no_tolerance() -> None:
    """Points without contact are linear motions: their errors are none with any numbers."""

    def doubt(*points: tuple[str, float]) -> str:
        made = [
            SimpleNamespace(
                status=status, motion=SimpleNamespace(contact_fraction=part), returned=None
            )
            for status, part in points
        ]
        return doubt_of(cast(Branch, SimpleNamespace(points=made)))

    assert doubt() == "no point was found"
    assert doubt((VERIFIED, 0.0), (RESONANT, 0.1), (RESONANT, 0.2)).startswith("all points in")
    assert doubt((VERIFIED, 0.1), (FAILED, 0.2)) == "1 points failed the check in time"
    assert doubt((VERIFIED, 0.0)) == doubt((VERIFIED, 0.1), (RESONANT, 0.2)) == ""


def test_search_stops_at_its_limits() -> None:
    def errors(harmonics: float) -> Accuracy:
        return Accuracy(harmonics=harmonics, samples=0.0, modes=0.0, at=1.2)

    study = study_of(changed(ROD, ALL_AUTO))
    finer, at, tried = Finer(study), least(study), []
    next_one: Resolution | None = at
    while next_one is not None:
        tried.append(next_one.harmonics)
        next_one = finer.raised(next_one, errors(1 / next_one.harmonics))
    assert tried[:3] == [5, 10, 20] and tried[-1] <= 80
    assert finer.limits == {"harmonics": "the largest number tried is 80"}

    stuck, at, tried = Finer(study), least(study), []
    next_one = at
    while next_one is not None:
        tried.append(next_one.harmonics)
        next_one = stuck.raised(next_one, errors(0.01))
    assert tried == [5, 10, 20]
    assert "internal resonances" in stuck.limits["harmonics"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"mode": {"tolerance": 1e-3}},
            ("mode.tolerance = 0.001", "has no effect", 'reduction.modes = "auto"'),
        ),
        (
            {"mode": {"harmonics": "auto", "tolerance": 0.5}},
            ("mode.tolerance = 0.5", "less than 0.1"),
        ),
        ({"mode": {"harmonics": "automatic"}}, ('mode.harmonics = "automatic"', '"auto"')),
        ({"mode": {"harmonics": 0}}, ("mode.harmonics = 0", "a positive integer", '"auto"')),
        (
            {"reduction": {"method": "none", "modes": "auto"}},
            ('modes = "auto"', "full order", "explicit"),
        ),
        (
            {
                "mode": {"harmonics": "auto", "harmonic": 2},
                "continuation": {"parameter": "arc-length", "energies": {"step": None}},
            },
            ("mode.harmonic", 'harmonics = "auto"', "give numbers"),
        ),
    ],
)
def test_refusals(
    changes: dict[str, Any], words: tuple[str, ...], study_file: StudyFile, command: Command
) -> None:
    command("check", study_file(**changes)).assert_one_line(2, *words)


def test_numbers_must_be_found_before_a_branch_is_followed() -> None:
    study = study_of(changed(ROD, ALL_AUTO))
    with pytest.raises(StudyError, match=r"harmonics = \"auto\": is not found yet"):
        assert study.resolution


def test_check_shows_the_study(study_file: StudyFile, command: Command) -> None:
    ended = command("check", study_file(**ALL_AUTO))
    assert ended.code == 0
    assert 'harmonics, samples, modes = "auto": a run finds what a tolerance of 0.001' in ended.out


def point(**values: Any) -> Any:
    errors = dict.fromkeys(("harmonics_error", "samples_error", "reduction_error"), 0.0)
    given = {**errors, "gamma_ratio": 1.0, "error_remainder": 0.1, "resonance": "", **values}
    series = SeriesError(given["harmonics_error"], given["samples_error"], given["error_remainder"])
    reduction = ReductionError(0.0, given["reduction_error"])
    return SimpleNamespace(
        gamma_ratio=given["gamma_ratio"],
        resonance=given["resonance"],
        expected=ExpectedErrors(reduction, series),
    )


def test_accuracy_of_smooth_branches_is_that_of_the_worst_point() -> None:
    points = [point(harmonics_error=-error) for error in (1e-4, 9e-4, 2e-4)]
    points.append(point(harmonics_error=1.0, resonance="mode 2 in harmonic 3"))
    found = accuracy(points)
    assert (found.total, found.allowance) == (9e-4, 1.0)
    assert found.meets(1e-3) and not found.meets(8e-4)
    points[0] = point(samples_error=5e-4, reduction_error=-5e-4, harmonics_error=float("nan"))
    found = accuracy(points)
    assert (found.harmonics, found.samples, found.modes) == (0.0, 5e-4, 5e-4)
    assert accuracy(points, ("harmonics",)).harmonics == 9e-4
    assert accuracy(points, samples_factor=2.0).total == pytest.approx(1.5e-3)


def test_accuracy_among_resonances_is_that_of_the_median() -> None:
    wild = [point(harmonics_error=0.3, error_remainder=40.0)]
    points = [point(harmonics_error=error) for error in (1e-4, 5e-4, 6e-4, 14e-4)]
    found = accuracy(points + wild)
    assert found.total == 6e-4 and np.isnan(found.at)
    assert accuracy([*points, point(harmonics_error=4e-3), *wild]).total == 14e-4
    found = accuracy([*2 * points[:3], *2 * [point(harmonics_error=4e-3)], *wild])
    assert (found.total, found.at, found.allowance) == (4e-3, 1.0, 3.0)
    assert not found.meets(1e-3) and found.meets(1.4e-3)


@pytest.mark.parametrize(
    "changes",
    [
        {"reduction": {"method": "craig-bampton"}, "mode": {"tolerance": 1e-2}},
        {"mode": {"series": "general"}},
        {
            "continuation": {
                "parameter": "frequency",
                "energies": None,
                "frequencies": {"from": 1.005, "to": 1.02, "step": 0.005},
            }
        },
        {"reduction": {"method": "none", "modes": 3}},
        {
            "reduction": {"method": "none", "modes": 2},
            "contact": {"law": "augmented-lagrangian"},
            "mode": {"tolerance": 1e-2},
        },
        {
            "continuation": {
                "internal_resonance": "follow",
                "energies": {"from": 0.9, "to": 1.2, "step": 0.1},
            }
        },
        {"continuation": {"energies": {"from": 0.5, "to": 0.9, "step": 0.2}}},
    ],
)
def test_all_kinds_of_studies(changes: dict[str, Any], tmp_path: Path) -> None:
    values = changed(SMALL, changes)
    result = run_study(study_of(values), toml(values), tmp_path / "out", comm=MPI.COMM_SELF)
    assert result.branch.complete
    auto = result.summary["auto"]
    assert auto["met"] is True
    linear = values["continuation"].get("energies", {}).get("to") == 0.9
    assert linear == (auto["harmonics_error"] == 0)
    assert result.summary["harmonics"] >= 5
    assert result.message.startswith(f"harmonics = {result.summary['harmonics']}, samples = ")


def test_polynomial_forces_leave_fewer_harmonics_to_given_samples() -> None:
    """16 samples resolve 7 harmonics of contact forces, and 3 of cubic ones."""
    given = {"mode": {"harmonics": "auto", "samples": 16}}
    for kinematics, harmonics in (("linear", 5), ("second-order", 3)):
        values = changed(PLATE, {**given, "body": {"kinematics": kinematics}})
        assert least(study_from(values, Path("s.toml"))).harmonics == harmonics
