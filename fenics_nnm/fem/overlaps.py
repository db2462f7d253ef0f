"""Cells that stand twice or overlap, which would carry mass and stiffness twice."""

from __future__ import annotations

from itertools import chain

import numpy as np
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cell_shapes import FacetTable, shape_of
from fenics_nnm.fem.row_numbers import row_numbers
from fenics_nnm.fem.shallow_overlaps import shallow_overlap
from fenics_nnm.fem.splitting import shown, simplices_of

#: Barycentric coordinates of points of a simplex that are looked for in other cells, unequal, so
#: that they lie on no plane of symmetry of regular meshes.
_PROBE = np.array([0.34, 0.28, 0.21, 0.17])

#: Simplices that are searched at once.
_AT_ONCE = 100_000

#: Least barycentric coordinate of a point that lies well inside a part of a cell.
_INSIDE = 0.02


def assert_single(
    name: str, points: Array, cells: dict[str, Indices], numbers: Indices, table: FacetTable
) -> None:
    """Refuse cells that have the same nodes, or share their volume.

    A facet belongs to at most two cells, which lie on both sides of it; and no cell at the
    surface reaches into another one.

    Args:
        name: What is read, for messages.
        points: Coordinates, shape (nodes, 3).
        cells: Cells of each kind, all of one dimension.
        numbers: Number of each cell in the file, those of the first kind first.
        table: Facets of the cells.

    Raises:
        MeshError: with the numbers of two such elements.
    """
    _refuse_twice(name, cells, numbers)
    many = np.flatnonzero(table.times > 2)
    if len(many):
        found = table.cell[table.facet == table.facet[many[0]]]
        listed = ", ".join(str(int(numbers[cell])) for cell in found)
        count = len(np.unique(table.facet[many]))
        raise MeshError(
            f"{name}: {count} facets belong to more than two elements, one to the elements "
            f"{listed}, at {shown(points[table.corners[many[0], 0]])}: elements overlap"
        )
    dim = shape_of(next(iter(cells))).dim
    if dim > 1:
        parts = _Parts.of(points, cells, dim)
        _refuse_same_side(name, points, numbers, table, parts)
        _refuse_inside(name, numbers, table, parts)
        _refuse_shallow(name, points, numbers, table, parts)


class _Parts:
    """Simplices of all cells, and the way each cell is turned."""

    def __init__(self, simplices: Indices, corners: Array, parent: Indices, count: int) -> None:
        """Signs of the volumes.

        Args:
            simplices: Nodes of each simplex, shape (n, dim + 1).
            corners: Their places, shape (n, dim + 1, dim).
            parent: Number of its cell.
            count: Number of cells.
        """
        self.simplices, self.corners, self.parent = simplices, corners, parent
        sides = corners[:, 1:] - corners[:, :1]
        volumes = np.linalg.det(sides)
        total = np.bincount(parent, volumes, count)
        absolute = np.bincount(parent, np.abs(volumes), count)
        #: 1 or -1, and 0 for cells that are flat or folded.
        self.signs = np.sign(total) * (np.abs(total) > (1 - 1e-9) * absolute)

    @classmethod
    def of(cls, points: Array, cells: dict[str, Indices], dim: int) -> _Parts:
        """Parts of all cells; cells of the plane are taken in the x-y plane."""
        simplices, parent = simplices_of(cells)
        corners = points[simplices][..., :dim]
        return cls(simplices, corners, parent, sum(map(len, cells.values())))


def _refuse_twice(name: str, cells: dict[str, Indices], numbers: Indices) -> None:
    start = 0
    for kind, rows in cells.items():
        corners = np.sort(rows[:, : shape_of(kind).corners], axis=1)
        place = row_numbers(corners)
        first = np.unique(place, return_index=True)[1]
        twice = np.flatnonzero(first[place] != np.arange(len(rows)))
        if len(twice):
            one, other = first[place[twice[0]]], twice[0]
            raise MeshError(
                f"{name}: {len(twice)} elements stand twice: {int(numbers[start + other])} has the "
                f"nodes of {int(numbers[start + one])}: leave one of the two out"
            )
        start += len(rows)


