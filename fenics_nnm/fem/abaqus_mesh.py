"""Meshes of Abaqus and CalculiX: nodes, elements, sets and surfaces of an .inp file.

meshio keeps one *NODE block alone, no sets of sets and no surfaces, hence a reader of our own.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.abaqus_cards import Card, cards, real_number, whole_number
from fenics_nnm.fem.abaqus_carriers import CARRIERS, Carriers
from fenics_nnm.fem.abaqus_constraints import Constraints, tied
from fenics_nnm.fem.abaqus_joints import Joiner
from fenics_nnm.fem.abaqus_keywords import is_stated, left_out
from fenics_nnm.fem.abaqus_named import Named, Owner, nowhere
from fenics_nnm.fem.abaqus_sets import Label, Model, name_set
from fenics_nnm.fem.cell_shapes import facet_table
from fenics_nnm.fem.constraint_builder import ConstraintBuilder
from fenics_nnm.fem.coordinates import in_rectangular
from fenics_nnm.fem.foreign_mesh import ForeignMesh, body_cells, in_body
from fenics_nnm.fem.merging import merged_by_equations

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
    r"T[23]D3": ("line3", 3),
    r"MASS|ROTARYI|SPRING1": ("vertex", 1),
}


@dataclass(slots=True)
class _Part:
    """What one part says, or the whole file without parts; sets by their names in capitals."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
    sets: list[Card] = field(default_factory=list)


@dataclass(slots=True)
class _File:
    """All parts of a file, "" for what stands outside of parts, and notes on what was not read."""

    parts: dict[str, _Part] = field(default_factory=lambda: {"": _Part()})
    instances: list[tuple[str, str, Card]] = field(default_factory=list)
    constraints: Constraints = field(default_factory=Constraints)
    stated: list[str] = field(default_factory=list)
    in_steps: list[str] = field(default_factory=list)
    spare: int = 0

    @property
    def notes(self) -> tuple[str, ...]:
        """What was not read, a line each."""
        spare = f"{self.spare} numbers to spare on the lines of elements are not read"
        return (
            *left_out(self.stated, ", which the study states or which have no effect here"),
            *left_out(self.in_steps, ", which stand after the first *STEP"),
            *((spare,) if self.spare else ()),
        )


def read_abaqus(path: Path) -> ForeignMesh:
    """Read a flat input file, or one of parts, instances and an assembly.

    Sets of an instance are named "INSTANCE.SET" if there are several instances. What stands after
    the first *STEP is not read.

    Raises:
        MeshError: if the file cannot be read, or makes its mesh in a way that is not followed.
    """
    file = _read(path)
    file.constraints.assert_whole()
    model = Model()
    _place(model, file.parts[""], "", None)
    for name, part, card in file.instances:
        if part not in file.parts:
            raise MeshError(f'{card.place}: there is no part "{card.option("PART")}"')
        _place(model, file.parts[part], name, card)
        _place(model, file.parts[f"\n{name.upper()}"], name, None)
    if not model.elements:
        raise MeshError(f"mesh file {path}: holds no *ELEMENT", code=Code.MESH_FILE)
    _name_sets(model, file.parts, [(name, part) for name, part, _ in file.instances])
    foreign = replace(_foreign(path, model), notes=file.notes)
    return merged_by_equations(tied(_joined(foreign, model, file), file.constraints.ties))


def _joined(foreign: ForeignMesh, model: Model, file: _File) -> ForeignMesh:
    """The mesh with what keywords say of nodes that move together."""
    joints = file.constraints.joints
    if not joints:
        return foreign
    turned = [joint for joint, _ in joints if joint.turned]
    if turned and "TRANSFORM" in file.stated:
        card = turned[0].card
        raise MeshError(
            f"{card.place}: *{card.keyword} cannot be followed beside *TRANSFORM, which turns its "
            "directions"
        )
    builder = ConstraintBuilder(
        {label: row for row, label in enumerate(model.nodes)},
        foreign.points,
        in_body(foreign),
        lambda label: f"node {label[1]}",
        _names_of_nodes(model),
        nowhere,
    )
    named = Named(model, builder, facet_table(body_cells(foreign)))
    joiner, carriers = Joiner(named), Carriers(named)
    for joint, part in joints:
        for owner in _owners(file, part):
            if joint.card.keyword in CARRIERS:
                carriers.take(joint.card, owner)
            else:
                joiner.take(joint, owner)
    joiner.assert_spread()
    notes = dict.fromkeys([*joiner.notes, *carriers.notes])
    return replace(foreign, constraints=builder.found, notes=(*foreign.notes, *notes))


def _owners(file: _File, part: str) -> list[Owner]:
    """Owners of the numbers of a keyword: of each instance of its part, or of the assembly."""
    own = [
        Owner(name, f"{name}." if len(file.instances) > 1 else "")
        for name, of, _ in file.instances
        if part in (of, f"\n{name.upper()}")
    ]
    return own if part else [Owner("", "")]


def _names_of_nodes(model: Model) -> Callable[[Label], tuple[str, ...]]:
    """Names of the sets of each node, besides that of its number."""
    names: dict[Label, list[str]] = {}
    for key, labels in model.node_sets.items():
        for label in labels:
            names.setdefault(label, []).append(model.written.get(key, key))
    return lambda label: (*names.get(label, ()), f"node {label[1]}")


