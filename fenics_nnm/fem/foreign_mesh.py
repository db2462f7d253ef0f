"""Meshes of other programs: cells and sets of any kind, brought to named groups of one mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import gmsh
import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.constraints import NO_CONSTRAINTS, LinearConstraints
from fenics_nnm.fem.gmsh_mesh import extracted
from fenics_nnm.fem.raw_mesh import RawMesh

#: Dimension, gmsh's number and plural of each kind of cell, by meshio's names.
KINDS: dict[str, tuple[int, int, str]] = {
    "vertex": (0, 15, "points"),
    "line": (1, 1, "lines"),
    "line3": (1, 8, "lines"),
    "triangle": (2, 2, "triangles"),
    "triangle6": (2, 9, "triangles"),
    "quad": (2, 3, "quadrangles"),
    "quad8": (2, 16, "quadrangles"),
    "quad9": (2, 10, "quadrangles"),
    "tetra": (3, 4, "tetrahedra"),
    "tetra10": (3, 11, "tetrahedra"),
    "hexahedron": (3, 5, "hexahedra"),
    "hexahedron20": (3, 17, "hexahedra"),
    "hexahedron27": (3, 12, "hexahedra"),
    "wedge": (3, 6, "prisms"),
    "wedge15": (3, 18, "prisms"),
    "pyramid": (3, 7, "pyramids"),
    "pyramid13": (3, 19, "pyramids"),
    "wedge18": (3, 13, "prisms"),
    "pyramid14": (3, 14, "pyramids"),
}

#: VTK's place of each node in gmsh's order, where the two differ.
GMSH_ORDER = {
    "tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    "hexahedron20": [*range(8), 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14],
    "hexahedron27": [
        *[*range(8), 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14],
        *[24, 22, 20, 21, 23, 25, 26],
    ],
    "wedge15": [*range(6), 6, 8, 12, 7, 13, 14, 9, 11, 10],
    "wedge18": [*range(6), 6, 8, 12, 7, 13, 14, 9, 11, 10, 15, 17, 16],
    "pyramid13": [*range(5), 5, 8, 9, 6, 10, 7, 11, 12],
    "pyramid14": [*range(5), 5, 8, 9, 6, 10, 7, 11, 12, 13],
}

_ALL_CELLS = "body"


@dataclass(frozen=True, slots=True)
class ForeignMesh:
    """A mesh as another program names its parts; node orders are those of VTK.

    Attributes:
        points: Coordinates, shape (nodes, 3).
        cells: Rows of `points` of the cells of each kind, a key of `KINDS`.
        sets: Rows of `cells` of each named set, by kind.
        node_sets: Rows of `points` of each named set of nodes.
        facets: Corners of each facet of a named surface, as rows of `points`, -1 after those of
            a triangle among quadrangles.
        numbers: Number of each cell in the file, by kind; counted from 1 without.
        attached: Masses and springs, in the units of the file.
        constraints: Constraints on rows of `points`, in the units of the file.
        notes: What was left out or changed on reading, a line each.
    """

    points: Array
    cells: Mapping[str, Indices]
    sets: Mapping[str, Mapping[str, Indices]] = field(default_factory=dict)
    node_sets: Mapping[str, Indices] = field(default_factory=dict)
    facets: Mapping[str, Indices] = field(default_factory=dict)
    numbers: Mapping[str, Indices] = field(default_factory=dict)
    attached: tuple[Attachment, ...] = ()
    constraints: LinearConstraints = NO_CONSTRAINTS
    notes: tuple[str, ...] = ()

    def numbers_of(self, kind: str) -> Indices:
        """Number in the file of each cell of a kind."""
        return np.asarray(self.numbers.get(kind, np.arange(len(self.cells[kind])) + 1))


def body_cells(foreign: ForeignMesh) -> dict[str, Indices]:
    """Cells of the highest dimension, by kind."""
    dim = max(KINDS[kind][0] for kind in foreign.cells)
    return {kind: rows for kind, rows in foreign.cells.items() if KINDS[kind][0] == dim}


def in_body(foreign: ForeignMesh) -> Mask:
    """Which points cells of the highest dimension have."""
    used = np.zeros(len(foreign.points), dtype=bool)
    for rows in body_cells(foreign).values():
        used[rows] = True
    return used


@dataclass(frozen=True, slots=True)
class _Facets:
    """All facets of the cells, each once.

    Attributes:
        kind: gmsh's number of their element type.
        corners: Sorted corners, in ascending order of rows.
        nodes: All nodes of each facet in gmsh's order.
        outer: Whether it belongs to one cell alone.
    """

    kind: int
    corners: Indices
    nodes: Indices
    outer: Any

    def found(self, corners: Indices) -> Indices:
        """Row of each facet by its corners, -1 where no cell has such a facet."""
        both = np.concatenate([self.corners, np.sort(corners, axis=1)])
        _, place = np.unique(both, axis=0, return_inverse=True)
        row = np.full(int(place.max()) + 1, -1, dtype=np.int64)
        row[place[: len(self.corners)]] = np.arange(len(self.corners))
        return np.asarray(row[place[len(self.corners) :]])


def raw_mesh(name: str, foreign: ForeignMesh) -> RawMesh:
    """Cells of the highest dimension, of one kind, and facets of all sets that name some.

    A facet belongs to a set of nodes if it lies on the surface and all its nodes are in the set.
    Where several kinds of sets have one name, named surfaces and sets of flat cells come first.
    The group "body" holds all cells, unless the file gives that name to some of them.

    Args:
        name: What is read, for messages.
        foreign: What was read, put into the current gmsh model.

    Raises:
        MeshError: if the cells cannot be used, or a set names facets that the cells do not have.
    """
    dim = max(KINDS[kind][0] for kind in foreign.cells)
    bodies = [kind for kind in foreign.cells if KINDS[kind][0] == dim]
    kind = bodies[0]
    _add_cells(foreign, kind)
    if dim == 0:
        return extracted(name)  # which refuses points
    table = _facet_table(KINDS[kind][1])
    groups = _facet_groups(name, foreign, table, dim)
    for group, rows in groups.items():
        if len(rows):
            _add_facets(group, table.kind, table.nodes[rows])
    raw = extracted(name)
    none = np.empty((0, table.nodes.shape[1]), dtype=np.int64)
    return replace(
        raw,
        facets={group: raw.facets.get(group, none) for group in groups},
        nodes=_nodes_of_cells(foreign, kind),
        attached=foreign.attached,
        constraints=foreign.constraints.renumbered(_rows_of_cells(foreign, kind)),
        notes=foreign.notes,
    )


def _nodes_of_cells(foreign: ForeignMesh, kind: str) -> dict[str, Indices]:
    """Sets of nodes as rows of the points that cells have, which are numbered as they stand."""
    row = _rows_of_cells(foreign, kind)
    found = {name: row[nodes] for name, nodes in foreign.node_sets.items()}
    return {name: rows[rows >= 0] for name, rows in found.items()}


def _rows_of_cells(foreign: ForeignMesh, kind: str) -> Indices:
    """Row of each point among those that cells have, -1 for one of no cell."""
    used = np.zeros(len(foreign.points), dtype=bool)
    used[foreign.cells[kind]] = True
    return np.where(used, np.cumsum(used) - 1, -1)


def _add_cells(foreign: ForeignMesh, kind: str) -> None:
    """Add nodes and cells; cells of the same sets are one entity."""
    dim, number, _ = KINDS[kind]
    cells = foreign.cells[kind]
    cells = cells[:, GMSH_ORDER.get(kind, list(range(cells.shape[1])))] + 1
    members = {name: rows[kind] for name, rows in foreign.sets.items() if len(rows.get(kind, ()))}
    members.setdefault(_ALL_CELLS, np.arange(len(cells)))
    belongs = np.zeros((len(cells), len(members)), dtype=bool)
    for column, rows in enumerate(members.values()):
        belongs[rows, column] = True
    signatures, which = np.unique(belongs, axis=0, return_inverse=True)
    entities = [gmsh.model.addDiscreteEntity(dim) for _ in signatures]
    gmsh.model.mesh.addNodes(
        dim, entities[0], np.arange(len(foreign.points)) + 1, foreign.points.ravel()
    )
    for index, entity in enumerate(entities):
        gmsh.model.mesh.addElementsByType(entity, number, [], cells[which.ravel() == index].ravel())
    for column, name in enumerate(members):
        held = [entity for entity, row in zip(entities, signatures, strict=True) if row[column]]
        gmsh.model.addPhysicalGroup(dim, held, name=name)


def _add_facets(group: str, kind: int, nodes: Indices) -> None:
    """Add the facets of a group, of gmsh's type `kind`, as an entity of their own."""
    dim = gmsh.model.mesh.getElementProperties(kind)[1]
    entity = gmsh.model.addDiscreteEntity(dim)
    gmsh.model.mesh.addElementsByType(entity, kind, [], nodes.ravel() + 1)
    gmsh.model.addPhysicalGroup(dim, [entity], name=group)


