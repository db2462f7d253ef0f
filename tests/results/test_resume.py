"""What a run takes over from an earlier one: the points of the same study, and nothing else."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed, contents, toml
from killed_runs import failing_after
from mpi4py import MPI

from fenics_nnm.backbone.follow import EnergyContinuation
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.cli import main
from fenics_nnm.errors import StudyError
from fenics_nnm.fem.blocks import Data
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.results import branch_file, owner
from fenics_nnm.results.journal import Journal
from fenics_nnm.results.resume import (
    StoredRun,
    difference,
    known_points,
    remove_taken_over,
    stored_run,
)
from fenics_nnm.results.staging import Stopped, running_folders, stopped_runs
from fenics_nnm.run import RunResult, run_study
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

MATRICES: dict[str, Any] = {
    "title": "Matrices",
    "matrices": {"file": "blade.npz"},
    "contact": {"gap": [1e-3, 2e-3]},
    "reduction": {"modes": 2},
}


def run(text: str, folder: Path, *, resume: bool = False) -> RunResult:
    study = study_from(tomllib.loads(text), Path("study.toml"))
    return run_study(study, text, folder, resume=resume, comm=MPI.COMM_SELF)


def stopped(text: str, folder: Path, points: int) -> None:
    """A run that is stopped once a number of points are stored."""
    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        failing_after(patch, points, KeyboardInterrupt())
        run(text, folder)


def found(folder: Path, text: str) -> StoredRun | None:
    return stored_run(folder, stopped_runs(folder), text)


def test_a_results_folder_may_be_renamed_during_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    original = branch_file.append

    def renaming(points: Journal, point: BranchPoint) -> None:
        original(points, point)
        if Path("old").exists():
            Path("old").rename("new")

    monkeypatch.setattr(branch_file, "append", renaming)
    ended = run(toml(ROD), Path("old"))
    assert ended.folder == Path("new") and not Path("old").exists()
    assert {path.name for path in Path("new").iterdir()} >= {"branch.h5", "fields", "summary.json"}
    assert len(branch_file.read(Path("new/branch.h5"))[1]) == len(ended.branch.points) == 4


@pytest.mark.parametrize(
    ("base", "changes"),
    [
        (ROD, {}),
        (ROD, {"title": "Other"}),
        (ROD, {"continuation": {"energies": {"from": 0.5, "to": 2.0, "step": 0.01}}}),
        (ROD, {"continuation": {"report_at": []}}),
        (ROD, {"output": {"frames": 48, "folder": "elsewhere"}}),
        (ROD, {"clamp": {"facets": ["left"]}}),
        (ROD, {"contact": {"points": "all"}, "material": {"poisson": 0.0, "young": 210e9}}),
        (MATRICES, {"matrices": {"stiffness": "K"}}),
    ],
)
def test_same_study(base: dict[str, Any], changes: dict[str, Any]) -> None:
    assert difference(toml(base), toml(changed(base, changes))) == ""


@pytest.mark.parametrize(
    ("base", "changes", "told"),
    [
        (ROD, {"mesh": {"elements": 5}}, "mesh.elements was 4 and is 5 now"),
        (ROD, {"contact": {"gap": 2e-3}}, "contact.gap was 0.001 and is 0.002 now"),
        (ROD, {"contact": {"points": 1}}, 'contact.points was "all" and is 1 now'),
        (ROD, {"clamp": {"facets": "right"}}, "clamp.facets was ['left'] and is ['right'] now"),
        (ROD, {"clamp": None}, "clamp.facets was ['left'] and is not given now"),
        (ROD, {"mode": {"samples": 64, "harmonics": 4}}, "mode.harmonics was 3 and is 4 now"),
        (
            ROD,
            {"reduction": {"modes": 3}, "material": {"young": 2e11}},
            "material.young was 210000000000.0 and is 200000000000.0 now",
        ),
        (
            ROD,
            {"reduction": {"method": "craig-bampton"}, "augmented_lagrangian": {"beta": 5.0}},
            'reduction.method was "massless" and is "craig-bampton" now',
        ),
        (MATRICES, {"matrices": {"mass": "M2"}}, 'matrices.mass was "M" and is "M2" now'),
        (MATRICES, {"contact": {"gap": 1e-3}}, "contact.gap was [0.001, 0.002] and is 0.001 now"),
    ],
)
def test_other_study(base: dict[str, Any], changes: dict[str, Any], told: str) -> None:
    assert difference(toml(base), toml(changed(base, changes))) == told


def test_study_of_another_version() -> None:
    told = difference(toml(ROD) + '\n[magic]\nwand = "long"\n', toml(ROD))
    assert told.startswith("its study file cannot be read by this version: study.toml: magic")


def test_nothing_to_resume(tmp_path: Path) -> None:
    assert found(tmp_path / "nowhere", toml(ROD)) is None


def test_stopped_run_comes_before_the_finished_one(tmp_path: Path) -> None:
    text = toml(ROD)
    run(text, tmp_path)
    for points in (2, 3, 1):
        stopped(text, tmp_path, points)
    other = toml(changed(ROD, {"mode": {"harmonics": 4}}))
    stopped(other, tmp_path, 2)
    runs = stopped_runs(tmp_path)
    assert [(r.path.name, r.points, r.gone) for r in runs] == [
        (".running-1", 2, True),
        (".running-2", 3, True),
        (".running-3", 1, True),
        (".running-4", 2, True),
    ]
    chosen = found(tmp_path, text)
    assert chosen is not None and chosen.path == tmp_path / ".running-2/branch.h5"
    assert [round(point.gamma_ratio, 9) for point in chosen.points] == [0.8, 0.9, 1.0]
    chosen = found(tmp_path, other)
    assert chosen is not None and chosen.path == tmp_path / ".running-4/branch.h5"
    for left in runs[:3]:
        branch_file.read(left.path / "branch.h5")
        (left.path / "branch.h5").unlink()
    chosen = found(tmp_path, text)
    assert chosen is not None and chosen.path == tmp_path / "branch.h5"
    assert len(chosen.points) == 4


def test_points_of_another_study_are_refused(tmp_path: Path) -> None:
    run(toml(ROD), tmp_path)
    before = contents(tmp_path)
    other = toml(changed(ROD, {"material": {"density": 7900.0}}))
    told = r"branch\.h5: is of another study: material\.density was 7800\.0 and is 7900\.0 now$"
    with pytest.raises(StudyError, match=told):
        run(other, tmp_path, resume=True)
    assert contents(tmp_path) == before and running_folders(tmp_path) == []


@pytest.fixture
def plate_run(tmp_path: Path) -> tuple[StoredRun, LinearAnalysis]:
    """A finished run of the small plate in contact, and its linear analysis."""
    text = toml(changed(PLATE, {"reduction": {"modes": 3}}))
    run(text, tmp_path)
    stored = found(tmp_path, text)
    assert stored is not None
    study = study_from(tomllib.loads(text), Path("study.toml"))
    return stored, linear_analysis(study, MPI.COMM_SELF)


def test_only_wanted_energies_are_taken_over(plate_run: tuple[StoredRun, LinearAnalysis]) -> None:
    stored, analysis = plate_run
    ratios = [point.gamma_ratio for point in stored.points]
    assert len(ratios) == 4
    for first, last in [(0, 3), (1, 2), (2, 3)]:
        # ends that differ in the last digit, as steps of another width give them
        low, high = np.nextafter(ratios[first], 9), np.nextafter(ratios[last], 0)
        points = known_points(stored, analysis.model, EnergyContinuation(low, high, 0.1))
        assert [point.gamma_ratio for point in points] == ratios[first : last + 1]
    assert known_points(stored, analysis.model, EnergyContinuation(1.2, 3.0, 0.1)) == ()
    assert len(known_points(stored, analysis.model, EnergyContinuation(0.1, 5.0, 0.1))) == 4


def test_signs_of_the_modes_are_those_of_the_new_model(
    plate_run: tuple[StoredRun, LinearAnalysis],
) -> None:
    """With modes of other signs, the points taken over solve the equations of the new model."""
    stored, analysis = plate_run
    model = analysis.model
    assert max(point.motion.contact_fraction for point in stored.points) > 0
    for signs in ([1, 1, 1], [-1, 1, 1], [1, -1, -1]):
        flipped = ReducedModel(model.omega, model.Phi * signs, model.R, model.gap)
        points = known_points(stored, flipped, EnergyContinuation(0.8, 1.1, 0.1))
        for before, point in zip(stored.points, points, strict=True):
            np.testing.assert_array_equal(point.motion.q, before.motion.q * signs)
            np.testing.assert_allclose(
                point.motion.q @ flipped.Phi.T, point.motion.free, atol=1e-9 * 1e-3
            )
            assert (point.motion.energy, point.status) == (before.motion.energy, before.status)
            assert _residual(flipped, point) < 1e-9


def _residual(model: ReducedModel, point: Any) -> float:
    """Largest entry of (omega_j^2 - n^2 omega^2) q_nj + (Phi^T lambda_n)_j, relative."""
    omega, order = 2 * np.pi * point.motion.frequency, np.arange(len(point.motion.q))
    force = CosineSeries(3, 32).analysis @ point.motion.force @ model.Phi
    inertia = (model.omega**2 - (order[:, None] * omega) ** 2) * point.motion.q
    return float(np.abs(inertia + force).max() / np.abs(model.omega**2 * point.motion.q).max())


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda m: {"omega": m.omega * [1, 1 + 1e-5, 1]}, "linear frequency 2 was "),
        (lambda m: {"gap": m.gap * 1.00001}, "the gaps differ"),
        (lambda m: {"Phi": m.Phi + [[1e-4, 0, 0]] * m.points}, "the linear modes differ"),
        (lambda m: {"Phi": -m.Phi[::-1] * [1, 2, 1]}, "the linear modes differ"),
        (lambda m: {"R": m.R * 1.00001}, "the residual flexibility differs"),
        (
            lambda m: {"omega": m.omega[:2], "Phi": m.Phi[:, :2]},
            "its model has 3 modes and 2 contact points, and now there are 2 and 2",
        ),
    ],
)
def test_other_models_are_refused(
    change: Callable[[ReducedModel], dict[str, Any]],
    told: str,
    plate_run: tuple[StoredRun, LinearAnalysis],
) -> None:
    stored, analysis = plate_run
    model = analysis.model
    changes = change(model)
    kept = {name: getattr(model, name) for name in ("omega", "Phi", "R", "gap")}
    with pytest.raises(StudyError, match=f"cannot be taken over, as {told}"):
        known_points(stored, ReducedModel(**{**kept, **changes}), EnergyContinuation(0.8, 1.1, 0.1))


def test_round_off_is_no_other_model(plate_run: tuple[StoredRun, LinearAnalysis]) -> None:
    stored, analysis = plate_run
    model, slightly = analysis.model, 1 + 2e-7
    near = ReducedModel(
        model.omega * slightly, model.Phi * slightly, model.R * slightly, model.gap * slightly
    )
    assert len(known_points(stored, near, EnergyContinuation(0.8, 1.1, 0.1))) == 4


def test_resumed_run_keeps_the_points_that_it_began_with(tmp_path: Path) -> None:
    """Stopped again before it has a point of its own, it has all that it took over."""
    text = toml(ROD)
    stopped(text, tmp_path, 3)  # there are no older results: moved to the folder itself
    (tmp_path / "mine.txt").write_text("mine")
    before = branch_file.read(tmp_path / "branch.h5")[1]
    wider = toml(changed(ROD, {"continuation": {"energies": {"to": 1.2}}}))
    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        failing_after(patch, 0, KeyboardInterrupt())
        run(wider, tmp_path, resume=True)
    (left,) = stopped_runs(tmp_path)
    after = branch_file.read(left.path / "branch.h5")[1]
    assert left.points == len(before) == 3
    for one, other in zip(before, after, strict=True):
        assert (one.gamma_ratio, one.motion.frequency) == (
            other.gamma_ratio,
            other.motion.frequency,
        )
        np.testing.assert_array_equal(one.motion.q, other.motion.q)
    result = run(wider, tmp_path, resume=True)
    assert result.branch.points[-1].gamma_ratio == pytest.approx(1.2)
    assert running_folders(tmp_path) == []  # all of it is in the new results
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_what_was_not_taken_over_stays(tmp_path: Path) -> None:
    text = toml(ROD)
    result = run(text, tmp_path)
    stopped(text, tmp_path, 3)
    stopped(toml(changed(ROD, {"mode": {"harmonics": 4}})), tmp_path, 2)
    one, other = stopped_runs(tmp_path)
    lower = replace(result.branch, points=result.branch.points[:2])
    remove_taken_over((one, other), text, lower)
    assert running_folders(tmp_path) == [one.path, other.path]
    remove_taken_over((Stopped(one.path, one.points, gone=False),), text, result.branch)
    assert running_folders(tmp_path) == [one.path, other.path]
    remove_taken_over((one, other), text, result.branch)
    assert running_folders(tmp_path) == [other.path]


def test_changed_mesh_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    text = toml(ROD)
    run(text, tmp_path)
    path = tmp_path / "branch.h5"
    header, points = branch_file.read(path)
    model = header.model
    stiffer = ReducedModel(model.omega * 1.01, model.Phi, model.R, model.gap)
    path.unlink()
    branch_file.create(path, replace(header, model=stiffer), Data({}), points)
    before = contents(tmp_path)
    with pytest.raises(StudyError, match=r"frequency 1 was \d.* Hz and is \d.* Hz now"):
        run(text, tmp_path, resume=True)
    assert contents(tmp_path) == before and running_folders(tmp_path) == []


def test_no_resume_beside_a_run_that_is_going_on(tmp_path: Path) -> None:
    text = toml(ROD)
    run(text, tmp_path)
    other = tmp_path / ".running-1"
    other.mkdir()
    descriptor = owner.take(other)
    try:
        with pytest.raises(StudyError, match=r"running-1: is of a run that is going on \(process"):
            run(text, tmp_path, resume=True)
        assert running_folders(tmp_path) == [other]
    finally:
        os.close(descriptor)


def test_resumed_branch_is_that_of_a_run_in_one_go(tmp_path: Path) -> None:
    """Stopped after any number of points, and gone on with by the command line."""
    text = toml(changed(ROD, {"continuation": {"energies": {"to": 1.6}, "report_at": []}}))
    whole = run(text, tmp_path / "whole").branch.points
    (tmp_path / "study.toml").write_text(text)
    for count in range(1, len(whole)):
        folder = tmp_path / str(count)
        stopped(text, folder, count)
        assert main(["run", str(tmp_path / "study.toml"), "--output", str(folder), "--resume"]) == 0
        resumed = branch_file.read(folder / "branch.h5")[1]
        assert running_folders(folder) == []
        assert len(resumed) == len(whole)
        for one, other in zip(resumed, whole, strict=True):
            assert one.gamma_ratio == other.gamma_ratio
            assert one.motion.frequency == pytest.approx(other.motion.frequency, rel=1e-9)
            assert one.status == other.status


def test_finished_branch_is_widened_without_finding_its_points_again(tmp_path: Path) -> None:
    text = toml(changed(ROD, {"continuation": {"report_at": []}}))
    before = run(text, tmp_path).branch.points
    wider = toml(
        changed(ROD, {"continuation": {"energies": {"from": 0.6, "to": 1.4}, "report_at": [1.25]}})
    )
    after = {point.gamma_ratio: point for point in run(wider, tmp_path, resume=True).branch.points}
    assert 1.25 in after
    assert min(after) == pytest.approx(0.6)
    assert max(after) == pytest.approx(1.4)
    for point in before:
        np.testing.assert_array_equal(after[point.gamma_ratio].motion.q, point.motion.q)
