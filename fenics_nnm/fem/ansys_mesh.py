"""Meshes of Ansys: nodes, elements and components of an archive (.cdb) or input file (.dat)."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.ansys_blocks import Block, blocks, expanded
from fenics_nnm.fem.ansys_commands import assert_followed, assert_plane
from fenics_nnm.fem.cell_shapes import shape_of
from fenics_nnm.fem.foreign_mesh import ForeignMesh

#: Kind by the number of nodes, of solids, plane elements, and shells and surface elements.
_SOLIDS = {4: "tetra", 10: "tetra10", 8: "hexahedron", 20: "hexahedron20"}
_PLANES = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}
_KINDS = {
    **dict.fromkeys((45, 95, 92, 185, 186, 187, 285, 72, 73, 64), _SOLIDS),
    **dict.fromkeys((42, 82, 2, 182, 183), _PLANES),
}
_SKINS = (63, 93, 151, 152, 153, 154, 156, 181, 281, 41, 200)

#: Lengths of the systems of units that /UNITS may name; it changes nothing in Ansys.
_LENGTHS = {"SI": "m", "MKS": "m", "UMKS": "um", "CGS": "cm", "MPA": "mm", "BFT": "ft", "BIN": "in"}

#: Elements that change a structure, by number.
_NAMES = {
    **{14: "COMBIN14", 21: "MASS21", 39: "COMBIN39", 40: "COMBIN40", 179: "PRETS179"},
    **{184: "MPC184", 188: "BEAM188", 189: "BEAM189", 180: "LINK180", 190: "SOLSH190"},
    **{number: f"CONTA{number}" for number in (171, 172, 173, 174, 175, 176, 177, 178)},
    **{169: "TARGE169", 170: "TARGE170", 185: "SOLID185"},
}


@dataclass(slots=True)
class _Model:
    """What a file says; elements by number with type, material and nodes."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    types: dict[int, int] = field(default_factory=dict)
    elements: dict[int, tuple[str, int, int, list[int]]] = field(default_factory=dict)
    components: list[tuple[str, str, Indices, str]] = field(default_factory=list)
    skins: int = 0
    units: str = ""


def read_ansys(path: Path) -> ForeignMesh:
    """Read the mesh with its components; "TYPE n" and "MAT n" are groups of elements too.

    Raises:
        MeshError: if the file cannot be read, or changes its structure in a way not followed.
    """
    model = _Model()
    current = 0
    for block in blocks(path):
        assert_followed(block)
        if block.name == "TYPE" and len(block.words) > 1:
            current = block.whole(1)
        elif block.name == "ET" and len(block.words) > 2:
            model.types[block.whole(1)] = _type_number(block)
        elif block.name == "/UNITS" and len(block.words) > 1:
            model.units = block.words[1].upper()
        elif block.name == "ETBLOCK":
            model.types.update((row[0], row[1]) for row in block.integers(2))
        elif block.name == "NBLOCK":
            _take_nodes(model, block)
        elif block.name == "EBLOCK":
            _take_elements(model, block, current)
        elif block.name == "CMBLOCK":
            _take_component(model, block)
        assert_plane(block, model.types)
    if not model.elements:
        raise MeshError(
            f"mesh file {path}: holds no EBLOCK with solid elements of Ansys", code=Code.MESH_FILE
        )
    return _foreign(path, model)


def _type_number(block: Block) -> int:
    """Number of the element type of ET, which may be written as SOLID186."""
    found = re.search(r"(\d+)$", block.words[2])
    return int(found[1]) if found else 0


def _take_nodes(model: _Model, block: Block) -> None:
    for number, x in block.nodes():
        if model.nodes.setdefault(number, x) != x:
            raise MeshError(f"{block.place}: node {number} stands twice, at different places")


def _take_elements(model: _Model, block: Block, current: int) -> None:
    """Rows of 11 numbers before the nodes, 19 with the first 8 of these, or 5 without SOLID."""
    solid = len(block.words) > 2 and block.words[2].upper() == "SOLID"
    for row in block.elements(solid):
        if solid:
            number, kind, material, nodes = row[10], row[1], row[0], row[11:]
        else:
            number, kind, material, nodes = row[0], current or row[1], row[3], row[5:]
        if number in model.elements:
            raise MeshError(f"{block.place}: element {number} stands twice")
        named = _named(block, number, model.types.get(kind), nodes)
        if named == "":
            model.skins += 1
            continue
        width = int("".join(re.findall(r"\d", named)) or shape_of(named).corners)
        model.elements[number] = named, kind, material, nodes[:width]


