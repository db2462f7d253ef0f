"""Branches followed by their length, from study files: tongues, bifurcations, subharmonics."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, Ended
from test_branch_points import R, exact_frequencies

from fenics_nnm.backbone.follow import ArcContinuation, EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.continuation.trace_options import ArcLength
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.results import branch_file

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: A mode whose third harmonic meets the second one: a tongue with a fold at gamma ratio 8.5.
TONGUE = ReducedModel(omega=[1.0, 3.4], Phi=[[1.0, 1.0]], R=[[0.1]], gap=[1.0])


def structure(folder: Path, omega: list[float], Phi: np.ndarray, residual: float) -> None:
    """Matrices of modes with massless contact points on springs of the residual flexibility."""
    points, modes = Phi.shape
    stiff = np.eye(points) / residual
    K = np.block(
        [[np.diag(np.square(omega)) + Phi.T @ stiff @ Phi, -Phi.T @ stiff], [-stiff @ Phi, stiff]]
    )
    M = np.diag([1.0] * modes + [0.0] * points)
    B = np.hstack([np.zeros((points, modes)), np.eye(points)])
    np.savez(folder / "structure.npz", K=K, M=M, B=B)


def study(modes: int, harmonics: int, samples: int, **continuation: Any) -> dict[str, Any]:
    return {
        "title": "Modes on springs",
        "matrices": {"file": "structure.npz"},
        "contact": {"gap": 1.0},
        "reduction": {"modes": modes},
        "mode": {"harmonics": harmonics, "samples": samples},
        "continuation": continuation,
    }


def stored(folder: str = "out") -> tuple[BranchPoint, ...]:
    return branch_file.read(Path(folder) / "branch.h5")[1]


@pytest.fixture
def tongue(tmp_path: Path) -> None:
    structure(tmp_path, [1.0, 3.4], np.array([[1.0, 1.0]]), 0.1)


@pytest.fixture
def twins(tmp_path: Path) -> None:
    """Two equal oscillators, coupled: see `test_branch_points`."""
    s = np.sqrt(0.5)
    structure(tmp_path, [1.0, 2.05], np.array([[s, s], [s, -s]]), R)


def test_tongue_is_followed_and_told(tongue: None, study_file: StudyFile, command: Command) -> None:
    path = study_file(
        study(
            2,
            6,
            72,
            internal_resonance="follow",
            energies={"from": 0.8, "to": 10.0, "step": 0.2},
            report_at=[4.0],
            shooting=False,
        )
    )
    assert command("run", path, "--output", "out").code == 0
    points = stored()
    assert [p.position for p in points] == sorted(p.position for p in points)
    # 4 is passed on the way into the tongue, out of it and on
    passings = [p for p in points if p.gamma_ratio == 4.0]
    assert len(passings) == 3
    frequencies = [p.frequency_ratio for p in passings]
    assert len({round(f, 4) for f in frequencies}) == 3
    summary = json.loads(Path("out/summary.json").read_text())
    kinds = [event["kind"] for event in summary["events"]]
    assert kinds.count("fold in gamma") >= 2
    # far into it 3 omega is not near omega_2 any more, but the frequency stands still
    names = {resonance["name"] for resonance in summary["internal_resonances"]}
    assert names == {"mode 2 in harmonic 3", "other modes"}
    assert summary["reason"] == "reached gamma ratio 10"
    with Path("out/backbone.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["event"] for row in rows if row["event"]] == kinds


def test_follow_and_skip_agree_away_from_tongues() -> None:
    balance = HarmonicBalance(6, 72)
    skipping = follow(TONGUE, EnergyContinuation(0.8, 2.0, 0.4), balance, mode=0)
    following = follow(TONGUE, ArcContinuation(0.8, 2.0, step=0.4), balance, mode=0)
    for point in skipping.points[:3]:
        (same,) = [p for p in following.points if p.gamma_ratio == point.gamma_ratio]
        assert same.motion.frequency == pytest.approx(point.motion.frequency, rel=1e-9)


def test_run_is_resumed_where_it_stopped(
    tongue: None, study_file: StudyFile, command: Command
) -> None:
    def text(stop: float) -> dict[str, Any]:
        energies = {"from": 0.8, "to": stop}
        return study(2, 6, 72, parameter="arc-length", energies=energies, shooting=False)

    assert command("run", study_file(text(1.5)), "--output", "out").code == 0
    short = stored()
    assert command("run", study_file(text(2.5)), "--output", "out", "--resume").code == 0
    longer = stored()
    assert [p.position for p in longer[: len(short)]] == [p.position for p in short]
    assert longer[-1].gamma_ratio == 2.5
    command("run", study_file(text(2.5)), "--output", "fresh")
    assert longer[-1].motion.frequency == pytest.approx(
        stored("fresh")[-1].motion.frequency, rel=1e-9
    )
    assert longer[-1].position == pytest.approx(stored("fresh")[-1].position, rel=1e-2)
    again = command("run", study_file(text(2.5)), "--output", "out", "--resume")
    assert again.code == 0
    assert len(stored()) == len(longer)


def test_other_branch_from_a_bifurcation(
    twins: None, study_file: StudyFile, command: Command
) -> None:
    """The symmetry of two equal oscillators breaks where Hill's equation says."""
    energies = {"from": 0.5, "to": 3.0}
    fine = {"largest_step": 0.05}
    path = study_file(study(2, 9, 96, parameter="arc-length", energies=energies, arc_length=fine))
    assert command("run", path, "--output", "out").code == 0
    (point,) = [p for p in stored() if p.notes.event == "branch point"]
    exact = exact_frequencies(2.05, 2.0)[1]
    assert point.frequency_ratio == pytest.approx(exact, rel=1e-3)
    start = {"file": "out/branch.h5", "bifurcation": 1}
    other = study(2, 9, 96, parameter="arc-length", energies=energies, start=start)
    sides = []
    for direction in ("up", "down"):
        other["continuation"]["start"]["direction"] = direction
        other["continuation"]["arc_length"] = {"points": 10}
        ended = command("run", study_file(other), "--output", direction)
        assert ended.code == 1  # the number of steps ends it
        assert "arc_length" in ended.err
        sides.append(stored(direction)[-1])
    shares = [np.abs(side.motion.q[1, 1] / side.motion.q[1, 0]) for side in sides]
    assert min(shares) > 0.05  # out of phase, too
    assert sides[0].motion.q[1, 1] * sides[1].motion.q[1, 1] < 0  # mirror images
    assert sides[0].motion.frequency == pytest.approx(sides[1].motion.frequency, rel=1e-6)


