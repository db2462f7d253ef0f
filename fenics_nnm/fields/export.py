"""Files of any points of a finished run or response, from branch.h5 or response.h5 alone."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.errors import OutputError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fields.driven import of_response
from fenics_nnm.fields.files import Shown, write_motions
from fenics_nnm.fields.named import of_branch
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.reported import nearest
from fenics_nnm.results import response_file
from fenics_nnm.results.response_file import StoredResponse
from fenics_nnm.results.stored_branch import StoredBranch, read_stored_branch

#: Two gamma ratios nearer than this are the same.
_SAME_RATIO = 1e-6


def export(
    file: Path,
    folder: Path,
    ratios: Sequence[float],
    *,
    shown: Shown,
    comm: MPI.Intracomm,
    on_progress: Callable[[float], None] = lambda done: None,
) -> list[BranchPoint]:
    """Write the files that a run writes, of the points nearest to some gamma ratios.

    Args:
        file: branch.h5 of a run.
        folder: Folder to make.
        ratios: Gamma ratios; of each the nearest point, or all passings of that energy.
        shown: Fields, frames and format wanted.
        comm: Communicator; all ranks call this, and share the work.
        on_progress: Called with the part done.

    Returns:
        The points, by their position.

    Raises:
        OutputError: if the file cannot be read, has no mesh or no such motion, or the folder is
            there already or cannot be written.
    """

    def nearest(branch: StoredBranch) -> list[BranchPoint]:
        return _nearest(branch, ratios)

    return export_points(file, folder, nearest, shown=shown, comm=comm, on_progress=on_progress)


def export_points(
    file: Path,
    folder: Path,
    choose: Callable[[StoredBranch], list[BranchPoint]],
    *,
    shown: Shown,
    comm: MPI.Intracomm,
    on_progress: Callable[[float], None] = lambda done: None,
) -> list[BranchPoint]:
    """The same of points that are chosen from the branch, on rank 0, which has some.

    Raises:
        OutputError: as `export`.
    """
    points = on_root(comm, _begun, file, folder, choose)
    with _whole_or_not(folder, comm):
        write_motions(
            folder,
            partial(read_stored_branch, file),
            of_branch(points),
            shown=shown,
            comm=comm,
            on_progress=on_progress,
        )
    return points


@dataclass(frozen=True, slots=True)
class AtFrequencies:
    """Motions of a response that are wanted.

    Attributes:
        frequencies: Frequencies in Hz: of each the nearest motion, or all at that frequency.
        level: Level of the forces; None for all.
    """

    frequencies: Sequence[float]
    level: float | None = None


def export_response(
    file: Path,
    folder: Path,
    wanted: AtFrequencies,
    *,
    shown: Shown,
    comm: MPI.Intracomm,
    on_progress: Callable[[float], None] = lambda done: None,
) -> list[ResponsePoint]:
    """Write the files that a response writes, of the motions nearest to some frequencies.

    Args:
        file: response.h5 of a response.
        folder: Folder to make.
        wanted: Which motions.
        shown: Fields, frames and format wanted.
        comm: Communicator; all ranks call this, and share the work.
        on_progress: Called with the part done.

    Returns:
        The motions.

    Raises:
        OutputError: if the file cannot be read, has no mesh or no such motion, or the folder is
            there already or cannot be written.
    """
    stored, numbers = on_root(comm, _response_begun, file, folder, wanted)
    points = stored.found.points
    with _whole_or_not(folder, comm):
        write_motions(
            folder,
            partial(response_file.read_body, file),
            of_response(stored.header, points, numbers, stored.gap_motion),
            shown=shown,
            comm=comm,
            on_progress=on_progress,
        )
    return [points[number] for number in numbers]


def _response_begun(
    file: Path, folder: Path, wanted: AtFrequencies
) -> tuple[StoredResponse, list[int]]:
    """Make the folder, and list the numbers of the motions that are wanted."""
    stored = response_file.read(file)
    response_file.read_body(file)  # refuses what has no mesh
    levels = stored.found.levels
    if wanted.level is not None and wanted.level not in levels:
        listed = ", ".join(f"{each:g}" for each in levels)
        raise OutputError(f"{file}: has no level {wanted.level:g}: must be one of {listed}")
    chosen = levels if wanted.level is None else (wanted.level,)
    numbers = {n for each in wanted.frequencies for n in nearest(stored.found, each, chosen)}
    if not numbers:
        raise OutputError(f"{file}: has no motions")
    _make(folder)
    return stored, sorted(numbers)


@contextmanager
def _whole_or_not(folder: Path, comm: MPI.Comm) -> Iterator[None]:
    """Remove a folder that cannot be written in full.

    Raises:
        OutputError: in place of an error of the operating system.
    """
    try:
        yield
    except BaseException as error:
        if comm.rank == 0:
            shutil.rmtree(folder, ignore_errors=True)
        if isinstance(error, OSError):
            raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error
        raise


def _begun(
    file: Path, folder: Path, choose: Callable[[StoredBranch], list[BranchPoint]]
) -> list[BranchPoint]:
    """Make the folder, and list the points that are wanted."""
    branch = read_stored_branch(file)
    if not branch.points:
        raise OutputError(f"{file}: has no points")
    points = choose(branch)
    if _is_full_order(branch):
        for point in points:
            _assert_whole(file, branch, point)
    _make(folder)
    return points


def _is_full_order(branch: StoredBranch) -> bool:
    """Whether contact points move by more than the shapes of the branch."""
    method = branch.header.values.get("reduction", {}).get("method")
    return bool(method == "none")


def _nearest(branch: StoredBranch, ratios: Sequence[float]) -> list[BranchPoint]:
    have = np.array([point.gamma_ratio for point in branch.points])
    chosen = np.zeros(len(have), dtype=bool)
    for ratio in ratios:
        nearest = have[np.argmin(np.abs(have - ratio))]
        chosen |= np.abs(have - nearest) <= _SAME_RATIO
    return [point for point, wanted in zip(branch.points, chosen, strict=True) if wanted]


def _assert_whole(file: Path, branch: StoredBranch, point: BranchPoint) -> None:
    if point.position not in branch.inertia:
        whole = [f"{p.gamma_ratio:g}" for p in branch.points if p.position in branch.inertia]
        raise OutputError(
            f"{file}: gamma ratio {point.gamma_ratio:g}: at full order only the motions of "
            f"continuation.report_at are kept whole: {', '.join(whole) or 'none'}"
        )


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True)
    except FileExistsError as error:
        raise OutputError(f"{folder}: is there already: name a new folder by --output") from error
    except OSError as error:
        raise OutputError(f"{folder}: cannot be made: {error.strerror or error}") from error