def _read(path: Path) -> _File:
    """All keywords before the first *STEP, each taken by its part."""
    file = _File()
    name, current = "", file.parts[""]
    for card in cards(path):
        if file.in_steps or card.keyword == "STEP":
            file.in_steps.append(card.keyword)
        elif card.keyword == "PART":
            name = card.option("NAME").upper()
            current = file.parts.setdefault(name, _Part())
        elif card.keyword == "INSTANCE":
            owner = card.option("NAME")
            file.instances.append((owner, card.option("PART").upper(), card))
            name = f"\n{owner.upper()}"
            current = file.parts.setdefault(name, _Part())
        elif card.keyword in ("END PART", "END INSTANCE"):
            name, current = "", file.parts[""]
        elif not file.constraints.take(card, name):
            _take(card, current, file)
    return file


def _take(card: Card, part: _Part, file: _File) -> None:
    """Take what a keyword says of the mesh; most keywords say nothing of it."""
    if card.keyword == "NODE":
        _take_nodes(card, part)
    elif card.keyword == "ELEMENT":
        _take_elements(card, part, file)
    elif card.keyword in ("NSET", "ELSET", "SURFACE"):
        part.sets.append(card)
    elif is_stated(card):
        file.stated.append(card.keyword)


def _take_nodes(card: Card, part: _Part) -> None:
    system = card.options.get("SYSTEM", "R").upper()
    if system not in ("R", "C", "S"):
        raise MeshError(f"{card.place}: *NODE, SYSTEM={system}: must be R, C or S")
    for row in card.rows:
        number = whole_number(row[0], card)
        x = [real_number(entry, card) for entry in [*row[1:4], "", "", ""][:3]]
        place = in_rectangular(x, system)
        if part.nodes.setdefault(number, place) != place:
            raise MeshError(f"{card.place}: node {number} stands twice, at different places")
    if "NSET" in card.options:
        part.sets.append(_as_set(card, "NSET", [row[0] for row in card.rows]))


def _take_elements(card: Card, part: _Part, file: _File) -> None:
    kind, width = _kind(card)
    rows = []
    for numbers in _element_rows(card, width + 1):
        file.spare += len(numbers) - width - 1
        row = kind, numbers[1 : width + 1]
        if part.elements.setdefault(numbers[0], row) != row:
            raise MeshError(f"{card.place}: element {numbers[0]} stands twice, with other nodes")
        rows.append(str(numbers[0]))
    if "ELSET" in card.options:
        part.sets.append(_as_set(card, "ELSET", rows))


def _element_rows(card: Card, width: int) -> Iterator[list[int]]:
    """Numbers of each element: of one line, which may go on; a line may have some to spare."""
    numbers: list[int] = []
    going_on = True
    for row in card.rows:
        before = len(numbers)
        numbers += [whole_number(entry, card) for entry in row if entry]
        if before and not going_on and len(numbers) > width:
            break
        going_on = row[-1] == ""
        if len(numbers) >= width:
            yield numbers
            numbers = []
    if numbers:
        raise MeshError(
            f"{card.place}: {len(numbers)} numbers: each element of type {card.option('TYPE')} "
            f"must have its own number and {width - 1} nodes"
        )


def _as_set(card: Card, keyword: str, numbers: list[str]) -> Card:
    """The set that a block of nodes or elements is put into."""
    return Card(keyword, {keyword: card.option(keyword)}, [numbers], card.place)


def _kind(card: Card) -> tuple[str, int]:
    given = card.option("TYPE")
    for pattern, found in _ELEMENTS.items():
        if re.fullmatch(rf"({pattern})[A-Z]*\d?", given.upper()):
            return found
    raise MeshError(
        f"{card.place}: element type {given}: must be solid (C3D4, C3D10, C3D8, C3D20, C3D6, "
        "C3D15), plane (CPS, CPE), a shell or membrane on the surface of a solid, a truss, or a "
        "mass or spring to the ground (MASS, ROTARYI, SPRING1)"
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
    numbers: dict[str, list[int]] = {}
    place: dict[Label, tuple[str, int]] = {}
    for label, (kind, nodes) in model.elements.items():
        if any(n not in node for n in nodes):
            raise MeshError(
                f"mesh file {path}: element {label[1]} has a node without *NODE",
                code=Code.MESH_FILE,
            )
        rows = kinds.setdefault(kind, [])
        numbers.setdefault(kind, []).append(label[1])
        place[label] = kind, len(rows)
        rows.append([node[n] for n in nodes])
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
            model.written[key]: _padded([[node[n] for n in side] for side in sides])
            for key, sides in model.surfaces.items()
            if key in model.written and sides
        },
        numbers={kind: np.array(found) for kind, found in numbers.items()},
    )


def _padded(sides: list[list[int]]) -> Indices:
    """Corners of sides as rows of one width, -1 after the shorter ones."""
    width = max(map(len, sides))
    return np.array([side + [-1] * (width - len(side)) for side in sides], dtype=np.int64)
