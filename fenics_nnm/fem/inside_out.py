"""Cells that a displacement turns inside out, which no load does to a body.

Equations of large deflection have states with such cells, which are often stable. Newton's method
gets there where a load is far beyond what the body bears.
"""

from __future__ import annotations

import numpy as np
from dolfinx import fem

from fenics_nnm.arrays import Array
from fenics_nnm.fem.compat import cell_nodes

#: Corners, and three (or fewer) others that edges lead to from each, by the kind of a cell.
_CORNERS: dict[str, tuple[tuple[int, ...], ...]] = {
    "interval": ((0, 1),),
    "triangle": ((0, 1, 2),),
    "tetrahedron": ((0, 1, 2, 3),),
    "quadrilateral": tuple((c, c ^ 1, c ^ 2) for c in range(4)),
    "hexahedron": tuple((c, c ^ 1, c ^ 2, c ^ 4) for c in range(8)),
}


def turned_inside_out(displacement: fem.Function) -> int:
    """Number of cells of all ranks that a displacement turns inside out; called on all ranks.

    The volumes of the corners of each cell, which its straight edges span, must keep their sign.

    Args:
        displacement: Displacement in m.
    """
    space = displacement.function_space
    mesh = space.mesh
    corners = _CORNERS.get(mesh.topology.cell_name(), ())
    if not corners:
        return 0
    owned, dim = mesh.topology.index_map(mesh.topology.dim).size_local, mesh.topology.dim
    places = mesh.geometry.x[cell_nodes(mesh)[:owned], :dim]
    moved = displacement.x.array.reshape(-1, dim)[space.dofmap.list[:owned]]
    count = max(map(max, corners)) + 1
    before, after = places[:, :count], places[:, :count] + moved[:, :count]
    turned = np.zeros(owned, dtype=bool)
    for corner in corners:
        turned |= _volume(after, corner) * _volume(before, corner) <= 0
    return int(mesh.comm.allreduce(int(turned.sum())))


def _volume(places: Array, corner: tuple[int, ...]) -> Array:
    """Determinant of the edges from a corner, over their lengths, of each cell."""
    first, *others = corner
    edges = places[:, others] - places[:, [first]]
    return np.linalg.det(edges / np.linalg.norm(edges, axis=2).max(axis=1)[:, None, None])