def _refuse_same_side(
    name: str, points: Array, numbers: Indices, table: FacetTable, parts: _Parts
) -> None:
    """Refuse two cells on the same side of a facet that they share."""
    shared = np.flatnonzero(table.times == 2)
    shared = shared[np.argsort(table.facet[shared], kind="stable")]
    one, other = shared[::2], shared[1::2]
    alike = _following(table.corners[one]) == _following(table.corners[other])
    signs = parts.signs[table.cell[one]] * parts.signs[table.cell[other]]
    wrong = np.flatnonzero((alike & (signs > 0)) | (~alike & (signs < 0)))
    if len(wrong):
        pair = (int(numbers[table.cell[side[wrong[0]]]]) for side in (one, other))
        raise MeshError(
            f"{name}: {len(wrong)} pairs of elements overlap, {' and '.join(map(str, pair))} lie "
            f"on the same side of a facet at {shown(points[table.corners[one[wrong[0]], 0]])}"
        )


def _following(corners: Indices) -> Indices:
    """The corner after the smallest one of each ring, -1 standing for none; of edges, the first."""
    if corners.shape[1] == 2:
        return corners[:, 0]
    counts = (corners >= 0).sum(axis=1)
    places = np.argmin(np.where(corners >= 0, corners, np.iinfo(np.int64).max), axis=1)
    return np.asarray(corners[np.arange(len(corners)), (places + 1) % counts])


def _refuse_inside(name: str, numbers: Indices, table: FacetTable, parts: _Parts) -> None:
    """Refuse cells at the surface that reach deep into another cell."""
    upright = parts.signs[parts.parent] != 0  # others are refused as folded later on
    own = np.flatnonzero(np.isin(parts.parent, table.cell[table.outer]) & upright)
    weights = np.array([_PROBE[: parts.corners.shape[1]], _PROBE[::-1][: parts.corners.shape[1]]])
    weights /= weights.sum(axis=1, keepdims=True)
    points = np.einsum("pk,skd->spd", weights, parts.corners[own]).reshape(-1, weights.shape[1] - 1)
    cell = np.repeat(parts.parent[own], len(weights))
    for some in np.array_split(np.arange(len(parts.corners)), len(parts.corners) // _AT_ONCE + 1):
        probe, simplex = _near(points, parts.corners[some])
        simplex = some[simplex]
        other = (cell[probe] != parts.parent[simplex]) & upright[simplex]
        probe, simplex = probe[other], simplex[other]
        inside = _inside(parts.corners[simplex], points[probe])
        if inside.any():
            at = int(np.argmax(inside))
            raise MeshError(
                f"{name}: elements overlap: {shown(points[probe[at]])} lies both in "
                f"{int(numbers[cell[probe[at]]])} and in {int(numbers[parts.parent[simplex[at]]])}"
            )


def _refuse_shallow(
    name: str, points: Array, numbers: Indices, table: FacetTable, parts: _Parts
) -> None:
    """Refuse cells that reach into each other at their surfaces."""
    upright = parts.signs[parts.parent] != 0
    simplices, parent = parts.simplices[upright], parts.parent[upright]
    hit = shallow_overlap(points, simplices, parent, table, parts.corners.shape[2])
    if hit:
        one, other = (int(numbers[cell]) for cell in hit.cells)
        raise MeshError(
            f"{name}: elements overlap: {one} reaches {hit.depth:.3g}, which is {hit.share:.2g} of "
            f"the height of the element, into {other} at {shown(hit.point)}: parts may touch, and "
            "what they are pressed together by is a negative gap"
        )


def _near(points: Array, corners: Array) -> tuple[Indices, Indices]:
    """Pairs of a point and a simplex whose surrounding ball about its middle has the point."""
    middles = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    tree = KDTree(points)
    closest = tree.query(middles, distance_upper_bound=float(reach.max(initial=0.0)))[0]
    near = np.flatnonzero(closest <= reach)
    found = tree.query_ball_point(middles[near], reach[near], return_sorted=False)
    counts = np.array([len(each) for each in found], dtype=np.int64)
    probes = np.fromiter(chain.from_iterable(found), dtype=np.int64, count=int(counts.sum()))
    return probes, np.repeat(near, counts)


def _inside(corners: Array, points: Array) -> Array:
    """Whether points lie well inside simplices, one each."""
    sides = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    flat = np.abs(np.linalg.det(sides)) < 1e-300
    sides[flat] = np.eye(sides.shape[1])
    share = np.linalg.solve(sides, (points - corners[:, 0])[..., None])[..., 0]
    least = np.minimum(share.min(axis=1), 1 - share.sum(axis=1))
    return (least > _INSIDE) & ~flat
