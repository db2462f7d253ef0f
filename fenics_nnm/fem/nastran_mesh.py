"""Nastran bulk data: grid points, elements and the names of their properties.

meshio stops at usual forms of large fields, and gmsh drops the middle nodes of CHEXA, hence a
reader of our own.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.constraint_builder import ConstraintBuilder
from fenics_nnm.fem.foreign_mesh import ForeignMesh, in_body
from fenics_nnm.fem.merging import merged_by_equations
from fenics_nnm.fem.nastran_attached import NAMES, attached, carried, grid_of
from fenics_nnm.fem.nastran_cards import BulkCard, Line, bulk_cards, lines_of
from fenics_nnm.fem.nastran_keywords import is_stated, refuse
from fenics_nnm.fem.nastran_rigid import NAMES as RIGID
from fenics_nnm.fem.nastran_rigid import RigidElements, chosen_equations
from fenics_nnm.fem.nastran_systems import Systems

#: meshio's name of each element by its number of nodes, and VTK's order where it differs.
_ELEMENTS = {
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
    "CPYRAM": {5: "pyramid", 13: "pyramid13"},
    "CPYRA": {5: "pyramid", 13: "pyramid13"},
    "CTRIA3": {3: "triangle"},
    "CTRIAR": {3: "triangle"},
    "CTRIA6": {6: "triangle6"},
    "CQUAD4": {4: "quad"},
    "CQUADR": {4: "quad"},
    "CQUAD8": {8: "quad8"},
}
_VTK_ORDER = {
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
}

#: Lines, which gmsh writes along the edges of a body, and the properties that make them bars.
_LINES = ("CBAR", "CBEAM", "CROD", "CTUBE")
_LINE_PROPERTIES = ("PBAR", "PBARL", "PBEAM", "PBEAML", "PROD", "PTUBE")
_SCALAR_PROPERTIES = ("PELAS", "PMASS")

#: Comments that name a property: of HyperMesh, FEMAP and, standing before it, Patran.
_NUMBERED = (
    re.compile(r"\$HMNAME\s+(?:COMP|PROP)\s+(\d+)\s*\"([^\"]+)\""),
    re.compile(r"\$\s*Femap.*Property\s+(\d+)\s*:\s*(.+)", re.IGNORECASE),
)
_BEFORE = re.compile(r"\$\s*Elements and Element Properties for region\s*:\s*(.+)")


@dataclass(frozen=True, slots=True)
class _Element:
    """Number of the element, of its property and of its GRIDs, and where it stands."""

    number: int
    property: int
    nodes: list[int]
    place: str


@dataclass(slots=True)
class _Bulk:
    """What the cards of a file say."""

    systems: Systems = field(default_factory=Systems)
    elements: dict[str, list[_Element]] = field(default_factory=dict)
    lines: list[BulkCard] = field(default_factory=list)
    scalars: list[BulkCard] = field(default_factory=list)
    rigid: list[BulkCard] = field(default_factory=list)
    properties: dict[tuple[str, int], BulkCard] = field(default_factory=dict)
    stated: list[str] = field(default_factory=list)

    def take(self, card: BulkCard) -> None:
        """Take a card.

        Raises:
            MeshError: if it cannot be followed.
        """
        if self.systems.take(card):
            return
        if card.name in (*_LINE_PROPERTIES, *_SCALAR_PROPERTIES):
            self.properties[card.name, card.whole(0)] = card
        if card.name in _ELEMENTS:
            kind, nodes = _element(card)
            self._add(
                kind, _Element(card.whole(0), card.whole(1, card.whole(0)), nodes, card.place)
            )
        elif card.name in _LINES:
            self.lines.append(card)
        elif card.name in NAMES:
            self.scalars.append(card)
        elif card.name in RIGID:
            self.rigid.append(card)
        elif is_stated(card):
            self.stated.append(card.name)
        elif card.name not in _SCALAR_PROPERTIES:
            refuse(card)

    def take_lines(self) -> None:
        """Take lines without a property as lines; with one they are bars.

        Raises:
            MeshError: if one has a property.
        """
        known = {number for name, number in self.properties if name in _LINE_PROPERTIES}
        for card in self.lines:
            number = card.whole(1, card.whole(0))
            if number in known:
                refuse(card)
            nodes = [card.whole(2), card.whole(3)]
            self._add("line", _Element(card.whole(0), number, nodes, card.place))

    def _add(self, kind: str, element: _Element) -> None:
        self.elements.setdefault(kind, []).append(element)


def read_nastran(path: Path) -> ForeignMesh:
    """Read bulk data, with a set for each property.

    The set of property 3 is "PID 3", and also the name that a comment gives it.

    Raises:
        MeshError: if the file cannot be followed.
    """
    lines = list(lines_of(path))
    bulk = _Bulk()
    for card in bulk_cards(lines):
        bulk.take(card)
    bulk.take_lines()
    if not bulk.elements:
        raise MeshError(
            f"mesh file {path}: holds no elements of Nastran bulk data", code=Code.MESH_FILE
        )
    _assert_numbers(bulk)
    used = {node: e.place for es in bulk.elements.values() for e in es for node in e.nodes}
    points = np.array([bulk.systems.place(node, place) for node, place in used.items()])
    row = {node: index for index, node in enumerate(used)}
    stated = ", ".join(dict.fromkeys(bulk.stated))
    note = f"not read: {stated}, which the study states or which have no effect here"
    foreign = ForeignMesh(
        points.reshape(-1, 3),
        {kind: _rows(kind, members, row) for kind, members in bulk.elements.items()},
        _sets(bulk.elements, _names([line.text for line in lines])),
        numbers={
            kind: np.array([element.number for element in members])
            for kind, members in bulk.elements.items()
        },
        notes=(note,) if stated else (),
    )
    return merged_by_equations(_joined(foreign, bulk, row, lines))


def _joined(
    foreign: ForeignMesh, bulk: _Bulk, row: dict[int, int], lines: list[Line]
) -> ForeignMesh:
    """The mesh with rigid elements and equations, and with masses and springs at its GRIDs."""
    builder = ConstraintBuilder[int](
        row,
        foreign.points,
        in_body(foreign),
        lambda grid: f"GRID {grid}",
        lambda grid: (f"GRID {grid}",),
        bulk.systems.place,
    )
    rigid = RigidElements(bulk.systems, builder)
    for card in bulk.rigid:
        if not card.name.startswith("MPC"):
            rigid.take(card)
    chosen, note = chosen_equations([c for c in bulk.rigid if c.name.startswith("MPC")], lines)
    for card in chosen:
        rigid.equations(card)
    masses = []
    for card in bulk.scalars:
        grid = grid_of(card)
        if builder.in_body(grid) or not builder.uses(grid):
            masses.append(attached(card, bulk.properties, bulk.systems))
            continue
        mass, stiffness = carried(card, bulk.properties, bulk.systems)
        builder.carry(f"{card.place}: {card.name}", grid, mass=mass, stiffness=stiffness)
        amount = f", {mass[0][0]:g} kg," if mass[0][0] else ""
        rigid.notes.append(f"{card.name} {card.whole(0)}{amount} at GRID {grid}")
    counted = f"MPC: {len(chosen)} equations between displacements"
    notes = (*rigid.notes, *((counted,) if chosen else ()), *((note,) if note else ()))
    return replace(
        foreign,
        constraints=builder.found,
        attached=tuple(masses),
        notes=(*foreign.notes, *dict.fromkeys(notes)),
    )


def _assert_numbers(bulk: _Bulk) -> None:
    """Refuse elements of one number."""
    known: dict[int, str] = {}
    for members in bulk.elements.values():
        for element in members:
            if element.number in known:
                raise MeshError(
                    f"{element.place}: element {element.number} stands twice, first at "
                    f"{known[element.number]}"
                )
            known[element.number] = element.place


def _element(card: BulkCard) -> tuple[str, list[int]]:
    """Kind and nodes of an element; fields after its nodes are thickness and the like."""
    kinds = _ELEMENTS[card.name]
    most = max(kinds)
    given = [entry for entry in card.fields[2 : 2 + most] if entry]
    if len(given) not in kinds:
        counts = " or ".join(map(str, kinds))
        raise MeshError(f"{card.place}: {card.name} with {len(given)} nodes: must have {counts}")
    return kinds[len(given)], [card.whole(index) for index in range(2, 2 + len(given))]


def _rows(kind: str, members: list[_Element], row: dict[int, int]) -> Indices:
    """Rows of the points of all elements of a kind, in VTK's order."""
    cells = np.array([[row[node] for node in element.nodes] for element in members])
    return cells[:, _VTK_ORDER[kind]] if kind in _VTK_ORDER else cells


def _sets(
    elements: dict[str, list[_Element]], names: dict[int, str]
) -> dict[str, dict[str, Indices]]:
    """Elements of each property, by its number and its name."""
    sets: dict[str, dict[str, Indices]] = {}
    for kind, members in elements.items():
        owner = np.array([element.property for element in members])
        for pid in np.unique(owner):
            rows = np.flatnonzero(owner == pid)
            for name in dict.fromkeys((f"PID {pid}", names.get(int(pid), f"PID {pid}"))):
                parts = sets.setdefault(name, {})
                parts[kind] = np.union1d(parts.get(kind, np.empty(0, dtype=np.int64)), rows)
    return sets


def _names(lines: list[str]) -> dict[int, str]:
    """Names of properties by their number."""
    names: dict[int, str] = {}
    waiting = ""
    for line in lines:
        for pattern in _NUMBERED:
            if found := pattern.match(line):
                names[int(found[1])] = found[2].strip()
        if before := _BEFORE.match(line):
            waiting = before[1].strip()
        card = re.match(r"P(?:SOLID|SHELL|LPLANE)\*?[\s,]+(\d+)", line.upper())
        if card and waiting:
            names.setdefault(int(card[1]), waiting)
            waiting = ""
    return names
