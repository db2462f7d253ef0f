"""Sets and surfaces of an Abaqus input file: names of nodes, elements and sides of elements."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from fenics_nnm.arrays import Array
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.abaqus_cards import Card, whole_number
from fenics_nnm.fem.foreign_mesh import KINDS

#: Corners of the sides S1, S2 ... of an element.
_SIDES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": (
        *((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)),
        *((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    ),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "pyramid": ((0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
}

#: Members of a line of GENERATE: a file with more nodes has no use.
_MOST_MEMBERS = 10_000_000

Label = tuple[str, int]
"""Instance, "" without one, and number of a node or element."""


@dataclass(slots=True)
class Model:
    """All instances together, and the sets of each kind by their names in capitals."""

    nodes: dict[Label, Array] = field(default_factory=dict)
    elements: dict[Label, tuple[str, list[Label]]] = field(default_factory=dict)
    node_sets: dict[str, list[Label]] = field(default_factory=dict)
    element_sets: dict[str, list[Label]] = field(default_factory=dict)
    surfaces: dict[str, list[list[Label]]] = field(default_factory=dict)
    written: dict[str, str] = field(default_factory=dict)


def name_set(model: Model, card: Card, instance: str, prefix: str) -> None:
    """Resolve a set or surface, which may name those before it.

    Args:
        model: Takes the set.
        card: *NSET, *ELSET or *SURFACE.
        instance: Owner of numbers without one.
        prefix: What its name begins with, "INSTANCE." of several ones.

    Raises:
        MeshError: if it names what is not in the file.
    """
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
        ranges = [[whole_number(entry, card) for entry in row if entry] for row in card.rows]
        if not all(len(row) in (2, 3) for row in ranges):
            raise MeshError(f"{card.place}: each line must be first, last, step")
        return [
            (instance, number)
            for first, last, *step in ranges
            for number in _range(card, first, last, *step)
        ]
    found: list[Label] = []
    for entry in card.entries():
        owner, _, last = entry.rpartition(".")
        if last.lstrip("+-").isdigit():
            found.append((owner or instance, int(last)))
        else:
            found += _known(sets, entry, prefix, card)
    return found


def _range(card: Card, first: int, last: int, step: int = 1) -> range:
    """Numbers of a line of GENERATE.

    Raises:
        MeshError: if there are none, or more than a file has.
    """
    if first > last or step < 1:
        raise MeshError(
            f"{card.place}: {first}, {last}, {step}: the first must not be above the last, and the "
            "step be 1 or more"
        )
    numbers = range(first, last + 1, step)
    if len(numbers) > _MOST_MEMBERS:
        raise MeshError(f"{card.place}: {len(numbers)} members: must be fewer")
    return numbers


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


def _sides(model: Model, card: Card, instance: str, prefix: str) -> list[list[Label]]:
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


def _free_sides(model: Model, members: list[Label]) -> list[list[Label]]:
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


def labels_of(
    model: Model, card: Card, name: str, instance: str, prefix: str, *, elements: bool = False
) -> list[Label]:
    """Nodes, or elements, that a keyword names: one by its number, or a set.

    Args:
        model: Model whose sets are named.
        card: Keyword, for messages.
        name: Number, perhaps after "INSTANCE.", or name of a set.
        instance: Owner of numbers without one.
        prefix: What names of sets of the same instance begin with.
        elements: Whether elements are meant.

    Raises:
        MeshError: if there is no such set.
    """
    alone = Card(card.keyword, {}, [[name.strip().strip('"')]], card.place)
    sets = model.element_sets if elements else model.node_sets
    found = _labels(alone, instance, prefix, sets)
    if elements:
        _check_known(found, model.elements, card)
    return found


def sides_of(model: Model, card: Card, name: str, prefix: str) -> list[list[Label]]:
    """Corners of the sides of a surface; of one made of nodes each is a side of its own.

    Raises:
        MeshError: if there is no such surface.
    """
    for key in (prefix + name, name, name.rpartition(".")[2]):
        known = key.strip('"').upper()
        if known in model.surfaces:
            return model.surfaces[known]
        if known in model.node_sets:
            return [[label] for label in model.node_sets[known]]
    raise MeshError(f'{card.place}: there is no surface "{name}"')
