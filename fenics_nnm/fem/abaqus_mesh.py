"""Meshes of Abaqus and CalculiX: nodes, elements, sets and surfaces of an .inp file.

meshio keeps one *NODE block alone, no sets of sets and no surfaces, hence a reader of our own.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.abaqus_cards import Card, cards
from fenics_nnm.fem.foreign_mesh import KINDS, ForeignMesh

#: meshio's name and number of nodes of element types; what follows the first match is integration.
_ELEMENTS = {
    r"C3D4": ("tetra", 4),
    r"C3D10": ("tetra10", 10),
    r"C3D8": ("hexahedron", 8),
    r"C3D20": ("hexahedron20", 20),
    r"C3D6": ("wedge", 6),
    r"C3D15": ("wedge15", 15),
    r"C3D5": ("pyramid", 5),
    r"CP[SE]3|S3|STRI3|M3D3|SFM3D3": ("triangle", 3),
    r"CP[SE]6|S6|STRI65|M3D6|SFM3D6": ("triangle6", 6),
    r"CP[SE]4|S4|M3D4|SFM3D4": ("quad", 4),
    r"CP[SE]8|S8|M3D8|SFM3D8": ("quad8", 8),
    r"T[123]D2": ("line", 2),
}

#: Corners of the sides S1, S2 ... of an element.
_SIDES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": (
        *((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)),
        *((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    ),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
}

#: Keywords that make or move nodes and elements, or join nodes, in ways not followed here.
_UNKNOWN = (
    *("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SUBMODEL", "MATRIX INPUT"),
    *("TIE", "EQUATION", "MPC", "RIGID BODY", "EMBEDDED ELEMENT"),
)

Label = tuple[str, int]
"""Instance, "" without one, and number of a node or element."""


@dataclass(slots=True)
class _Part:
    """What one part says, or the whole file without parts; sets by their names in capitals."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
    sets: list[Card] = field(default_factory=list)


@dataclass(slots=True)
class _Model:
    """All instances together, and the sets of each kind by their names in capitals."""

    nodes: dict[Label, Array] = field(default_factory=dict)
    elements: dict[Label, tuple[str, list[Label]]] = field(default_factory=dict)
    node_sets: dict[str, list[Label]] = field(default_factory=dict)
    element_sets: dict[str, list[Label]] = field(default_factory=dict)
    surfaces: dict[str, list[list[Label]]] = field(default_factory=dict)
    written: dict[str, str] = field(default_factory=dict)


def read_abaqus(path: Path) -> ForeignMesh:
    """Read a flat input file, or one of parts, instances and an assembly.

    Sets of an instance are named "INSTANCE.SET" if there are several instances.

    Raises:
        MeshError: if the file cannot be read, or makes its mesh in a way that is not followed.
    """
    parts: dict[str, _Part] = {"": _Part()}
    instances: list[tuple[str, str, Card]] = []
    current, owner = parts[""], ""
    for card in cards(path):
        if card.keyword == "PART":
            current = parts.setdefault(card.option("NAME").upper(), _Part())
        elif card.keyword == "INSTANCE":
            owner = card.option("NAME")
            instances.append((owner, card.option("PART").upper(), card))
            current = parts.setdefault(f"\n{owner.upper()}", _Part())
        elif card.keyword in ("END PART", "END INSTANCE"):
            current = parts[""]
        else:
            _take(card, current)
    model = _Model()
    _place(model, parts[""], "", None)
    for name, part, card in instances:
        if part not in parts:
            raise MeshError(f'{card.place}: there is no part "{card.option("PART")}"')
        _place(model, parts[part], name, card)
        _place(model, parts[f"\n{name.upper()}"], name, None)
    if not model.elements:
        raise MeshError(f"mesh.file = {path}: holds no *ELEMENT")
    _name_sets(model, parts, [(name, part) for name, part, _ in instances])
    return _foreign(path, model)


def _take(card: Card, part: _Part) -> None:
    """Take what a keyword says of the mesh; most keywords say nothing of it."""
    if card.keyword in _UNKNOWN or (card.keyword == "NODE" and "SYSTEM" in card.options):
        raise MeshError(
            f"{card.place}: *{card.keyword}{' with SYSTEM' if card.keyword == 'NODE' else ''} "
            "cannot be followed: the mesh must be written out, with nodes that parts share"
        )
    if card.keyword == "NODE":
        for row in card.rows:
            part.nodes[_number(row[0], card)] = [_real(x, card) for x in row[1:4]]
        if "NSET" in card.options:
            part.sets.append(_as_set(card, "NSET", [row[0] for row in card.rows]))
    elif card.keyword == "ELEMENT":
        _take_elements(card, part)
    elif card.keyword in ("NSET", "ELSET", "SURFACE"):
        part.sets.append(card)


