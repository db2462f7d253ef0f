"""branch.h5: everything needed to plot, export or restart without solving the mesh again.

Layout (SI units):

    /                    attributes: format, study (TOML), versions (JSON), reason, inputs (JSON:
                         digest of each file that the study names, by key)
    /model               omega, Phi, R, gap of the reduced model; kinematics, if of second order:
                         Theta, alpha, beta, D; attribute: masters (from 0)
    /contact             points, directions, areas, patches (their numbers, from 0), patch_names;
                         facets (their nodes in VTK order), facet_patch and facet_side (0 for its
                         own, 1 for those opposite); pressures, three rows: node, contact point,
                         pressure in Pa there per N of its force; of a mesh only
    /series              attributes: mode (from 1), harmonics, samples, modes (of the reduction),
                         series
    /mesh                points, cells (VTK order), cell_type (VTK), region of each cell; of a
                         mesh only; cells as in the input mesh, nodes as these cells name them
    /input_mesh          the mesh as it was read, before it was spread over ranks: kind (gmsh's
                         number of the cells, dimension), points, cells (gmsh order), parts (nodes
                         of the facets, cells and nodes of named groups), words (JSON: their names
                         and shapes, masses, springs, constraints, notes), metres in one unit of
                         points; of a mesh only
    /material            elasticity (rows, 6, strains), stress in Pa in the order XX YY ZZ XY YZ XZ
                         of the strains xx; xx, yy, 2 xy; or xx, yy, zz, 2 xy, 2 yz, 2 xz; row of
                         each cell at each point where its stress is taken; of a mesh only
    /basis               shapes (J, nodes, dim), residual_shapes (n_c, nodes, dim) of a mesh;
                         shapes (J, n), residual_shapes (n_c, n) in the order of the n unknowns of
                         matrices: u = shapes^T q - residual_shapes^T lambda; with second-order
                         kinematics bent_shapes (p, nodes, dim) or (p, n) of the pairs i <= j of
                         masters in the order (0, 0), (0, 1) .. (1, 1) ..: theta_ij q_i q_j is
                         added for i < j, and half of it for i = j
    /inertia/000000 ...  harmonics in m, (N + 1, nodes, dim), of the displacement that full order
                         adds to the point at the attribute position, if it has ParaView files
    /points/000000 ...   q (N + 1, J), force (m // 2 + 1, n_c), free (N + 1, n_c), multipliers
                         (2 J - 2, complex; none if not known); extremes, rows of value, node (from
                         0), x, y, z in m: largest displacement in m; von Mises stress in Pa away
                         from singular places, and anywhere; the same of the largest principal
                         stress; margins of yield and of Goodman's line; extreme_numbers: contact
                         force in N, impulse in N s, 99.9 % quantiles of both stresses, kinds of the
                         places of both largest ones; extreme_patches (patches, 3): displacement in
                         m, force, impulse of each (all three empty if they were not measured);
                         attributes: scalars of the point; by position

The file of a finished run has all of this. While a run goes on, and after it was killed, points
are in the folder `branch.points` beside it (see `journal`), and `read` looks there. In the end it
is replaced at one instant by a file with the points, so that it opens whenever a run is killed.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.fem.blocks import Blocks, Data
from fenics_nnm.results import journal
from fenics_nnm.results.durable import replacing
from fenics_nnm.results.hdf5 import ONCE, Writing, add_blocks, opened, reading, sealed
from fenics_nnm.results.header import BranchHeader, header_in, image
from fenics_nnm.results.journal import Journal
from fenics_nnm.results.seal import break_seal, seal
from fenics_nnm.results.stored_point import (
    ARRAYS,
    SCALARS,
    arrays_of,
    point_from,
    scalars_of,
)

FORMAT = "fenics_nnm branch 6"

#: More bytes than HDF5 needs to note a point besides its arrays.
_OVERHEAD = 8192


def create(path: Path, header: BranchHeader, data: Data, known: Sequence[BranchPoint] = ()) -> None:
    """Make a new file without points, and the journal beside it that its points go to.

    Args:
        path: File to make, in a folder without one.
        header: What holds for all points.
        data: Further data sets by their place in the file, such as "mesh/points".
        known: Points of an earlier run to begin with.

    Raises:
        OutputError: if it cannot be written.
    """
    with Writing(path):
        with replacing(path) as part:
            part.write_bytes(image(header, data, FORMAT))
            add_blocks(part, data.blocks)
            seal(part)
        journal.begin(path, known)


def append(points: Journal, point: BranchPoint) -> None:
    """Keep a converged point; it cannot be lost once this returns.

    Raises:
        OutputError: if it cannot be written.
    """
    with Writing(points.folder):
        points.append(point)


def finish(path: Path, branch: Branch) -> None:
    """Put the points of a branch in the file, with the reason of its end.

    Raises:
        OutputError: if it cannot be written; the points are still in the journal.
    """
    _fill(path, branch.points, reason=branch.reason)


def add_inertia(path: Path, inertia: Mapping[float, Blocks]) -> None:
    """Add what full order adds to the displacement of points, by their position.

    Raises:
        OutputError: if it cannot be written; the file is as it was then.
    """
    names = [f"inertia/{number:06d}" for number in range(len(inertia))]
    with Writing(path), replacing(path) as part:
        shutil.copyfile(path, part)
        break_seal(part)
        add_blocks(part, dict(zip(names, inertia.values(), strict=True)))
        with opened(part, ONCE) as file:
            for name, position in zip(names, inertia, strict=True):
                file[name].attrs["position"] = position
        seal(part)


def gather(path: Path) -> None:
    """Put what a run that was stopped left in its journal in the file.

    Raises:
        OutputError: if it cannot be written; the points are still in the journal.
    """
    if journal.folder_beside(path).exists():
        _fill(path, read(path)[1])


def read(path: Path) -> tuple[BranchHeader, tuple[BranchPoint, ...]]:
    """Header and the points that hold, by position, of any run, finished or not.

    Raises:
        OutputError: if the file cannot be read or is of another kind.
    """
    with reading(path):
        unfinished = journal.read(path)  # first, as a run may be just finishing
        with sealed(path, FORMAT) as file:
            points = [_point(group) for group in file["points"].values()] or unfinished
            latest = {point.position: point for point in points}
            return header_in(file), tuple(latest[place] for place in sorted(latest))


def study_text(path: Path) -> str:
    """Text of the study file of any run, finished or not; its points are not read.

    Raises:
        OutputError: if the file cannot be read or is of another kind.
    """
    with sealed(path, FORMAT) as file:
        return str(file.attrs["study"])


def _fill(path: Path, points: Sequence[BranchPoint], **attributes: str) -> None:
    """Replace the file by one with these points; the journal is not needed any more then."""
    size = sum(array.nbytes for point in points for array in arrays_of(point).values())
    with Writing(path), replacing(path) as part:
        shutil.copyfile(path, part)
        break_seal(part)
        with opened(part, size + _OVERHEAD * len(points) + ONCE) as file:
            file.attrs.update(attributes)
            del file["points"]
            for number, point in enumerate(points):
                group = file.create_group(f"points/{number:06d}")
                for name, array in arrays_of(point).items():
                    group[name] = array
                group.attrs.update(scalars_of(point))
            file.require_group("points")
        seal(part)
    shutil.rmtree(journal.folder_beside(path), ignore_errors=True)


def _point(group: h5py.Group) -> BranchPoint:
    scalars: dict[str, Any] = {name: group.attrs[name] for name in SCALARS if name in group.attrs}
    for name, value in scalars.items():
        scalars[name] = value.item() if isinstance(value, np.generic) else value
    return point_from(scalars, {name: np.array(group[name]) for name in ARRAYS if name in group})