def test_branch_from_a_coarse_point(tongue: None, study_file: StudyFile, command: Command) -> None:
    """A stored motion of one mode and two harmonics, enriched."""
    coarse = study(1, 2, 64, energies={"from": 0.8, "to": 1.6, "step": 0.4})
    assert command("run", study_file(coarse), "--output", "coarse").code == 0
    start = {"file": "coarse/branch.h5", "gamma_ratio": 1.6, "direction": "down"}
    energies = {"from": 1.2, "to": 1.8}
    path = study_file(
        study(2, 6, 72, parameter="arc-length", energies=energies, start=start, shooting=False)
    )
    assert command("run", path, "--output", "out").code == 0
    points = stored()
    assert points[0].gamma_ratio == pytest.approx(1.6, rel=1e-3)
    assert points[-1].gamma_ratio == pytest.approx(1.2)
    branch = follow(TONGUE, EnergyContinuation(1.0, 1.2, 0.1), HarmonicBalance(6, 72), mode=0)
    assert points[-1].frequency_ratio == pytest.approx(branch.points[-1].frequency_ratio, rel=1e-8)


def test_mode_in_a_higher_harmonic(tongue: None, study_file: StudyFile, command: Command) -> None:
    """A branch in harmonic 2 is the main branch at half the frequency, in units of its own."""
    energies = {"from": 0.8, "to": 1.6, "step": 0.4}
    values = study(1, 8, 128, internal_resonance="follow", energies=energies, shooting=False)
    assert command("run", study_file(values), "--output", "main").code == 0
    values["mode"].update(harmonic=2, harmonics=16, samples=256)
    assert command("run", study_file(values), "--output", "out").code == 0
    main = {p.gamma_ratio: p for p in stored("main")}
    for point in stored():
        if point.gamma_ratio in (1.2, 1.6):
            same = main[point.gamma_ratio]
            assert 2 * point.motion.frequency == pytest.approx(same.motion.frequency, rel=1e-8)
            assert point.motion.energy == pytest.approx(same.motion.energy, rel=1e-8)
            assert point.frequency_ratio == pytest.approx(same.frequency_ratio, rel=1e-8)
            assert np.abs(point.motion.q[1::2]).max() < 1e-8 * np.abs(point.motion.q).max()


def test_full_order_by_arc_length(study_file: StudyFile, command: Command) -> None:
    changes = {"method": "none", "modes": 4}
    by_energy = study_file(base=PLATE, reduction=changes)
    assert command("run", by_energy, "--output", "energy").code == 0
    followed = study_file(
        base=PLATE, reduction=changes, continuation={"internal_resonance": "follow"}
    )
    assert command("run", followed, "--output", "arc").code == 0
    arc = {round(p.gamma_ratio, 9): p.motion.frequency for p in stored("arc")}
    for point in stored("energy"):
        assert arc[round(point.gamma_ratio, 9)] == pytest.approx(point.motion.frequency, rel=1e-9)