def _take_elements(card: Card, part: _Part) -> None:
    kind, width = _kind(card)
    numbers = [_number(entry, card) for entry in card.entries()]
    if len(numbers) % (width + 1):
        raise MeshError(
            f"{card.place}: {len(numbers)} numbers: each element of type {card.option('TYPE')} "
            f"must have its own number and {width} nodes"
        )
    rows = [numbers[i : i + width + 1] for i in range(0, len(numbers), width + 1)]
    part.elements.update({row[0]: (kind, row[1:]) for row in rows})
    if "ELSET" in card.options:
        part.sets.append(_as_set(card, "ELSET", [str(row[0]) for row in rows]))


def _as_set(card: Card, keyword: str, numbers: list[str]) -> Card:
    """The set that a block of nodes or elements is put into."""
    return Card(keyword, {keyword: card.option(keyword)}, [numbers], card.place)


def _kind(card: Card) -> tuple[str, int]:
    given = card.option("TYPE")
    for pattern, found in _ELEMENTS.items():
        if re.fullmatch(rf"({pattern})[A-Z]*\d?", given.upper()):
            return found
    raise MeshError(
        f"{card.place}: element type {given}: must be solid (C3D4, C3D10, C3D8, C3D20), plane "
        "(CPS, CPE), a shell or membrane on the surface of a solid, or a truss of 2 nodes"
    )


def _number(entry: str, card: Card) -> int:
    try:
        return int(entry)
    except ValueError as error:
        raise MeshError(f'{card.place}: "{entry}": must be a whole number') from error


def _real(entry: str, card: Card) -> float:
    try:
        return float(entry.upper().replace("D", "E")) if entry else 0.0
    except ValueError as error:
        raise MeshError(f'{card.place}: "{entry}": must be a number') from error


def _place(model: _Model, part: _Part, instance: str, card: Card | None) -> None:
    """Put nodes and elements of a part where its instance says."""
    move = _motion(card) if card is not None else None
    for number, x in part.nodes.items():
        point = np.array([*x, 0.0, 0.0, 0.0][:3])
        model.nodes[instance, number] = point if move is None else move[0] @ point + move[1]
    for number, (kind, nodes) in part.elements.items():
        model.elements[instance, number] = kind, [(instance, node) for node in nodes]


def _motion(card: Card) -> tuple[Array, Array]:
    """Rotation and shift of an instance: x -> Q x + t, moved first and then turned about an axis.

    The second data line has two points of the axis and an angle in degrees.
    """
    rows = [[_real(x, card) for x in row if x] for row in card.rows]
    shift = np.array(rows[0]) if rows else np.zeros(3)
    if shift.shape != (3,) or (len(rows) > 1 and len(rows[1]) != 7):
        raise MeshError(f"{card.place}: must be followed by 3 numbers, then 7 of a rotation")
    if len(rows) < 2:
        return np.eye(3), shift
    start, along = np.array(rows[1][:3]), np.subtract(rows[1][3:6], rows[1][:3])
    turn = np.deg2rad(rows[1][6]) * along / np.linalg.norm(along)
    Q = Rotation.from_rotvec(turn).as_matrix()
    return Q, Q @ (shift - start) + start


def _name_sets(model: _Model, parts: dict[str, _Part], instances: list[tuple[str, str]]) -> None:
    """Resolve all sets: those of each instance, then those of the file or assembly."""
    for name, part in instances:
        prefix = f"{name}." if len(instances) > 1 else ""
        for card in [*parts[part].sets, *parts[f"\n{name.upper()}"].sets]:
            _name_set(model, card, name, prefix)
    for card in parts[""].sets:
        _name_set(model, card, card.options.get("INSTANCE", ""), "")


def _name_set(model: _Model, card: Card, instance: str, prefix: str) -> None:
    name = prefix + card.option("NAME" if card.keyword == "SURFACE" else card.keyword)
    key = name.upper()
    if "INTERNAL" not in card.options:
        model.written.setdefault(key, name)
    if card.keyword == "NSET":
        found = _labels(card, instance, prefix, model.node_sets)
        if "ELSET" in card.options:
            elements = _known(model.element_sets, card.options["ELSET"], prefix, card)
            found += [node for label in elements for node in model.elements[label][1]]
        _check_known(found, model.nodes, card)
        model.node_sets.setdefault(key, []).extend(found)
    elif card.keyword == "ELSET":
        found = _labels(card, instance, prefix, model.element_sets)
        _check_known(found, model.elements, card)
        model.element_sets.setdefault(key, []).extend(found)
    elif card.options.get("TYPE", "ELEMENT").upper() == "NODE":
        first = Card(card.keyword, {}, [row[:1] for row in card.rows], card.place)
        model.node_sets.setdefault(key, []).extend(
            _labels(first, instance, prefix, model.node_sets)
        )
    else:
        model.surfaces.setdefault(key, []).extend(_sides(model, card, instance, prefix))


