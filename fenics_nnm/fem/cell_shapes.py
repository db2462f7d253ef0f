"""Corners, edges and faces of each kind of cell, in VTK's order of nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.row_numbers import row_numbers

Pairs = tuple[tuple[int, int], ...]
Faces = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True)
class Shape:
    """A cell of any order by its corners.

    Attributes:
        dim: Dimension.
        corners: Number of corners, which are the first nodes.
        edges: Corners of each edge, in the order of the middle nodes that follow the corners.
        faces: Corners of each facet, around it; all turned outwards, or all inwards. The facets of
            a plane cell are its edges.
        centred: Facets that have a node of their own in the complete quadratic cell, in the order
            of these nodes, which follow the middle nodes of the edges.
    """

    dim: int
    corners: int
    edges: Pairs
    faces: Faces
    centred: tuple[int, ...] = ()


_TRIANGLE: Pairs = ((0, 1), (1, 2), (2, 0))
_QUADRANGLE: Pairs = ((0, 1), (1, 2), (2, 3), (3, 0))

SHAPES: dict[str, Shape] = {
    "line": Shape(1, 2, ((0, 1),), ((0,), (1,))),
    "triangle": Shape(2, 3, _TRIANGLE, _TRIANGLE),
    "quad": Shape(2, 4, _QUADRANGLE, _QUADRANGLE),
    "tetra": Shape(
        3,
        4,
        ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
        ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    ),
    "hexahedron": Shape(
        3,
        8,
        (
            *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)),
            *((0, 4), (1, 5), (2, 6), (3, 7)),
        ),
        (
            *((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4)),
            *((2, 3, 7, 6), (0, 3, 2, 1), (4, 5, 6, 7)),
        ),
        (0, 1, 2, 3, 4, 5),
    ),
    "wedge": Shape(
        3,
        6,
        ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
        ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
        (2, 3, 4),
    ),
    "pyramid": Shape(
        3,
        5,
        ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)),
        ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
        (0,),
    ),
}


def shape_of(kind: str) -> Shape:
    """The shape of a kind of cell by meshio's name, such as "wedge15"."""
    return SHAPES[kind.rstrip("0123456789")]


@dataclass(frozen=True, slots=True)
class FacetTable:
    """Facets of cells of any kinds of one dimension, a row for each facet of each cell.

    Attributes:
        corners: Corners around each facet, -1 where it has fewer, shape (n, most).
        middles: Middle nodes of its edges in the same order, -1 for none, shape (n, most).
        cell: Number of its cell: those of the first kind come first.
        facet: Number of the facet, the same for all cells that have it.
        times: Number of cells that have it, shape (n,).
    """

    corners: Indices
    middles: Indices
    cell: Indices
    facet: Indices
    times: Indices

    @property
    def outer(self) -> Indices:
        """Rows of the facets of one cell alone."""
        return np.flatnonzero(self.times == 1)

    def find(self, corners: Indices) -> Indices:
        """Row of a facet by its corners in any order, -1 where no cell has it.

        Args:
            corners: Corners, -1 where there are fewer, shape (m, most or less).
        """
        own, asked = _keys(self.corners), _keys(_widened(corners, self.corners.shape[1]))
        place = row_numbers(np.concatenate([own, asked]))
        row = np.full(int(place.max(initial=0)) + 1, -1, dtype=np.int64)
        row[place[: len(own)]] = np.arange(len(own))
        return np.asarray(row[place[len(own) :]])


def facet_table(cells: dict[str, Indices]) -> FacetTable:
    """All facets of cells.

    Args:
        cells: Cells of each kind, all of one dimension; nodes that stand twice in a cell make its
            facets smaller.
    """
    most = max(len(face) for kind in cells for face in shape_of(kind).faces)
    corners, middles, owners, start = [], [], [], 0
    for kind, rows in cells.items():
        for face in shape_of(kind).faces:
            found = _around(kind, rows, face)
            corners.append(_widened(found[0], most))
            middles.append(_widened(found[1], most))
            owners.append(start + np.arange(len(rows)))
        start += len(rows)
    all_corners = np.concatenate(corners)
    real = (all_corners >= 0).sum(axis=1) >= min(most, shape_of(next(iter(cells))).dim)
    all_corners = all_corners[real]
    facet = row_numbers(_keys(all_corners))
    times = np.bincount(facet)
    return FacetTable(
        all_corners,
        np.concatenate(middles)[real],
        np.concatenate(owners)[real],
        facet,
        times[facet],
    )


def _around(kind: str, rows: Indices, face: tuple[int, ...]) -> tuple[Indices, Indices]:
    """Corners and middle nodes around one facet of all cells; those that stand twice are -1."""
    shape = shape_of(kind)
    corners = rows[:, list(face)].copy()
    middles = np.full_like(corners, -1)
    for place in range(len(face)):
        ends = {face[place], face[(place + 1) % len(face)]}
        known = [i for i, edge in enumerate(shape.edges) if set(edge) == ends]
        if known and len(ends) == 2 and rows.shape[1] > shape.corners:
            middles[:, place] = rows[:, shape.corners + known[0]]
    repeated = corners == np.roll(corners, -1, axis=1)
    if len(face) > 1 and repeated.any():
        corners[repeated] = middles[repeated] = -1
        order = np.argsort(corners < 0, axis=1, kind="stable")
        corners, middles = (np.take_along_axis(a, order, axis=1) for a in (corners, middles))
    return corners, middles


def _widened(values: Indices, width: int) -> Indices:
    """Rows with -1 added up to a width."""
    more = np.full((len(values), width - values.shape[1]), -1, dtype=np.int64)
    return np.concatenate([values.astype(np.int64), more], axis=1)


def _keys(corners: Indices) -> Indices:
    """Corners in ascending order, the same for all ways around a facet."""
    return np.sort(corners, axis=1)


def signed_volumes(points: Array, tetrahedra: Indices) -> Array:
    """Volumes of tetrahedra, by the sign of their orientation."""
    a, b, c, d = (points[tetrahedra[:, i]] for i in range(4))
    return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6)
