"""Meshes of Abaqus and CalculiX: nodes, elements, sets and surfaces of an .inp file.

meshio keeps one *NODE block alone, no sets of sets and no surfaces, hence a reader of our own.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.abaqus_cards import Card, cards, real_number, whole_number
from fenics_nnm.fem.abaqus_sets import Label, Model, name_set
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

#: Keywords that make or move nodes and elements, or join nodes, in ways not followed here.
_UNKNOWN = (
    *("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SUBMODEL", "MATRIX INPUT"),
    *("TIE", "EQUATION", "MPC", "RIGID BODY", "EMBEDDED ELEMENT"),
)


@dataclass(slots=True)
class _Part:
    """What one part says, or the whole file without parts; sets by their names in capitals."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
    sets: list[Card] = field(default_factory=list)


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
    model = Model()
    _place(model, parts[""], "", None)
    for name, part, card in instances:
        if part not in parts:
            raise MeshError(f'{card.place}: there is no part "{card.option("PART")}"')
        _place(model, parts[part], name, card)
        _place(model, parts[f"\n{name.upper()}"], name, None)
    if not model.elements:
        raise MeshError(f"mesh file {path}: holds no *ELEMENT", code=Code.MESH_FILE)
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
            part.nodes[whole_number(row[0], card)] = [real_number(x, card) for x in row[1:4]]
        if "NSET" in card.options:
            part.sets.append(_as_set(card, "NSET", [row[0] for row in card.rows]))
    elif card.keyword == "ELEMENT":
        _take_elements(card, part)
    elif card.keyword in ("NSET", "ELSET", "SURFACE"):
        part.sets.append(card)


def _take_elements(card: Card, part: _Part) -> None:
    kind, width = _kind(card)
    numbers = [whole_number(entry, card) for entry in card.entries()]
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


def _place(model: Model, part: _Part, instance: str, card: Card | None) -> None:
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
    rows = [[real_number(x, card) for x in row if x] for row in card.rows]
    shift = np.array(rows[0]) if rows else np.zeros(3)
    if shift.shape != (3,) or (len(rows) > 1 and len(rows[1]) != 7):
        raise MeshError(f"{card.place}: must be followed by 3 numbers, then 7 of a rotation")
    if len(rows) < 2:
        return np.eye(3), shift
    start, along = np.array(rows[1][:3]), np.subtract(rows[1][3:6], rows[1][:3])
    turn = np.deg2rad(rows[1][6]) * along / np.linalg.norm(along)
    Q = Rotation.from_rotvec(turn).as_matrix()
    return Q, Q @ (shift - start) + start


def _name_sets(model: Model, parts: dict[str, _Part], instances: list[tuple[str, str]]) -> None:
    """Resolve all sets: those of each instance, then those of the file or assembly."""
    for name, part in instances:
        prefix = f"{name}." if len(instances) > 1 else ""
        for card in [*parts[part].sets, *parts[f"\n{name.upper()}"].sets]:
            name_set(model, card, name, prefix)
    for card in parts[""].sets:
        name_set(model, card, card.options.get("INSTANCE", ""), "")


def _foreign(path: Path, model: Model) -> ForeignMesh:
    """Labels as rows of arrays."""
    node = {label: row for row, label in enumerate(model.nodes)}
    kinds: dict[str, list[list[int]]] = {}
    place: dict[Label, tuple[str, int]] = {}
    for label, (kind, nodes) in model.elements.items():
        if any(n not in node for n in nodes):
            raise MeshError(
                f"mesh file {path}: element {label[1]} has a node without *NODE",
                code=Code.MESH_FILE,
            )
        rows = kinds.setdefault(kind, [])
        place[label] = kind, len(rows)
        rows.append([node[n] for n in nodes])
    dims = {KINDS[kind][0] for kind in kinds}
    if dims >= {1, 3}:
        raise MeshError(
            f"mesh file {path}: has trusses beside solids: must be solids alone",
            code=Code.MESH_FILE,
        )
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
