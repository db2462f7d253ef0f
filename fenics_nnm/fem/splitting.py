"""Meshes of several kinds of cells, split into tetrahedra or triangles that fit each other.

Every facet is divided from its corner with the smallest number, whichever cell looks at it, and
every cell is a cone over its divided facets from its own smallest corner (Dompierre, Labbe, Vallet
and Camarero 1999, "How to subdivide pyramids, prisms and hexahedra into tetrahedra"). Nodes that
stand twice in a cell make it smaller: a hexahedron may be a prism, a pyramid or a tetrahedron.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cell_shapes import SHAPES, Shape, shape_of, signed_volumes
from fenics_nnm.fem.row_numbers import row_numbers

#: Volume of a part over that of its cell below which the part is flat.
_FLAT = 1e-7

#: Times that middle nodes which fold a cell are put half way between their ends.
_STRAIGHTENED = 3


@dataclass(frozen=True, slots=True)
class SplitCells:
    """Simplices in place of cells.

    Attributes:
        points: All coordinates, new nodes last, shape (nodes, 3).
        kind: "tetra", "tetra10", "triangle" or "triangle6".
        cells: Rows of `points` of each simplex in VTK's order.
        parent: Number of the cell of each simplex; those of the first kind come first.
    """

    points: Array
    kind: str
    cells: Indices
    parent: Indices


def split(name: str, points: Array, cells: dict[str, Indices], numbers: Indices) -> SplitCells:
    """Split cells of one dimension and order.

    Args:
        name: What is read, for messages.
        points: Coordinates, shape (nodes, 3).
        cells: Cells of each kind.
        numbers: Number of each cell in the file, those of the first kind first, for messages.

    Raises:
        MeshError: if a cell is flat or folded.
    """
    dim = shape_of(next(iter(cells))).dim
    simplices, parent = simplices_of(cells)
    if dim == 3:
        _assert_upright(name, points, simplices, parent, numbers)
    if not any(rows.shape[1] > shape_of(kind).corners for kind, rows in cells.items()):
        return SplitCells(points, "tetra" if dim == 3 else "triangle", simplices, parent)
    points, whole = _with_middles(points, cells, simplices, "tetra" if dim == 3 else "triangle")
    return SplitCells(points, "tetra10" if dim == 3 else "triangle6", whole, parent)


def simplices_of(cells: dict[str, Indices]) -> tuple[Indices, Indices]:
    """Corners of the simplices of cells of one dimension, and the number of the cell of each."""
    parts, parents, start = [], [], 0
    for kind, rows in cells.items():
        simplices, owner = _simplices(shape_of(kind), rows[:, : shape_of(kind).corners])
        parts.append(simplices)
        parents.append(start + owner)
        start += len(rows)
    return np.concatenate(parts), np.concatenate(parents)


def divided(corners: Indices) -> tuple[Indices, Indices]:
    """Triangles of facets of 3 or 4 corners, and the row of `corners` that each comes from.

    Args:
        corners: Corners around each facet, the fourth -1 for triangles, shape (n, 3 or 4).
    """
    if corners.shape[1] == 3:
        return corners, np.arange(len(corners))
    flat = corners[:, 3] < 0
    square = np.flatnonzero(~flat)
    first = np.argmin(corners[square], axis=1)
    turned = np.take_along_axis(corners[square], (first[:, None] + np.arange(4)) % 4, axis=1)
    rows = [corners[flat, :3], turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]
    return np.concatenate(rows), np.concatenate([np.flatnonzero(flat), square, square])


def _simplices(shape: Shape, corners: Indices) -> tuple[Indices, Indices]:
    """Simplices of cells of one shape, and the row of the cell of each.

    Cells that look alike, by their smallest corners and those that stand twice, are split alike.
    """
    first = np.array([np.argmax(corners == corners[:, [i]], axis=1) for i in range(shape.corners)])
    looks = [np.argmin(corners, axis=1), *first]
    if shape.dim == 3:
        looks += [np.argmin(corners[:, list(face)], axis=1) for face in shape.faces]
    signatures, which = np.unique(np.stack(looks, axis=1), axis=0, return_inverse=True)
    parts, owners = [], []
    for number in range(len(signatures)):
        rows = np.flatnonzero(which.ravel() == number)
        template = _template(shape, corners[rows[0]].tolist())
        parts.append(corners[rows][:, template].reshape(-1, shape.dim + 1))
        owners.append(np.repeat(rows, len(template)))
    return np.concatenate(parts), np.concatenate(owners)


def _template(shape: Shape, corners: list[int]) -> Indices:
    """Places of the corners of each simplex of one cell."""
    faces = shape.faces if shape.dim == 3 else (tuple(range(shape.corners)),)
    triangles = [triangle for face in faces for triangle in _fan(face, corners)]
    if shape.dim == 3:
        smallest = min(corners)
        top = corners.index(smallest)
        triangles = [
            (top, *triangle)
            for triangle in triangles
            if smallest not in [corners[place] for place in triangle]
        ]
    return np.array(triangles, dtype=np.int64).reshape(-1, shape.dim + 1)


def _fan(face: tuple[int, ...], corners: list[int]) -> list[tuple[int, ...]]:
    """Triangles of a facet from its smallest corner, without corners that stand twice."""
    ring = [p for i, p in enumerate(face) if corners[p] != corners[face[i - 1]]]
    if len(ring) < 3:
        return []
    start = min(range(len(ring)), key=lambda i: corners[ring[i]])
    ring = ring[start:] + ring[:start]
    return [(ring[0], ring[i], ring[i + 1]) for i in range(1, len(ring) - 1)]


def _assert_upright(
    name: str, points: Array, simplices: Indices, parent: Indices, numbers: Indices
) -> None:
    """Refuse cells that have no volume, or whose parts turn both ways."""
    volumes = signed_volumes(points, simplices)
    whole = np.bincount(parent, weights=volumes, minlength=len(numbers))
    wrong = volumes * np.sign(whole)[parent] <= _FLAT * np.abs(whole)[parent]
    bad = np.unique(np.concatenate([parent[wrong], np.setdiff1d(np.arange(len(numbers)), parent)]))
    if len(bad):
        one = np.flatnonzero(parent == bad[0])
        place = "" if not len(one) else f" at {shown(points[simplices[one[0], 0]])}"
        raise MeshError(
            f"{name}: {len(bad)} degenerate elements (flat or folded), the first is number "
            f"{int(numbers[bad[0]])}{place}: mesh again or heal the geometry"
        )


def shown(point: Array) -> str:
    """A point for messages, in the unit of the file."""
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ")"


def _with_middles(
    points: Array, cells: dict[str, Indices], simplices: Indices, simplex: str
) -> tuple[Array, Indices]:
    """Points with middle nodes of diagonals, and simplices with all their middle nodes."""
    ends, nodes = _edge_nodes(cells)
    pairs = simplices[:, np.array(SHAPES[simplex].edges)].reshape(-1, 2)
    own, which = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
    known = _looked_up(ends, nodes, own)
    missing = np.flatnonzero(known < 0)
    known[missing] = len(points) + np.arange(len(missing))
    straight = points[own[missing]].mean(axis=1)
    points = np.concatenate([points, _centres(points, cells, own[missing], straight)])
    whole = np.concatenate([simplices, known[which.ravel()].reshape(len(simplices), -1)], axis=1)
    if simplex == "tetra":
        _straighten(points, whole, known[missing], straight)
    return points, whole


def _edge_nodes(cells: dict[str, Indices]) -> tuple[Indices, Indices]:
    """Ends of all edges of quadratic cells, and their middle nodes."""
    ends, nodes = [], []
    for kind, rows in cells.items():
        edges = np.array(shape_of(kind).edges)
        ends.append(np.sort(rows[:, edges].reshape(-1, 2), axis=1))
        corners = shape_of(kind).corners
        nodes.append(rows[:, corners : corners + len(edges)].ravel())
    return np.concatenate(ends), np.concatenate(nodes)


def _looked_up(keys: Indices, values: Indices, wanted: Indices) -> Indices:
    """Value of each wanted row, -1 where no key is alike."""
    place = row_numbers(np.concatenate([keys, wanted]))
    found = np.full(int(place.max()) + 1, -1, dtype=np.int64)
    found[place[: len(keys)]] = values
    return np.asarray(found[place[len(keys) :]])


def _centres(points: Array, cells: dict[str, Indices], pairs: Indices, straight: Array) -> Array:
    """Places of the middle nodes of diagonals: where the parent has its centre.

    Diagonals lie on quadrangles, or run through hexahedra.
    """
    places = straight.copy()
    for kind, rows in cells.items():
        shape = shape_of(kind)
        rings = list(shape.faces) if shape.dim == 3 else [tuple(range(shape.corners))]
        for face in (ring for ring in rings if len(ring) == 4):
            centre = _centre_of_face(points, shape, rows, face)
            for ends in ((face[0], face[2]), (face[1], face[3])):
                _put(places, pairs, rows[:, ends], centre)
        if shape.corners == 8:
            centre = _centre_of_hexahedron(points, rows)
            for ends in ((0, 6), (1, 7), (2, 4), (3, 5)):
                _put(places, pairs, rows[:, ends], centre)
    return places


def _put(places: Array, pairs: Indices, ends: Indices, centre: Array) -> None:
    row = _looked_up(pairs, np.arange(len(pairs)), np.sort(ends, axis=1))
    places[row[row >= 0]] = centre[row >= 0]


def _centre_of_face(points: Array, shape: Shape, rows: Indices, face: tuple[int, ...]) -> Array:
    """Centre of a quadrangle of all cells: its own node, or the 8-node map there.

    Corners count -1/4 and middle nodes 1/2. Middle nodes of an edge without length are its ends.
    """
    complete = shape.corners + len(shape.edges)
    number = shape.faces.index(face) if face in shape.faces else 0
    if rows.shape[1] > complete and (shape.dim == 2 or number in shape.centred):
        return points[rows[:, complete + (shape.centred.index(number) if shape.centred else 0)]]
    edges = [set(edge) for edge in shape.edges]
    around = [edges.index({face[i], face[(i + 1) % 4]}) for i in range(4)]
    middles = rows[:, [shape.corners + i for i in around]]
    return np.asarray(points[middles].sum(axis=1) / 2 - points[rows[:, list(face)]].sum(axis=1) / 4)


def _centre_of_hexahedron(points: Array, rows: Indices) -> Array:
    """Its own node, or the 20-node map there: corners count -1/4, middle nodes 1/4."""
    if rows.shape[1] == 27:
        return points[rows[:, 26]]
    return np.asarray((points[rows[:, 8:20]].sum(axis=1) - points[rows[:, :8]].sum(axis=1)) / 4)


def _straighten(points: Array, cells: Indices, new: Indices, straight: Array) -> None:
    """Put new middle nodes that fold a tetrahedron half way between the ends of their edge."""
    for _ in range(_STRAIGHTENED):
        bad = np.intersect1d(cells[_folded(points, cells)][:, 4:], new)
        if not len(bad):
            return
        rows = np.searchsorted(new, bad)
        points[bad] = straight[rows]


def _folded(points: Array, cells: Indices) -> Indices:
    """Tetrahedra of 10 nodes whose Jacobian is not of one sign at the nodes."""
    signs = []
    x = points[cells]
    for place in _NODES:
        J = np.einsum("nk,cnd->cdk", _slopes(place), x)
        signs.append(np.linalg.det(J) > 0)
    positive = np.stack(signs, axis=1)
    return np.flatnonzero(positive.any(axis=1) & ~positive.all(axis=1))


#: Corners and middles of edges of the reference tetrahedron.
_CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_NODES = np.concatenate([_CORNERS, [_CORNERS[[a, b]].mean(0) for a, b in SHAPES["tetra"].edges]])


def _slopes(place: Array) -> Array:
    """Derivatives of the shape functions of the tetrahedron of 10 nodes, shape (10, 3)."""
    L = np.array([1 - place.sum(), *place])
    dL = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    corners = [(4 * L[i] - 1) * dL[i] for i in range(4)]
    middles = [4 * (L[a] * dL[b] + L[b] * dL[a]) for a, b in SHAPES["tetra"].edges]
    return np.array([*corners, *middles])