def test_too_few_steps_are_told() -> None:
    wanted = ArcContinuation(0.8, 3.0, arc=ArcLength(points=5, newton=Newton(iterations=12)))
    branch = follow(TONGUE, wanted, HarmonicBalance(3, 32), mode=0)
    assert not branch.complete
    assert "points = 5" in branch.reason
    assert len(branch.points) >= 5


@pytest.mark.parametrize(
    ("continuation", "words"),
    [
        ({"parameter": "arc-length", "internal_resonance": "skip"}, ['"skip"', "wherever"]),
        ({"parameter": "arc-length", "energies": {"step": 0.1}}, ["energies.step"]),
        ({"arc_length": {"step": 0.01}}, ["arc_length: needs"]),
        ({"start": {"file": "a.h5", "gamma_ratio": 1.0}}, ["start: needs"]),
        (
            {"parameter": "arc-length", "start": {"file": "a.h5"}},
            ["continuation.start", "either gamma_ratio or bifurcation"],
        ),
        (
            {"parameter": "arc-length", "start": {"file": "a.h5", "gamma_ratio": 1.0}},
            ["continuation.start.file", "a.h5", "no such file"],
        ),
        (
            {"parameter": "arc-length", "arc_length": {"step": 1.0}},
            ["arc_length", "step = 1", "largest_step = 0.1"],
        ),
        ({"internal_resonance": "avoid"}, ["internal_resonance", '"follow"']),
    ],
)
def test_choices_that_do_not_fit(
    continuation: dict[str, Any], words: list[str], study_file: StudyFile, command: Command
) -> None:
    path = study_file(continuation={"=": continuation})
    command("run", path).assert_one_line(2, *words)


def test_harmonic_that_does_not_fit(study_file: StudyFile, command: Command) -> None:
    path = study_file(mode={"harmonic": 2})
    command("run", path).assert_one_line(2, "mode.harmonic = 2", '"follow"')
    path = study_file(mode={"harmonic": 4}, continuation={"internal_resonance": "follow"})
    command("run", path).assert_one_line(2, "mode.harmonic = 4", "mode.harmonics = 3")


def test_start_of_another_structure(
    tongue: None, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    coarse = study(1, 2, 64, energies={"from": 0.8, "to": 1.2, "step": 0.4})
    assert command("run", study_file(coarse), "--output", "coarse").code == 0
    path = {"file": "coarse/branch.h5", "gamma_ratio": 1.2}
    wanted = study(1, 2, 64, parameter="arc-length", start=path)
    structure(tmp_path, [1.1, 3.4], np.array([[1.0, 1.0]]), 0.1)
    ended = command("run", study_file(wanted), "--output", "out")
    ended.assert_one_line(2, "continuation.start.file", "is of another structure", "frequency 1")
    structure(tmp_path, [1.0, 3.4], np.array([[1.0, 1.0]]), 0.1)
    path["gamma_ratio"] = 1.1
    ended = command("run", study_file(wanted), "--output", "out")
    ended.assert_one_line(2, "continuation.start.gamma_ratio = 1.1", "report_at")
    del path["gamma_ratio"]
    wanted["continuation"]["start"]["bifurcation"] = 1
    ended = command("run", study_file(wanted), "--output", "out")
    ended.assert_one_line(2, "continuation.start.bifurcation = 1", "has 0 branch points")


def test_start_with_another_mode_or_file(
    tongue: None, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """Ratios are those of the followed mode in its harmonic: with another one they mislead."""
    coarse = study(2, 2, 64, energies={"from": 0.8, "to": 1.2, "step": 0.4})
    assert command("run", study_file(coarse), "--output", "coarse").code == 0
    path = {"file": "coarse/branch.h5", "gamma_ratio": 1.2}
    wanted = study(2, 4, 64, parameter="arc-length", start=path)
    for key in ("number", "harmonic"):
        wanted["mode"][key] = 2
        ended = command("run", study_file(wanted), "--output", "out")
        ended.assert_one_line(2, f"mode.{key} = 2", f"motions of mode.{key} = 1: must be the same")
        del wanted["mode"][key]
    path["file"] = "coarse"
    ended = command("run", study_file(wanted), "--output", "out")
    ended.assert_one_line(2, "coarse: is no file: must be a branch.h5")
    path["file"] = "study.toml"
    ended = command("run", study_file(wanted), "--output", "out")
    ended.assert_one_line(2, "continuation.start.file = ", "study.toml: cannot be read")
