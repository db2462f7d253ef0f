"""All files of a folder `fields`, of a run and of an export."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.fields.body import field_body
from fenics_nnm.fields.motion import OF_STRESS, MotionFiles
from fenics_nnm.fields.peak import peak_stress
from fenics_nnm.fields.selection import FieldName
from fenics_nnm.fields.stress_basis import stress_basis
from fenics_nnm.fields.surface import contact_surface
from fenics_nnm.fields.view import write_view
from fenics_nnm.fields.vtu import grid_file
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.output.stored_branch import StoredBranch

#: Gaps that differ by less than this part of their range are the same: in contact all are zero.
_TIE = 1e-9


def write_motions(
    folder: Path,
    branch: StoredBranch,
    points: Sequence[BranchPoint],
    *,
    fields: Sequence[FieldName],
    frames: int,
    on_progress: Callable[[float], None] = lambda done: None,
) -> None:
    """Write the motions of points of a branch, their shapes, peak stresses and view.py.

    Args:
        folder: Folder to write to; it has no such files yet.
        branch: Branch with its mesh and shapes.
        points: Points of it.
        fields: Fields wanted.
        frames: Frames of a period.
        on_progress: Called with the part done.

    Raises:
        OSError: if they cannot be written.
    """
    if not points:
        return
    body = field_body(branch)
    wanted = (OF_STRESS | {"peak_stress"}) & set(fields)
    stresses = stress_basis(branch, body, points) if wanted else None
    files = MotionFiles(folder, branch, body, stresses, contact_surface(branch), fields, frames)
    names = motion_names(points)
    for number, (name, point) in enumerate(zip(names, points, strict=True)):
        files.write(
            f"motion_{name}", point, lambda done: on_progress((number + done) / len(points))
        )
        if stresses and "peak_stress" in fields:
            peaks = peak_stress(stresses, point, frames)
            body.grid.write(folder / f"peak_stress_{name}.vtu", peaks)
    shapes = {}
    for name, point in zip(names, points, strict=True):
        shapes.update(_mode_shapes(branch, point, name.replace("_", " ")))
    grid = grid_file(branch.nodes, branch.cells, body.recovery.mesh.cell.written)
    grid.write(folder / "mode_shapes.vtu", shapes)
    write_view(folder, branch, dict(zip(names, points, strict=True)), fields)


def motion_names(points: Sequence[BranchPoint]) -> list[str]:
    """Names of motions by their energy; later passings of an energy get a number."""
    passed: Counter[float] = Counter()
    names = []
    for point in points:
        passed[point.gamma_ratio] += 1
        again = passed[point.gamma_ratio]
        names.append(f"{point.gamma_ratio:g}" + (f"_passing{again}" if again > 1 else ""))
    return names


def _mode_shapes(branch: StoredBranch, point: BranchPoint, name: str) -> dict[str, Array]:
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
    nearest, farthest = branch.displacement(point, phase[[closed, opened]])
    return {
        f"gamma {name} closed: displacement (m)": in_space(nearest),
        f"gamma {name} open: displacement (m)": in_space(farthest),
    }
