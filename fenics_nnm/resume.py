"""What a run can take over from an earlier one of the same study: its points."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import NonlinearModeError, StudyError
from fenics_nnm.nonlinear.continuation import Branch
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.output import branch_file
from fenics_nnm.output.branch_file import BranchHeader
from fenics_nnm.output.staging import Stopped, living_run, remove
from fenics_nnm.reduction.model import ReducedModel
from fenics_nnm.study import Study, study_from
from fenics_nnm.study_messages import shown

#: Keys that matter in sections that may differ: what is stepped is the position of a point. The
#: other keys there say which points are wanted and what is written of them.
_MATTER: dict[str, tuple[str, ...]] = {"title": (), "continuation": ("parameter",), "output": ()}

#: Largest difference of two reduced models that are the same, relative to the largest entry.
_SAME_MODEL = 1e-6

#: A point belongs to the wanted energies if it misses their ends by this part at most.
_SAME_RATIO = 1e-9


@dataclass(frozen=True, slots=True)
class StoredRun:
    """A run of the same study that points can be taken over from.

    Attributes:
        path: Its branch.h5.
        header: What holds for all its points.
        points: Its points that hold, by ascending energy.
    """

    path: Path
    header: BranchHeader
    points: tuple[BranchPoint, ...]


def stored_run(folder: Path, stopped: tuple[Stopped, ...], text: str) -> StoredRun | None:
    """The run to go on from: the stopped one with the most points, else the finished one.

    Args:
        folder: Results folder.
        stopped: What stopped runs left in it.
        text: Text of the study file.

    Returns:
        None if there is none with a point.

    Raises:
        StudyError: if there are runs of other studies alone; the line names the first key that
            differs.
        OutputError: if the finished run cannot be read.
    """
    by_points = sorted((run for run in stopped if run.points), key=lambda run: -run.points)
    paths = [run.path / "branch.h5" for run in by_points]
    paths += [path for path in [folder / "branch.h5"] if path.exists()]
    runs = [StoredRun(path, *branch_file.read(path)) for path in paths]
    runs = [run for run in runs if run.points]
    differences = [difference(run.header.study, text) for run in runs]
    for run, found in zip(runs, differences, strict=True):
        if not found:
            return run
    if runs:
        raise StudyError(f"{runs[0].path}: is of another study: {differences[0]}")
    return None


def assert_nobody_runs(folder: Path, *, but: Path) -> None:
    """Refuse to take over points in a folder where a run is going on.

    Args:
        folder: Results folder.
        but: Folder of the run that asks.

    Raises:
        StudyError: if there is another run.
    """
    living = living_run(folder, but=but)
    if living:
        raise StudyError(f"{living[0]}: is of a run that is going on ({living[1]}): let it end")


def difference(stored: str, wanted: str) -> str:
    """The first key in which two study files differ, among those that the points depend on.

    Args:
        stored: Text of the study file of the stored points.
        wanted: Text of the study file now.

    Returns:
        Key, stored and new value; nothing if the points of one are those of the other.
    """
    try:
        before = dict(_leaves(_study(stored)))
    except (NonlinearModeError, tomllib.TOMLDecodeError) as error:
        return f"its study file cannot be read by this version: {error}"
    now = dict(_leaves(_study(wanted)))
    in_file = [key for name in tomllib.loads(wanted) for key in now if key.startswith(f"{name}.")]
    for key in dict.fromkeys([*in_file, *now, *before]):
        if before.get(key) != now.get(key):
            return f"{key} was {_value(before.get(key))} and is {_value(now.get(key))} now"
    return ""


def known_points(
    run: StoredRun, model: ReducedModel, start: float, stop: float
) -> tuple[BranchPoint, ...]:
    """Stored points in a range of places, in the modal coordinates of a model.

    Modes are known up to their sign, so the columns of q take the signs of this model's modes.

    Args:
        run: Run to go on from.
        model: Model that the motions obey now (`model_in_contact`).
        start: First place along the branch: gamma ratio, or frequency ratio.
        stop: Last place.

    Raises:
        StudyError: if the stored model is another one.
    """
    reason = _model_difference(run.header.model, model)
    if reason:
        raise StudyError(
            f"{run.path}: its points cannot be taken over, as {reason}: has the mesh, or a matrix, "
            "changed?"
        )
    signs = _signs(run.header.model, model)
    low, high = start * (1 - _SAME_RATIO), stop * (1 + _SAME_RATIO)
    inside = [point for point in run.points if low <= point.position <= high]
    return tuple(replace(point, q=point.q * signs) for point in inside)


def remove_taken_over(stopped: tuple[Stopped, ...], text: str, branch: Branch) -> None:
    """Remove what stopped runs of a study left, where all their places are in a new branch."""
    places = {point.position for point in branch.points}
    for run in stopped:
        if not (run.gone and run.points):
            continue
        header, points = branch_file.read(run.path / "branch.h5")
        taken = all(point.position in places for point in points)
        if taken and not difference(header.study, text):
            remove(run.path)


def _study(text: str) -> Study:
    return study_from(tomllib.loads(text), Path("study.toml"))


def _leaves(study: Study) -> Iterator[tuple[str, Any]]:
    """Keys and values that the points depend on."""
    for section, values in study.model_dump(by_alias=True).items():
        for key in _MATTER.get(section, values or ()):
            yield f"{section}.{key}", values[key]


def _value(value: Any) -> str:
    return "not given" if value is None else shown(list(value) if type(value) is tuple else value)


def _model_difference(stored: ReducedModel, model: ReducedModel) -> str:
    """What differs between two reduced models, up to the signs of the modes; or nothing."""
    if stored.Phi.shape != model.Phi.shape:
        (points, modes), (points_now, modes_now) = stored.Phi.shape, model.Phi.shape
        return (
            f"its model has {modes} modes and {points} contact points, and now there are "
            f"{modes_now} and {points_now}"
        )
    frequencies = np.abs(model.omega / stored.omega - 1)
    if frequencies.max() > _SAME_MODEL:
        mode = int(np.argmax(frequencies > _SAME_MODEL))
        before, now = stored.omega[mode] / (2 * np.pi), model.omega[mode] / (2 * np.pi)
        return f"linear frequency {mode + 1} was {before:.9g} Hz and is {now:.9g} Hz now"
    if not _close(stored.gap, model.gap):
        return "the gaps differ"
    shapes = _close(stored.Phi, model.Phi * _signs(stored, model))
    if not shapes:
        return "the linear modes differ at the contact points"
    return "" if _close(stored.R, model.R) else "the residual flexibility differs"


def _signs(stored: ReducedModel, model: ReducedModel) -> Array:
    """The sign of each mode of a model in terms of the stored ones, shape (J,).

    A mode that is still at all contact points has either: no motion in contact has a part of it.
    """
    return np.where(np.einsum("ij,ij->j", stored.Phi, model.Phi) < 0, -1.0, 1.0)


def _close(stored: Array, found: Array) -> bool:
    return bool(np.abs(found - stored).max() <= _SAME_MODEL * np.abs(stored).max())
