"""Middle nodes of quadratic cells: each edge has one, which is nothing else."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cell_shapes import shape_of
from fenics_nnm.fem.row_numbers import row_numbers


def assert_middles(name: str, cells: dict[str, Indices], numbers: Indices) -> None:
    """Refuse cells that do not fit each other along an edge.

    Args:
        name: What is read, for messages.
        cells: Cells of each kind, all of one dimension.
        numbers: Number of each cell in the file, those of the first kind first.

    Raises:
        MeshError: if an edge has two middle nodes, or a middle node is that of two edges or a
            corner.
    """
    ends, nodes, owners = _edges(cells)
    if not len(nodes):
        return
    corners = np.concatenate(
        [rows[:, : shape_of(kind).corners].ravel() for kind, rows in cells.items()]
    )
    is_corner = np.zeros(max(int(corners.max()), int(nodes.max())) + 1, dtype=bool)
    is_corner[corners] = True
    edge = row_numbers(ends)
    node_of_edge = np.full(int(edge.max()) + 1, -1, dtype=np.int64)
    node_of_edge[edge] = nodes
    edge_of_node = np.full(len(is_corner), -1, dtype=np.int64)
    edge_of_node[nodes] = edge
    wrong = np.flatnonzero(
        (node_of_edge[edge] != nodes) | (edge_of_node[nodes] != edge) | is_corner[nodes]
    )
    if len(wrong):
        raise MeshError(
            f"{name}: {len(np.unique(owners[wrong]))} elements do not fit their neighbours: a "
            f"middle node is missing, or that of another edge, or a corner; one is element "
            f"{int(numbers[owners[wrong[0]]])}"
        )


def _edges(cells: dict[str, Indices]) -> tuple[Indices, Indices, Indices]:
    """Sorted ends of all edges that have a length, their middle nodes, and their cells."""
    ends, nodes, owners, start = [], [], [], 0
    for kind, rows in cells.items():
        shape = shape_of(kind)
        if rows.shape[1] > shape.corners:
            pairs = np.sort(rows[:, np.array(shape.edges)], axis=2).reshape(-1, 2)
            middles = rows[:, shape.corners : shape.corners + len(shape.edges)].ravel()
            real = pairs[:, 0] != pairs[:, 1]
            ends.append(pairs[real])
            nodes.append(middles[real])
            owners.append(np.repeat(start + np.arange(len(rows)), len(shape.edges))[real])
        start += len(rows)
    if not ends:
        none = np.empty(0, dtype=np.int64)
        return none.reshape(0, 2), none, none
    return np.concatenate(ends), np.concatenate(nodes), np.concatenate(owners)
