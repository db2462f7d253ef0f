"""What a run can take over from an earlier one of the same study: its points."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch, Wanted
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.errors import NonlinearModeError, StudyError
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.comparison import mode_signs, model_difference
from fenics_nnm.results import branch_file
from fenics_nnm.results.branch_file import BranchHeader
from fenics_nnm.results.staging import Stopped, living_run, remove
from fenics_nnm.results.stored_text import values_of
from fenics_nnm.study import Study, study_from
from fenics_nnm.study.leaves import leaves
from fenics_nnm.study.messages import shown

#: Sections of a study that may differ: they say which points are wanted and what is written of
#: them, or, as units, nothing once it is read. Of the continuation some keys matter, see `_leaves`.
_FREE = (
    "title",
    "length_unit",
    "continuation",
    "damping",
    "dashpot",
    "excitation",
    "monitor",
    "response",
    "output",
)

#: Of these, those that damped motions depend on.
_DAMPED = ("damping", "dashpot", "excitation")


LeavesOf = Callable[[Study], Iterator[tuple[str, Any]]]
"""What gives keys of a study with their values."""


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


def assert_nobody_runs(folder: Path, *, but: Path | None = None) -> None:
    """Refuse to begin, or to take over points, in a folder where a run is going on.

    Args:
        folder: Results folder.
        but: Folder of the run that asks, if it has one already.

    Raises:
        StudyError: if there is another run.
    """
    living = living_run(folder, but=but)
    if living:
        raise StudyError(f"{living[0]}: is of a run that is going on ({living[1]}): let it end")


def difference(stored: str, wanted: str, leaves_of: LeavesOf | None = None) -> str:
    """The first key in which two study files differ, among those that the points depend on.

    Args:
        stored: Text of the study file of the stored points.
        wanted: Text of the study file now.
        leaves_of: Gives the keys and values of a study that points depend on; by default those of
            a branch.

    Returns:
        Key, stored and new value; nothing if the points of one are those of the other.
    """
    leaves_of = leaves_of or _leaves
    try:
        before = dict(leaves_of(_study(stored)))
    except (NonlinearModeError, tomllib.TOMLDecodeError) as error:
        return f"its study file cannot be read by this version: {error}"
    now = dict(leaves_of(_study(wanted)))
    in_file = [key for name in values_of(wanted) for key in now if key.startswith(f"{name}.")]
    for key in dict.fromkeys([*in_file, *now, *before]):
        if before.get(key) != now.get(key):
            return f"{key} was {_value(before.get(key))} and is {_value(now.get(key))} now"
    return ""


def assert_written_in(run: StoredRun, series: str) -> None:
    """Refuse points of a run whose motions are of another kind: undamped, or damped.

    Raises:
        StudyError: if they are.
    """
    if run.header.series != series:
        raise StudyError(
            f"{run.path}: its motions are written in a {run.header.series} series, those of this "
            f"run in a {series} one (damped motions, or another version): begin anew"
        )


def known_points(run: StoredRun, model: ReducedModel, wanted: Wanted) -> tuple[BranchPoint, ...]:
    """Stored points that are wanted again, in the modal coordinates of a model.

    Modes are known up to their sign, so the columns of q take the signs of this model's modes.

    Args:
        run: Run to go on from.
        model: Model that the motions obey now (`model_in_contact`).
        wanted: Which motions are wanted. Of a branch that is followed by its length the points up
            to where it leaves the range of energies are.

    Raises:
        StudyError: if the stored model is another one.
    """
    reason = model_difference(run.header.model, model)
    if reason:
        raise StudyError(
            f"{run.path}: its points cannot be taken over, as {reason}: has the mesh, or a matrix, "
            "changed?"
        )
    signs = mode_signs(run.header.model, model)
    return tuple(_with_signs(point, signs) for point in wanted.still_wanted(run.points))


def _with_signs(point: BranchPoint, signs: Array) -> BranchPoint:
    """A point in modal coordinates of other signs."""
    return replace(point, motion=replace(point.motion, q=point.motion.q * signs))


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
    return study_from(dict(values_of(text)), Path("study.toml"))


def _leaves(study: Study) -> Iterator[tuple[str, Any]]:
    """Keys and values that the points, or their positions along the branch, depend on."""
    free = _FREE if not study.damped else tuple(name for name in _FREE if name not in _DAMPED)
    for section, values in study.model_dump(by_alias=True).items():
        if section not in free and values not in (None, [], ()):
            yield from leaves(section, values)
    yield from study.continuation.position_keys()
    if study.damped:
        yield "continuation.damped", True


def _value(value: Any) -> str:
    return "not given" if value is None else shown(list(value) if type(value) is tuple else value)
