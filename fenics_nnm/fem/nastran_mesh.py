"""Nastran bulk data: grid points, elements and the names of their properties.

meshio stops at usual forms of large fields, and gmsh drops the middle nodes of CHEXA, hence a
reader of our own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.foreign_mesh import ForeignMesh

#: meshio's name of each element by its number of nodes, and VTK's order where it differs.
_ELEMENTS = {
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
    "CPYRAM": {5: "pyramid", 13: "pyramid13"},
    "CTRIA3": {3: "triangle"},
    "CTRIA6": {6: "triangle6"},
    "CQUAD4": {4: "quad"},
    "CQUAD8": {8: "quad8"},
}
_VTK_ORDER = {"hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15]}

#: Cards that add stiffness or mass, or make nodes move together.
_REFUSED = re.compile(
    r"C(BAR|BEAM|BEND|ROD|TUBE|ELAS\d|BUSH|DAMP\d|MASS\d|GAP|ONM\d)|RBE\d|RBAR|MPC"
)

#: Comments that name a property: of HyperMesh, FEMAP and, standing before it, Patran.
_NUMBERED = (
    re.compile(r"\$HMNAME\s+(?:COMP|PROP)\s+(\d+)\s*\"([^\"]+)\""),
    re.compile(r"\$\s*Femap.*Property\s+(\d+)\s*:\s*(.+)", re.IGNORECASE),
)
_BEFORE = re.compile(r"\$\s*Elements and Element Properties for region\s*:\s*(.+)")


@dataclass(frozen=True, slots=True)
class _Card:
    """Fields of a card with those of its continuations, and where it begins."""

    name: str
    fields: list[str]
    place: str

    def whole(self, index: int) -> int:
        """A field as a whole number."""
        entry = self.fields[index] if index < len(self.fields) else ""
        try:
            return int(entry)
        except ValueError as error:
            raise MeshError(
                f'{self.place}: {self.name}: "{entry}" must be a whole number'
            ) from error

    def real(self, index: int) -> float:
        """A field as a real number, such as 1.5, 1.5E-3, 1.5D-3 or 1.5-3."""
        entry = self.fields[index] if index < len(self.fields) else ""
        text = re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", entry.upper().replace("D", "E"))
        try:
            return float(text) if text else 0.0
        except ValueError as error:
            raise MeshError(f'{self.place}: {self.name}: "{entry}" must be a number') from error


def read_nastran(path: Path) -> ForeignMesh:
    """Read bulk data, with a set for each property.

    The set of property 3 is "PID 3", and also the name that a comment gives it.

    Raises:
        MeshError: if the file cannot be followed.
    """
    lines = path.read_text(errors="replace").splitlines()
    row: dict[int, int] = {}
    points: list[list[float]] = []
    elements: dict[str, list[tuple[int, list[int], str]]] = {}
    for card in _cards(path, lines):
        if card.name == "GRID":
            _check_system(card, 1)
            row[card.whole(0)] = len(points)
            points.append([card.real(index) for index in (2, 3, 4)])
        elif card.name == "GRDSET":
            _check_system(card, 1)
        elif card.name in _ELEMENTS:
            kind, nodes = _element(card)
            elements.setdefault(kind, []).append((card.whole(1), nodes, card.place))
        elif _REFUSED.fullmatch(card.name):
            raise MeshError(
                f"{card.place}: {card.name} cannot be followed: must be solid or plane elements "
                "alone, without bars, springs, masses and links"
            )
    cells = {kind: _rows(kind, members, row) for kind, members in elements.items()}
    return ForeignMesh(np.array(points).reshape(-1, 3), cells, _sets(elements, _names(lines)))


def _element(card: _Card) -> tuple[str, list[int]]:
    """Kind and nodes of an element; fields after its nodes are thickness and the like."""
    kinds = _ELEMENTS[card.name]
    most = max(kinds)
    given = [entry for entry in card.fields[2 : 2 + most] if entry]
    if len(given) not in kinds:
        counts = " or ".join(map(str, kinds))
        raise MeshError(f"{card.place}: {card.name} with {len(given)} nodes: must have {counts}")
    return kinds[len(given)], [card.whole(index) for index in range(2, 2 + len(given))]


def _rows(kind: str, members: list[tuple[int, list[int], str]], row: dict[int, int]) -> Indices:
    """Rows of the points of all elements of a kind, in VTK's order."""
    for _, nodes, place in members:
        missing = [node for node in nodes if node not in row]
        if missing:
            raise MeshError(f"{place}: there is no GRID {missing[0]}")
    cells = np.array([[row[node] for node in nodes] for _, nodes, _ in members])
    return cells[:, _VTK_ORDER[kind]] if kind in _VTK_ORDER else cells


def _sets(
    elements: dict[str, list[tuple[int, list[int], str]]], names: dict[int, str]
) -> dict[str, dict[str, Indices]]:
    """Elements of each property, by its number and its name."""
    sets: dict[str, dict[str, Indices]] = {}
    for kind, members in elements.items():
        owner = np.array([pid for pid, _, _ in members])
        for pid in np.unique(owner):
            rows = np.flatnonzero(owner == pid)
            for name in dict.fromkeys((f"PID {pid}", names.get(int(pid), f"PID {pid}"))):
                parts = sets.setdefault(name, {})
                parts[kind] = np.union1d(parts.get(kind, np.empty(0, dtype=np.int64)), rows)
    return sets


def _check_system(card: _Card, index: int) -> None:
    """Refuse coordinates in a system of their own."""
    system = card.fields[index] if index < len(card.fields) else ""
    if system not in ("", "0"):
        raise MeshError(
            f"{card.place}: {card.name}: coordinates in system {system}: must be in the basic "
            "system, 0: write the grid out in it"
        )


def _cards(path: Path, lines: list[str]) -> Iterator[_Card]:
    """Cards of the bulk data, their continuations joined."""
    begin = next((i for i, line in enumerate(lines) if re.match(r"BEGIN\s+BULK", line.upper())), -1)
    current: _Card | None = None
    for number in range(begin + 1, len(lines)):
        line = lines[number].partition("$")[0].expandtabs(8).rstrip()
        if not line:
            continue
        if line.upper().startswith("ENDDATA"):
            break
        name, fields = _split(line)
        if name == "INCLUDE":
            raise MeshError(f"{path}, line {number + 1}: INCLUDE: must be one file")
        if current is not None and (not name or name.startswith("+")):
            current.fields.extend(fields)
            continue
        if current is not None:
            yield current
        current = _Card(name, fields, f"{path}, line {number + 1}")
    if current is not None:
        yield current


def _split(line: str) -> tuple[str, list[str]]:
    """Name and fields of one line, in free, small or large fields, without continuation marks.

    A line of large fields has four of them, a line of small ones eight; a continuation has no name
    or one that begins with + or *.
    """
    if "," in line:
        first, *fields = (part.strip() for part in line.split(","))
        count = 4 if first.endswith("*") or first.startswith("*") else 8
        fields = [*fields, *[""] * count][:count]
    else:
        first = line[:8].strip()
        wide = first.endswith("*") or first.startswith("*")
        width = 16 if wide else 8
        fields = [line[i : i + width].strip() for i in range(8, 72, width)]
    name = first.upper().rstrip("*").strip()
    if first.startswith(("*", "+")):
        name = ""
    return name.split(" ")[0], fields


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
