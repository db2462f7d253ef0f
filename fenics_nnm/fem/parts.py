"""Parts of a mesh that have no node in common, and nodes of different parts at one place."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.compat import cell_nodes
from fenics_nnm.fem.solid import Solid

#: Distance over the shortest edge below which two nodes are at one place.
_SAME_PLACE = 1e-6

#: Most parts that a message lists.
_MOST_LISTED = 3


def parts_that_move(solid: Solid) -> str:
    """What parts of a body nothing holds, and which nodes at one place are not joined.

    All ranks call this; "" for a body of one piece.
    """
    dim = solid.tagged.dim
    cells, points, held = _gathered(solid)
    count = len(points)
    pairs = cells[:, 1:].ravel()
    first = np.repeat(cells[:, 0], cells.shape[1] - 1)
    joined = coo_array((np.ones(len(pairs)), (first, pairs)), shape=(count, count))
    number, part = connected_components(joined, directed=False)
    if number < 2:
        return ""
    free = [k for k in range(number) if not held[part == k].any()]
    boxes = [_box(points[part == k][:, :dim]) for k in free[:_MOST_LISTED]]
    words = f"; the mesh is of {number} parts without common nodes"
    if boxes:
        words += f", of which nothing holds {', '.join(boxes)}"
        words += f" and {len(free) - _MOST_LISTED} more" if len(free) > _MOST_LISTED else ""
    edges = np.linalg.norm(points[cells[:, 0]] - points[cells[:, 1]], axis=1)
    same = KDTree(points).query_pairs(_SAME_PLACE * float(edges.min()))
    same = {pair for pair in same if part[pair[0]] != part[pair[1]]}
    if same:
        where = ", ".join(f"{x:.6g}" for x in points[min(same)[0], :dim])
        words += (
            f"; {len(same)} pairs of nodes lie at one place, one at ({where}) m: merge the nodes "
            "where the parts should be joined"
        )
    return words


def _gathered(solid: Solid) -> tuple[Indices, Array, Array]:
    """Cells by their corners, places of the corners, and which are held, the same on all ranks."""
    mesh = solid.tagged.mesh
    corners = mesh.topology.connectivity(mesh.topology.dim, 0)
    own = mesh.topology.index_map(mesh.topology.dim).size_local
    width = len(corners.links(0)) if own else 0
    nodes = cell_nodes(mesh)[:own, :width]
    blocks = solid.space.dofmap.list[:own, :width]
    numbers = np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)
    dim = solid.tagged.dim
    fixed = np.isin(blocks[..., None] * dim + np.arange(dim), solid.clamped).any(axis=2)
    parts = (numbers[nodes], mesh.geometry.x[nodes], fixed)
    gathered = [
        np.concatenate([part.reshape(len(part), -1) for part in found if len(part)])
        for found in zip(*mesh.comm.allgather(parts), strict=True)
    ]
    unique, place = np.unique(gathered[0], return_inverse=True)
    place = place.reshape(gathered[0].shape)
    points = np.zeros((len(unique), 3))
    points[place.ravel()] = gathered[1].reshape(-1, 3)
    held = np.zeros(len(unique), dtype=bool)
    held[place[gathered[2].astype(bool)]] = True
    return place, points, held


def _box(points: Array) -> str:
    ranges = zip(points.min(axis=0), points.max(axis=0), strict=True)
    return " x ".join(f"[{low:.5g}, {high:.5g}]" for low, high in ranges) + " m"