def _facet_table(number: int) -> _Facets:
    """Facets of all cells of gmsh's type `number`."""
    mesh = gmsh.model.mesh
    shape, dim, order, width, _, _ = mesh.getElementProperties(number)
    if dim == 1:
        kind = mesh.getElementType("Point", 0)
        nodes = mesh.getElementsByType(number)[1].reshape(-1, width)[:, :2]
    elif dim == 2:
        kind = mesh.getElementType("Line", order)
        nodes = mesh.getElementEdgeNodes(number)
    else:
        name = "Triangle" if "Tetrahedron" in shape else "Quadrangle"
        kind = mesh.getElementType(name, order, "20" in shape)
        nodes = mesh.getElementFaceNodes(number, {"Triangle": 3, "Quadrangle": 4}[name])
    _, _, _, width, _, corners = mesh.getElementProperties(kind)
    nodes = nodes.reshape(-1, width).astype(np.int64) - 1
    keys, first, count = np.unique(
        np.sort(nodes[:, :corners], axis=1), axis=0, return_index=True, return_counts=True
    )
    return _Facets(kind, keys, nodes[first], count == 1)


def _facet_groups(name: str, foreign: ForeignMesh, table: _Facets, dim: int) -> dict[str, Indices]:
    """Rows of the table of each set of nodes, set of flat cells, and named surface."""
    groups: dict[str, Indices] = {}
    for group, rows in foreign.node_sets.items():
        inside = np.isin(table.nodes, rows).all(axis=1)
        groups[group] = np.flatnonzero(inside & table.outer)
    named = {group: [corners] for group, corners in foreign.facets.items()}
    for group, kinds in foreign.sets.items():
        for kind, rows in kinds.items():
            if KINDS[kind][0] == dim - 1 and len(rows):
                corners = foreign.cells[kind][rows][:, : table.corners.shape[1]]
                named.setdefault(group, []).append(corners)
    for group, parts in named.items():
        corners = np.concatenate(parts)
        rows = table.found(corners)
        if (rows < 0).any():
            x = ", ".join(f"{x:.6g}" for x in foreign.points[corners[np.argmin(rows)][0]])
            raise MeshError(
                f'{name}: {int((rows < 0).sum())} of {len(rows)} facets of "{group}" are no facets '
                f"of the body, one at ({x}): their nodes must be those of the cells"
            )
        groups[group] = np.unique(rows)
    return groups
