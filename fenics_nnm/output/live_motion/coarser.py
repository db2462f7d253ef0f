"""A surface with fewer nodes: nodes of one box of space become one (Rossignac and Borrel 1993)."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: Boxes grow by this factor until few enough nodes are left, from this part of the surface's size.
_GROWTH, _SMALLEST = 1.25, 1 / 400


def coarser(places: Array, faces: Indices, most: int) -> tuple[Indices, Indices]:
    """Nodes to keep, and the faces between them.

    Args:
        places: Places of the nodes in m, shape (p, 3).
        faces: Nodes of each face, shape (f, 3 or 4).
        most: Most nodes to keep.

    Returns:
        Numbers of the kept nodes, shape (k,), and faces that have three of them or more as
        triangles or quadrangles of kept nodes, shape (g, 3 or 4).
    """
    if len(places) <= most:
        return np.arange(len(places)), faces
    size = _SMALLEST * float(np.ptp(places, axis=0).max())
    while True:
        kept, owner = _of_boxes(places, size)
        if len(kept) <= most:
            return kept, _between(owner[faces])
        size *= _GROWTH


def _of_boxes(places: Array, size: float) -> tuple[Indices, Indices]:
    """A node of each box, the nearest to the middle of those in it, and the box of each node."""
    cells = np.floor((places - places.min(axis=0)) / size).astype(np.int64)
    _, owner = np.unique(cells, axis=0, return_inverse=True)
    owner = owner.reshape(-1)
    count = np.bincount(owner)
    middle = np.stack([np.bincount(owner, row) / count for row in places.T], axis=1)
    away = np.linalg.norm(places - middle[owner], axis=1)
    order = np.lexsort((away, owner))
    first = np.flatnonzero(np.diff(owner[order], prepend=-1))
    return order[first], owner


def _between(faces: Indices) -> Indices:
    """Faces with three different nodes at least, each once."""
    ordered = np.sort(faces, axis=1)
    different = 1 + np.count_nonzero(np.diff(ordered, axis=1), axis=1)
    found = faces[different >= 3]
    _, first = np.unique(np.sort(found, axis=1), axis=0, return_index=True)
    return found[np.sort(first)]