def _named(block: Block, number: int, kind: int | None, nodes: list[int]) -> str:
    """Kind of an element, "" for what has no effect."""
    if kind is None:
        raise MeshError(f"{block.place}: element {number} is of a type without ET")
    known = _KINDS.get(kind)
    if known is not None and len(nodes) in known:
        if any(nodes[shape_of(known[len(nodes)]).corners :]) or len(nodes) in (3, 4):
            return known[len(nodes)]
        return known[len(nodes)].rstrip("0123456789")
    if kind in _SKINS:
        return ("triangle" if nodes[2] == nodes[3] else "quad") if len(nodes) >= 4 else ""
    what = _NAMES.get(kind, f"of the type {kind}")
    raise MeshError(
        f"{block.place}: element {number}, {what} with {len(nodes)} nodes, cannot be followed: "
        "must be SOLID185, 186, 187, 285, 45, 92, 95 or plane; parts must share their nodes"
    )


def _take_component(model: _Model, block: Block) -> None:
    kind = block.words[2].upper()[:4] if len(block.words) > 2 else ""
    members = expanded([value for row in block.integers() for value in row], block.place)
    model.components.append((block.words[1].strip(), kind, members, block.place))


def _foreign(path: Path, model: _Model) -> ForeignMesh:
    row = {number: index for index, number in enumerate(model.nodes)}
    points = list(model.nodes.values())
    cells: dict[str, list[list[int]]] = {}
    numbers: dict[str, list[int]] = {}
    middles = _middles(model, row)
    sets: dict[str, dict[str, list[int]]] = {}
    place: dict[int, tuple[str, int]] = {}
    for number, (kind, type_, material, nodes) in model.elements.items():
        missing = [node for node in nodes if node and node not in row]
        if missing or not all(nodes[: shape_of(kind).corners]):
            raise MeshError(
                f"mesh file {path}: element {number} has the node {(missing or [0])[0]}, which "
                "is not there",
                code=Code.MESH_FILE,
            )
        known = [row[node] if node else -1 for node in nodes]
        _fill_middles(kind, known, points, middles)
        rows = cells.setdefault(kind, [])
        for name in (f"TYPE {type_}", f"MAT {material}"):
            sets.setdefault(name, {}).setdefault(kind, []).append(len(rows))
        place[number] = kind, len(rows)
        numbers.setdefault(kind, []).append(number)
        rows.append(known)
    node_sets = {}
    for name, of, members, _ in model.components:
        if of == "NODE":
            found = [row[int(n)] for n in members if int(n) in row]
            node_sets[name] = np.array(found, dtype=np.int64)
        for kind, index in (place[int(n)] for n in members if of == "ELEM" and int(n) in place):
            sets.setdefault(name, {}).setdefault(kind, []).append(index)
    added = len(points) - len(model.nodes)
    notes = [f"{added} middle nodes that the file leaves out lie half way"] if added else []
    if model.skins:
        notes.append(f"{model.skins} surface elements are left out")
    if model.units in _LENGTHS:
        notes.append(f'/UNITS,{model.units}: says that lengths are in "{_LENGTHS[model.units]}"')
    return ForeignMesh(
        np.array(points, dtype=float),
        {kind: np.array(rows) for kind, rows in cells.items()},
        {name: {k: np.unique(found) for k, found in kinds.items()} for name, kinds in sets.items()},
        node_sets,
        numbers={kind: np.array(found) for kind, found in numbers.items()},
        notes=(*notes, "not read: materials, boundary conditions, loads and solution commands"),
    )


def _middles(model: _Model, row: dict[int, int]) -> dict[tuple[int, int], int]:
    """Middle nodes that some element has, by the ends of their edges."""
    found: dict[tuple[int, int], int] = {}
    for kind, _, _, nodes in model.elements.values():
        shape = shape_of(kind)
        for (a, b), node in zip(shape.edges, nodes[shape.corners :], strict=False):
            if node in row and nodes[a] in row and nodes[b] in row:
                ends = row[nodes[a]], row[nodes[b]]
                found[min(ends), max(ends)] = row[node]
    return found


def _fill_middles(
    kind: str, nodes: list[int], points: list[list[float]], between: dict[tuple[int, int], int]
) -> None:
    """Put middle nodes that are left out half way between the ends of their edges."""
    shape = shape_of(kind)
    for place, (a, b) in enumerate(shape.edges, start=shape.corners):
        if place < len(nodes) and nodes[place] < 0:
            ends = min(nodes[a], nodes[b]), max(nodes[a], nodes[b])
            if ends[0] == ends[1]:
                nodes[place] = ends[0]
                continue
            if ends not in between:
                between[ends] = len(points)
                half = zip(points[ends[0]], points[ends[1]], strict=True)
                points.append([(x + y) / 2 for x, y in half])
            nodes[place] = between[ends]
