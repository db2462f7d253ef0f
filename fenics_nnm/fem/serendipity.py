"""Quadratic elements without inner nodes, given the nodes that complete them.

dolfinx maps cells by complete Lagrange bases, while Abaqus, CalculiX and Nastran write elements of
20 and 8 nodes. Their shape functions lie in the complete space, so nodes added at the values of
the old map leave the geometry as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: gmsh's numbers of the 8-node quadrangle and the 20-node hexahedron, and of the complete ones.
_QUADRANGLE, _HEXAHEDRON = 16, 17
_COMPLETE = {_QUADRANGLE: 10, _HEXAHEDRON: 12}

#: Corners and middle nodes of the faces of a hexahedron, in gmsh's order of the faces' nodes.
_FACES = np.array(
    [
        [0, 1, 2, 3, 8, 11, 13, 9],
        [0, 1, 5, 4, 8, 12, 16, 10],
        [0, 3, 7, 4, 9, 15, 17, 10],
        [1, 2, 6, 5, 11, 14, 18, 12],
        [2, 3, 7, 6, 13, 15, 19, 14],
        [4, 5, 6, 7, 16, 18, 19, 17],
    ]
)


@dataclass(frozen=True, slots=True)
class CompleteCells:
    """Cells of a complete basis, with the points added for them.

    Attributes:
        cell_type: gmsh's number of the element type.
        points: All coordinates, shape (nodes, 3).
        cells: Rows of `points` in gmsh's order, shape (cells, nodes a cell).
        face_corners: Sorted corners of each face that got a node, in ascending order of rows.
        face_nodes: That node, as a row of `points`.
    """

    cell_type: int
    points: Array
    cells: Indices
    face_corners: Indices
    face_nodes: Indices

    def facets(self, nodes: Indices) -> Indices:
        """Facets of 8 nodes with their ninth one; other facets as they are."""
        if nodes.shape[1] != 8:
            return nodes
        corners = np.sort(nodes[:, :4], axis=1)
        both = np.concatenate([self.face_corners, corners])
        _, place = np.unique(both, axis=0, return_inverse=True)
        known = np.full(place.max() + 1, -1, dtype=np.int64)
        known[place[: len(self.face_nodes)]] = self.face_nodes
        centre = known[place[len(self.face_nodes) :]]
        return np.column_stack([nodes, centre])[centre >= 0]


def completed(cell_type: int, points: Array, cells: Indices) -> CompleteCells:
    """Cells with nodes at the centres of quadrangles, or of hexahedra and their faces.

    Args:
        cell_type: gmsh's number of the element type.
        points: Coordinates, shape (nodes, 3).
        cells: Rows of `points` in gmsh's order of nodes.

    Returns:
        Complete cells; those of other types come back as they are.
    """
    no_faces = np.empty((0, 4), dtype=np.int64), np.empty(0, dtype=np.int64)
    if cell_type not in _COMPLETE:
        return CompleteCells(cell_type, points, cells, *no_faces)
    if cell_type == _QUADRANGLE:
        centre = len(points) + np.arange(len(cells))
        points = np.concatenate([points, _face_centres(points[cells])])
        return CompleteCells(10, points, np.column_stack([cells, centre]), *no_faces)
    nodes = cells[:, _FACES].reshape(-1, 8)
    corners, first, place = np.unique(
        np.sort(nodes[:, :4], axis=1), axis=0, return_index=True, return_inverse=True
    )
    face_nodes = len(points) + np.arange(len(corners))
    inner = len(points) + len(corners) + np.arange(len(cells))
    ends, middles = points[cells[:, :8]], points[cells[:, 8:]]
    centres = (middles.sum(axis=1) - ends.sum(axis=1)) / 4
    points = np.concatenate([points, _face_centres(points[nodes[first]]), centres])
    cells = np.column_stack([cells, face_nodes[place.reshape(-1, 6)], inner])
    return CompleteCells(12, points, cells, corners, face_nodes)


def _face_centres(nodes: Array) -> Array:
    """The 8-node map at the centre: corners count -1/4, middle nodes 1/2."""
    return np.asarray(nodes[:, 4:].sum(axis=1) / 2 - nodes[:, :4].sum(axis=1) / 4)
