"""All files of a folder `fields`, of a run and of an export, written by several ranks.

Stresses are found part by part of the body, and each part is one rank's. They are kept in a table
on the disk until the files are there. Then each rank writes whole files of its own. What is
computed together does not depend on the number of ranks, so that files do not either.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.fem.parallel import beside_root, each_own, on_root
from fenics_nnm.field_names import FieldName, FileFormat
from fenics_nnm.fields.body import field_body
from fenics_nnm.fields.frame_files import frame_files
from fenics_nnm.fields.frames import Frames
from fenics_nnm.fields.kept_bases import KeptBases
from fenics_nnm.fields.motion import Motion, MotionFiles, batches
from fenics_nnm.fields.named import NamedMotion
from fenics_nnm.fields.parts import NODES_OF_PART, compact_parts
from fenics_nnm.fields.shapes import motion_shapes
from fenics_nnm.fields.stress_rows import StressRows
from fenics_nnm.fields.surface import contact_surface
from fenics_nnm.fields.table import PartTable
from fenics_nnm.fields.view import write_view
from fenics_nnm.fields.vtu import grid_file
from fenics_nnm.results.stored_branch import PlacedMotion, StoredBranch

#: Gaps that differ by less than this part of their range are the same: in contact all are zero.
_TIE = 1e-9

#: Name of the table of stresses while files are written.
_TABLE = ".stresses"

Reader = Callable[[], StoredBranch]
"""Something that reads what motions are made of, on each rank for itself."""

Task = Callable[[], None]
"""Something that one rank does alone."""


@dataclass(frozen=True, slots=True)
class Shown:
    """What is shown of motions.

    Attributes:
        fields: Fields wanted.
        frames: Frames of a period.
        form: Format of the files of their frames.
        bases: Stresses of their shapes that are known already, on some ranks.
    """

    fields: Sequence[FieldName]
    frames: int
    form: FileFormat = "vtu"
    bases: KeptBases = field(default_factory=KeptBases)


def write_motions(
    folder: Path,
    read: Reader,
    motions: Sequence[NamedMotion],
    *,
    shown: Shown,
    comm: MPI.Intracomm,
    on_progress: Callable[[float], None] = lambda done: None,
) -> None:
    """Write motions, their shapes, peak stresses and view.py.

    All ranks call this; those on the machine of the first one share the work.

    Args:
        folder: Folder to write to; it has no such files yet.
        read: Reads the mesh and the shapes that the motions are made of.
        motions: The motions, the same on all ranks.
        shown: What is shown of them.
        comm: Communicator of the ranks.
        on_progress: Called with the part done.

    Raises:
        OSError: if they cannot be written.
        OutputError: if the branch cannot be read.
    """
    if not motions:
        return
    own, count = beside_root(comm)
    writers = each_own(comm, (_motion_files(folder, read(), motions, shown) for _ in own))
    first, done = writers[0].rows.count if writers else 0, 0.0
    listed = [Motion(motion, number * first) for number, motion in enumerate(motions)]
    on_root(comm, lambda: writers[0].begin(listed))
    for tasks_of, end in ((_stress_tasks, 0.6), (_file_tasks, 1.0)):
        tasks = [task for files in writers for task in tasks_of(files, listed)[own.start :: count]]
        each_own(comm, _done_of(tasks, on_progress, done, end))
        done = end
    on_root(comm, lambda: writers[0].end(listed))


def _motion_files(
    folder: Path,
    branch: StoredBranch,
    motions: Sequence[NamedMotion],
    shown: Shown,
) -> MotionFiles:
    body = field_body(branch)
    frames = Frames(shown.frames, reversible=not branch.series.free_phase)
    rows = StressRows(shown.fields, frames, beside_linear=not branch.driven)
    parts = compact_parts(body.mesh.nodes, NODES_OF_PART)
    surface = contact_surface(branch)
    return MotionFiles(
        folder=folder,
        shapes=motion_shapes(branch, [motion.point for motion in motions]),
        body=body,
        surface=surface,
        rows=rows,
        table=PartTable(folder / _TABLE, parts, len(motions) * rows.count),
        body_frames=frame_files(shown.form, body.grid),
        surface_frames=frame_files(shown.form, surface.grid),
        bases=shown.bases,
    )


def _stress_tasks(files: MotionFiles, motions: Sequence[Motion]) -> list[Task]:
    if not files.rows.count:
        return []
    used = files.used(motions)
    parts = range(len(files.table.parts))
    return [partial(files.keep_stresses, part, used, motions) for part in parts]


def _file_tasks(files: MotionFiles, motions: Sequence[Motion]) -> list[Task]:
    tasks: list[Task] = []
    if files.has_body:
        few = files.body_frames.together(batches(files.rows.frames))
        tasks += [partial(files.write_body, motion, each) for motion in motions for each in few]
    if "peak_stress" in files.rows.fields:
        tasks += [partial(files.write_peaks, motion) for motion in motions]
    if files.has_surface:
        tasks += [partial(files.write_surface, motion) for motion in motions]
    shared = [_write_mode_shapes, _write_view]
    return [*tasks, *(partial(write, files, motions) for write in shared)]


def _done_of(
    tasks: Sequence[Task], on_progress: Callable[[float], None], begin: float, end: float
) -> Iterator[None]:
    """Do tasks, and report which part of the whole is done."""
    for number, task in enumerate(tasks):
        task()
        on_progress(begin + (end - begin) * (number + 1) / len(tasks))
        yield


def _write_view(files: MotionFiles, motions: Sequence[Motion]) -> None:
    first = max(motions, key=lambda motion: motion.named.weight)
    suffix = files.body_frames.suffix
    write_view(files.folder, files.shapes.branch, first.named, files.rows.fields, suffix)


def _write_mode_shapes(files: MotionFiles, motions: Sequence[Motion]) -> None:
    branch = files.shapes.branch
    grid = grid_file(branch.nodes, branch.cells, files.body.mesh.cell.written)
    names = [
        f"{motion.named.short} {state}: displacement (m)"
        for motion in motions
        for state in ("closed", "open")
    ]
    shapes = (shape for motion in motions for shape in _mode_shapes(branch, motion.point))
    grid.write_each(files.folder / "mode_shapes.vtu", names, map(in_space, shapes))


def _mode_shapes(branch: StoredBranch, point: PlacedMotion) -> Array:
    """The shapes of a motion where the contact point that moves most is nearest and farthest.

    Where all points stay closed it is the one whose force changes most, most and least pressed.
    """
    phase = 2 * np.pi * np.arange(branch.header.samples) / branch.header.samples
    gap, (begin,) = branch.gap(point, phase), branch.displacement(point, phase[:1])
    if np.ptp(gap) <= _TIE * np.abs(begin).max():
        gap = -branch.forces(point, phase)
    moves_most = int(np.argmax(np.ptp(gap, axis=0)))
    moved, tie = gap[:, moves_most], _TIE * np.ptp(gap)
    closed, opened = np.argmax(moved <= moved.min() + tie), np.argmax(moved >= moved.max() - tie)
    return branch.displacement(point, phase[[closed, opened]])
