"""The surface of a mesh: its outer faces and the edges that make its outline."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import OutputError

_TETRAHEDRON = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
_HEXAHEDRON = (
    (0, 3, 2, 1),
    (4, 5, 6, 7),
    (0, 1, 5, 4),
    (1, 2, 6, 5),
    (2, 3, 7, 6),
    (3, 0, 4, 7),
)

#: Faces of a cell by its corners, for VTK's cell types of order one, two and any.
_FACES = {
    **dict.fromkeys((5, 22, 69), ((0, 1, 2),)),
    **dict.fromkeys((9, 23, 28, 70), ((0, 1, 2, 3),)),
    **dict.fromkeys((10, 24, 71), _TETRAHEDRON),
    **dict.fromkeys((12, 25, 29, 72), _HEXAHEDRON),
}


def surface_faces(cells: Indices, cell_type: int) -> Indices:
    """Corners of the faces that belong to one cell only; the cells themselves in the plane.

    Args:
        cells: Nodes of each cell in VTK's order, corners first, shape (cells, nodes a cell).
        cell_type: VTK's number of the cell type.

    Returns:
        Node numbers, outwards by the right-hand rule, shape (faces, 3 or 4).

    Raises:
        OutputError: if such cells have no faces.
    """
    if cell_type not in _FACES:
        raise OutputError(f"cells of VTK's type {cell_type} have no faces to draw")
    faces = np.vstack([cells[:, list(corners)] for corners in _FACES[cell_type]])
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    return faces[np.sort(first[count == 1])]


def feature_edges(nodes: Array, faces: Indices, angle: float = 40.0) -> Indices:
    """Edges where the surface ends or bends by more than an angle in degrees, shape (edges, 2).

    Args:
        nodes: Places of the nodes, shape (n, 3).
        faces: Corners of the faces, shape (faces, 3 or 4).
        angle: Smallest bend.
    """
    ring = np.roll(faces, -1, axis=1)
    edges = np.sort(np.stack([faces, ring], axis=2).reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(faces)), faces.shape[1])
    order = np.lexsort(edges.T)
    edges, owner = edges[order], owner[order]
    paired = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    alone = np.ones(len(edges), dtype=bool)
    alone[paired] = alone[paired + 1] = False
    normal = face_normals(nodes[faces])
    bend = np.sum(normal[owner[paired]] * normal[owner[paired + 1]], axis=1)
    return np.vstack([edges[alone], edges[paired[bend < np.cos(np.radians(angle))]]])


def face_normals(corners: Array) -> Array:
    """Unit normals of faces with corners of shape (faces, 3 or 4, 3), shape (faces, 3)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)
