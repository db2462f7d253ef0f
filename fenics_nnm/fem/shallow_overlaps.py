"""Parts of a body that reach into each other at their surfaces, by less than an element.

A point on an outer facet of one cell must not lie below an outer facet of another cell that it
shares no node with. Volumes tell nothing of this: that which the outer facets of all cells enclose
is the sum of the cells, however they lie.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.cell_shapes import FacetTable
from fenics_nnm.fem.row_numbers import row_numbers
from fenics_nnm.fem.splitting import divided

#: Places on a facet that are looked for below others, unequal, so that they lie on no edge of
#: regular meshes.
_PROBES = {2: ((0.71, 0.29), (0.29, 0.71)), 3: ((0.6, 0.27, 0.13), (0.13, 0.6, 0.27))}

#: Depth over the height of the element from which on a point lies below its facet.
_DEPTH = 0.01

#: Least barycentric coordinate of a point inside a simplex, besides the one of its depth.
_INSIDE = 1e-3

#: Largest angle in rad between neighbouring facets of a surface that is curved, not kinked.
_CURVED = 1.2

#: Rise of a chord over its arc, times its length and the angle to the next chord; with a reserve.
_RISE = 1.5 / 8


@dataclass(frozen=True, slots=True)
class Hit:
    """A point of one cell inside of another one.

    Attributes:
        point: The point.
        cells: The two cells.
        depth: How far it lies inside, in the unit of the mesh.
        share: The same over the height of the element.
    """

    point: Array
    cells: tuple[int, int]
    depth: float
    share: float


@dataclass(frozen=True, slots=True)
class _Skin:
    """Outer facets of the simplices that cells are made of.

    Attributes:
        nodes: Nodes of each facet, shape (n, dim).
        cell: Its cell.
        corners: Places of its nodes and, last, of the corner opposite, shape (n, dim + 1, dim).
        normals: Outward unit normals.
        heights: Distance of the corner opposite.
    """

    nodes: Indices
    cell: Indices
    corners: Array

    normals: Array
    heights: Array

    @property
    def middles(self) -> Array:
        """Middle of each facet."""
        return np.asarray(self.corners[:, :-1].mean(axis=1))

    @property
    def reach(self) -> Array:
        """Largest distance of a corner of each facet from its middle."""
        away = self.corners[:, :-1] - self.middles[:, None]
        return np.asarray(np.linalg.norm(away, axis=2).max(axis=1))


def _normals(corners: Array) -> Array:
    """Unit normal of each facet away from the corner opposite; zero where that is not known."""
    sides = corners[:, 1:-1] - corners[:, :1]
    turned: Array = np.stack([sides[:, 0, 1], -sides[:, 0, 0]], axis=1)
    if corners.shape[2] == 3:
        turned = np.cross(sides[:, 0], sides[:, 1])
    way = -np.sign(np.einsum("nd,nd->n", turned, corners[:, -1] - corners[:, 0]))
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(way[:, None] * turned / np.where(length > 0, length, 1.0))


def shallow_overlap(
    points: Array, simplices: Indices, parent: Indices, table: FacetTable, dim: int
) -> Hit | None:
    """The deepest place where a cell reaches into another one at its surface.

    What the chords of curved surfaces reach into each other is allowed.

    Args:
        points: Coordinates, shape (nodes, 3).
        simplices: Nodes of the simplices of all cells, shape (n, dim + 1).
        parent: Cell of each simplex.
        table: Facets of the cells.
        dim: Dimension of the body.
    """
    skin = _skin(points, simplices, parent, table, dim)
    pairs = _near_pairs(skin)
    found = [_hits(skin, pairs, np.array(weights)) for weights in _PROBES[dim]]
    hits = _Hits(
        np.concatenate([each.one for each in found]),
        np.concatenate([each.other for each in found]),
        np.concatenate([each.point for each in found]),
        np.concatenate([each.depth for each in found]),
    )
    if not len(hits.one):
        return None
    rise = _rise(skin)
    share = (hits.depth - rise[hits.one] - rise[hits.other]) / skin.heights[hits.other]
    worst = int(np.argmax(share))
    if share[worst] < _DEPTH:
        return None
    one, other = hits.one[worst], hits.other[worst]
    depth = float(hits.depth[worst])
    return Hit(
        hits.point[worst],
        (int(skin.cell[one]), int(skin.cell[other])),
        depth,
        depth / float(skin.heights[other]),
    )


@dataclass(frozen=True, slots=True)
class _Hits:
    """Points of facets inside of other cells.

    Attributes:
        one: The facet of each point.
        other: The facet that it is below.
        point: Its place.
        depth: Its distance from that facet.
    """

    one: Indices
    other: Indices
    point: Array
    depth: Array


def _hits(skin: _Skin, pairs: tuple[Indices, Indices], weights: Array) -> _Hits:
    """Points of facets inside of other cells, one a facet, each with the facet nearest to it."""
    one, other = pairs
    probes = np.einsum("k,nkd->nd", weights, skin.corners[:, :-1])
    away = skin.corners[other, 0] - probes[one]
    depth = np.einsum("nd,nd->n", away, skin.normals[other])
    below = np.flatnonzero((depth > _DEPTH * skin.heights[other]) & (depth < skin.heights[other]))
    inside = below[_inside(skin.corners[other[below]], probes[one[below]])]
    chosen = np.flatnonzero(np.isin(one, one[inside]) & (depth > -_DEPTH * skin.heights[other]))
    chosen = chosen[_above(skin, other[chosen], probes[one[chosen]])]
    nearest = np.union1d(chosen, inside)
    nearest = nearest[np.lexsort((depth[nearest], one[nearest]))]
    _, first = np.unique(one[nearest], return_index=True)
    rows = nearest[first]
    return _Hits(one[rows], other[rows], probes[one[rows]], depth[rows])


def _skin(points: Array, simplices: Indices, parent: Indices, table: FacetTable, dim: int) -> _Skin:
    """Outer facets of the simplices."""
    corners = table.corners[table.outer]
    outer = divided(corners)[0] if dim == 3 else corners
    at_surface = np.flatnonzero(np.isin(parent, table.cell[table.outer]))
    own = simplices[at_surface]
    facets = np.concatenate([np.delete(own, left_out, axis=1) for left_out in range(dim + 1)])
    place = row_numbers(np.sort(np.concatenate([outer, facets]), axis=1))
    is_outer = np.zeros(int(place.max(initial=0)) + 1, dtype=bool)
    is_outer[place[: len(outer)]] = True
    chosen = np.flatnonzero(is_outer[place[len(outer) :]])
    left_out, row = np.divmod(chosen, len(own))
    opposite = own[row, left_out]
    nodes = facets[chosen]
    around = np.concatenate([nodes, opposite[:, None]], axis=1)
    places = points[around][..., :dim]
    normals = _normals(places)
    heights = np.einsum("nd,nd->n", places[:, 0] - places[:, -1], normals)
    return _Skin(nodes, parent[at_surface[row]], places, normals, heights)


def _near_pairs(skin: _Skin) -> tuple[Indices, Indices]:
    """Pairs of facets that may meet and share no node, each pair both ways."""
    middles, reach = skin.middles, skin.reach
    near = KDTree(middles).query_ball_point(middles, 2 * reach, return_sorted=False)
    counts = np.array([len(each) for each in near], dtype=np.int64)
    other = np.concatenate([np.asarray(each, dtype=np.int64) for each in near])
    one = np.repeat(np.arange(len(near)), counts)
    kept = reach[other] <= reach[one]
    one, other = one[kept], other[kept]
    apart = ~(skin.nodes[one][:, :, None] == skin.nodes[other][:, None, :]).any(axis=(1, 2))
    apart &= skin.cell[one] != skin.cell[other]
    one, other = one[apart], other[apart]
    return np.concatenate([one, other]), np.concatenate([other, one])


def _inside(corners: Array, points: Array) -> Indices:
    """Which points lie inside simplices, one each."""
    sides = np.swapaxes(corners[:, :-1] - corners[:, -1:], 1, 2)
    shares = np.linalg.solve(sides, (points - corners[:, -1])[..., None])[..., 0]
    return np.flatnonzero((shares.min(axis=1) > _INSIDE) & (shares.sum(axis=1) < 1))


def _above(skin: _Skin, facets: Indices, points: Array) -> Indices:
    """Which points lie straight below, or above, facets, one each."""
    corners = skin.corners[facets]
    sides = np.concatenate(
        [corners[:, 1:-1] - corners[:, :1], skin.normals[facets][:, None]], axis=1
    )
    shares = np.linalg.solve(np.swapaxes(sides, 1, 2), (points - corners[:, 0])[..., None])
    within = shares[:, :-1, 0]
    return np.flatnonzero((within.min(axis=1) > -_INSIDE) & (within.sum(axis=1) < 1 + _INSIDE))


def _rise(skin: _Skin) -> Array:
    """How far the curved surface that a facet is a chord of may be from it."""
    count = len(skin.nodes)
    width = skin.nodes.shape[1]
    of_nodes = csr_matrix(
        (np.ones(count * width), (np.repeat(np.arange(count), width), skin.nodes.ravel()))
    )
    around = (of_nodes @ of_nodes.T).tocoo()
    cosines = np.einsum("nd,nd->n", skin.normals[around.row], skin.normals[around.col])
    angles = np.arccos(np.clip(cosines, -1, 1))
    angles[angles > _CURVED] = 0.0
    largest: Array = np.zeros(count)
    np.maximum.at(largest, around.row, angles)
    return np.asarray(_RISE * 2 * skin.reach * largest)