def _labels(card: Card, instance: str, prefix: str, sets: dict[str, list[Label]]) -> list[Label]:
    """Numbers, ranges and names of other sets, as labels."""
    if "GENERATE" in card.options:
        ranges = [[_number(entry, card) for entry in row if entry] for row in card.rows]
        if not all(len(row) in (2, 3) for row in ranges):
            raise MeshError(f"{card.place}: each line must be first, last, step")
        return [
            (instance, number)
            for first, last, *step in ranges
            for number in range(first, last + 1, *step)
        ]
    found: list[Label] = []
    for entry in card.entries():
        owner, _, last = entry.rpartition(".")
        if last.lstrip("+-").isdigit():
            found.append((owner or instance, int(last)))
        else:
            found += _known(sets, entry, prefix, card)
    return found


def _known(sets: dict[str, list[Label]], name: str, prefix: str, card: Card) -> list[Label]:
    """A set by its name: of the same instance, or of an only instance with or without its name."""
    for key in (prefix + name, name, name.rpartition(".")[2]):
        if key.strip('"').upper() in sets:
            return sets[key.strip('"').upper()]
    raise MeshError(f'{card.place}: there is no set "{name}" before')


def _check_known(labels: Iterable[Label], known: Iterable[Label], card: Card) -> None:
    missing = [label for label in labels if label not in known]
    if missing:
        raise MeshError(
            f"{card.place}: {len(missing)} members are not in the file, one is {missing[0][1]}"
        )


def _sides(model: _Model, card: Card, instance: str, prefix: str) -> list[list[Label]]:
    """Corners of the sides that the lines of a surface name: a set or element, and a side."""
    found = []
    for row in card.rows:
        first = Card("ELSET", {}, [row[:1]], card.place)
        members = _labels(first, instance, prefix, model.element_sets)
        _check_known(members, model.elements, card)
        side = row[1].upper() if len(row) > 1 else ""
        if not side:
            found += _free_sides(model, members)
            continue
        for label in members:
            kind, nodes = model.elements[label]
            corners = _corners(kind, side, card)
            found.append([nodes[i] for i in corners])
    return found


def _corners(kind: str, side: str, card: Card) -> tuple[int, ...]:
    """Places of the corners of a side: S1, S2 ... of a solid, SPOS or SNEG of a shell."""
    shape = kind.rstrip("0123456789")
    sides = _SIDES.get(shape, ())
    number = int(side[1:]) if re.fullmatch(r"S\d", side) else 0
    if side in ("SPOS", "SNEG") and shape in ("triangle", "quad"):
        return tuple(range(len(sides)))
    if not 1 <= number <= len(sides):
        raise MeshError(f"{card.place}: {side} is no side of a {shape}")
    return sides[number - 1]


def _free_sides(model: _Model, members: list[Label]) -> list[list[Label]]:
    """Sides of elements that no other element has; elements of the largest dimension count."""
    dim = max(KINDS[kind][0] for kind, _ in model.elements.values())
    owners: dict[frozenset[Label], int] = {}
    sides = {}
    for label, (kind, nodes) in model.elements.items():
        if KINDS[kind][0] == dim:
            shape = kind.rstrip("0123456789")
            sides[label] = [[nodes[i] for i in side] for side in _SIDES.get(shape, ())]
            for side in sides[label]:
                owners[frozenset(side)] = owners.get(frozenset(side), 0) + 1
    return [
        side for label in members for side in sides.get(label, []) if owners[frozenset(side)] == 1
    ]


def _foreign(path: Path, model: _Model) -> ForeignMesh:
    """Labels as rows of arrays."""
    node = {label: row for row, label in enumerate(model.nodes)}
    kinds: dict[str, list[list[int]]] = {}
    place: dict[Label, tuple[str, int]] = {}
    for label, (kind, nodes) in model.elements.items():
        if any(n not in node for n in nodes):
            raise MeshError(f"mesh.file = {path}: element {label[1]} has a node without *NODE")
        rows = kinds.setdefault(kind, [])
        place[label] = kind, len(rows)
        rows.append([node[n] for n in nodes])
    dims = {KINDS[kind][0] for kind in kinds}
    if dims >= {1, 3}:
        raise MeshError(f"mesh.file = {path}: has trusses beside solids: must be solids alone")
    sets: dict[str, dict[str, Indices]] = {}
    for key, labels in model.element_sets.items():
        for kind in kinds:
            rows_of = [place[label][1] for label in labels if place[label][0] == kind]
            if key in model.written and rows_of:
                sets.setdefault(model.written[key], {})[kind] = np.unique(rows_of)
    return ForeignMesh(
        points=np.array(list(model.nodes.values())),
        cells={kind: np.array(rows) for kind, rows in kinds.items()},
        sets=sets,
        node_sets={
            model.written[key]: np.array([node[label] for label in labels], dtype=np.int64)
            for key, labels in model.node_sets.items()
            if key in model.written
        },
        facets={
            model.written[key]: np.array([[node[n] for n in side] for side in sides])
            for key, sides in model.surfaces.items()
            if key in model.written and sides
        },
    )
