"""Keywords of Abaqus and CalculiX that join nodes, as linear constraints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.abaqus_cards import Card, real_number, whole_number
from fenics_nnm.fem.abaqus_sets import Label, Model, labels_of, sides_of
from fenics_nnm.fem.cell_shapes import FacetTable
from fenics_nnm.fem.constraint_builder import ALL, SHIFTS, ConstraintBuilder
from fenics_nnm.fem.constraints import as_six, diagonal

#: Keywords that stand after *COUPLING, and others that are taken here.
KINDS_OF_COUPLING = ("KINEMATIC", "DISTRIBUTING")
JOINTS = (
    *("KINEMATIC COUPLING", "RIGID BODY", "EQUATION", "MPC"),
    *("MASS", "ROTARY INERTIA", "SPRING"),
)

#: Types of *MPC that are followed.
_MPC = ("BEAM", "PIN", "TIE", "LINK")


@dataclass(frozen=True, slots=True)
class Joint:
    """A keyword that joins nodes.

    Attributes:
        card: Keyword.
        head: The *COUPLING that stands before *KINEMATIC or *DISTRIBUTING; else the same card.
    """

    card: Card
    head: Card

    @property
    def turned(self) -> bool:
        """Whether directions other than all matter."""
        if self.card.keyword == "KINEMATIC":
            return not set(SHIFTS) <= set(_axes(self.card, self.card.rows))
        return self.card.keyword in ("EQUATION", "KINEMATIC COUPLING", "SPRING")


@dataclass(frozen=True, slots=True)
class Owner:
    """Whose numbers are meant.

    Attributes:
        instance: Owner of numbers without one, "" for none.
        prefix: What names of its sets begin with.
    """

    instance: str
    prefix: str


class Joiner:
    """Puts keywords into constraints, one after the other."""

    def __init__(self, model: Model, builder: ConstraintBuilder[Label], facets: FacetTable) -> None:
        """Prepare for a model whose sets are named, with the facets of its body."""
        self._model, self._builder, self._facets = model, builder, facets
        self._labels_by_row = list(model.nodes)
        self._spread: dict[Label, Card] = {}
        self.notes: list[str] = []

    def take(self, joint: Joint, owner: Owner) -> None:
        """Take a keyword.

        Raises:
            MeshError: if it cannot be followed.
        """
        how = {
            "KINEMATIC": self._kinematic,
            "DISTRIBUTING": self._distributing,
            "KINEMATIC COUPLING": self._old_coupling,
            "RIGID BODY": self._rigid_body,
            "EQUATION": self._equation,
            "MPC": self._mpc,
            "MASS": self._mass,
            "ROTARY INERTIA": self._inertia,
            "SPRING": self._spring,
        }
        how[joint.card.keyword](joint, owner)

    def assert_spread(self) -> None:
        """Refuse couplings that distribute at nodes that something else uses.

        Raises:
            MeshError: if there is one.
        """
        for label, card in self._spread.items():
            if self._builder.uses(label) or self._builder.in_body(label):
                raise MeshError(
                    f"{card.place}: *COUPLING with *DISTRIBUTING cannot be followed: its reference "
                    f"node {label[1]} is a node of the body, has mass or springs or is joined with "
                    "others, and the weights of its nodes are not known"
                )

    def _kinematic(self, joint: Joint, owner: Owner) -> None:
        head = joint.head
        if head.options.get("ORIENTATION") and joint.turned:
            raise MeshError(
                f"{head.place}: *COUPLING with ORIENTATION cannot be followed: must have "
                "directions 1 to 3, or none"
            )
        nodes = self._surface(head, owner)
        axes = _axes(joint.card, joint.card.rows)
        self._follow(head, "*COUPLING with *KINEMATIC", self._reference(head, owner), nodes, axes)

    def _distributing(self, joint: Joint, owner: Owner) -> None:
        head = joint.head
        label = self._reference(head, owner)
        if label in self._spread:
            raise MeshError(
                f"{head.place}: *COUPLING cannot be followed: its reference node {label[1]} is "
                f"that of {self._spread[label].place} too, which joins the two surfaces"
            )
        self._spread[label] = head
        self.notes.append(
            f"not read: *COUPLING with *DISTRIBUTING of node {label[1]}, which spreads loads alone"
        )

    def _old_coupling(self, joint: Joint, owner: Owner) -> None:
        card = joint.card
        for row in card.rows:
            nodes = self._labels(card, row[0], owner)
            axes = _axes(card, [row[1:]])
            self._follow(card, "*KINEMATIC COUPLING", self._reference(card, owner), nodes, axes)

    def _rigid_body(self, joint: Joint, owner: Owner) -> None:
        card = joint.card
        beyond = {"ANALYTICAL SURFACE", "ISOTHERMAL"} & {*card.options}
        if beyond:
            raise MeshError(
                f"{card.place}: *RIGID BODY with {beyond.pop()} cannot be followed: it is contact "
                "or heat"
            )
        nodes: list[Label] = []
        for option in ("NSET", "TIE NSET", "PIN NSET"):
            if card.options.get(option):
                nodes += self._labels(card, card.options[option], owner)
        if card.options.get("ELSET"):
            elements = self._elements(card, owner)
            nodes += [node for each in elements for node in self._model.elements[each][1]]
        self._follow(card, "*RIGID BODY", self._reference(card, owner), nodes, ALL)

    def _follow(
        self, card: Card, what: str, reference: Label, nodes: list[Label], axes: tuple[int, ...]
    ) -> None:
        count = self._builder.rigid(f"{card.place}: {what}", reference, nodes, axes)
        self.notes.append(f"{what} of node {reference[1]}: {count} nodes follow it")

    def _equation(self, joint: Joint, owner: Owner) -> None:
        card, entries = joint.card, iter(joint.card.entries())
        key = f"{card.place}: *EQUATION"
        made = 0
        for first in entries:
            terms = [
                (next(entries, ""), next(entries, ""), next(entries, ""))
                for _ in range(whole_number(first, card))
            ]
            members = [self._labels(card, name, owner) for name, _, _ in terms]
            if not terms or len({len(each) for each in members}) > 1:
                raise MeshError(f"{key} cannot be followed: its sets must have as many nodes each")
            axes = [_axis(direction, card) for _, direction, _ in terms]
            values = [real_number(value, card) for _, _, value in terms]
            for labels in zip(*members, strict=True):
                self._builder.equation(key, zip(labels, axes, values, strict=True))
                made += 1
        self.notes.append(f"*EQUATION: {made} equations between displacements")

    def _mpc(self, joint: Joint, owner: Owner) -> None:
        card = joint.card
        for row in card.rows:
            kind = row[0].upper()
            if kind not in _MPC:
                raise MeshError(
                    f"{card.place}: *MPC {kind} cannot be followed: must be one of "
                    f"{', '.join(_MPC)}"
                )
            members = [self._labels(card, entry, owner) for entry in row[1:] if entry]
            if len(members) != 2 or len(members[1]) not in (1, len(members[0])):
                raise MeshError(f"{card.place}: *MPC {kind}: must have two nodes or sets of nodes")
            first, second = members
            if len(second) < len(first):
                second = second * len(first)
            for one, other in zip(first, second, strict=True):
                self._pair(f"{card.place}: *MPC {kind}", kind, one, other)
            self.notes.append(f"*MPC {kind}: {len(first)} pairs of nodes")

    def _pair(self, key: str, kind: str, one: Label, other: Label) -> None:
        if kind == "BEAM":
            self._builder.rigid(key, other, [one], ALL)
        elif kind == "LINK":
            self._builder.link(key, one, other)
        else:
            self._builder.pin(key, one, other)
            if kind == "TIE" and not (self._builder.in_body(one) or self._builder.in_body(other)):
                for axis in (3, 4, 5):
                    self._builder.equation(key, [(one, axis, 1.0), (other, axis, -1.0)])

    def _mass(self, joint: Joint, owner: Owner) -> None:
        (values,) = self._numbers(joint.card, 1)
        if len(values) != 1:
            raise MeshError(f"{joint.card.place}: *MASS: must have one number")
        mass = diagonal((values[0],) * 3 + (0.0,) * 3)
        for label in self._carriers(joint.card, owner):
            self._builder.carry(f"{joint.card.place}: *MASS", label, mass=mass)
            self.notes.append(f"*MASS: {values[0]:g} kg at node {label[1]}")

    def _inertia(self, joint: Joint, owner: Owner) -> None:
        (values,) = self._numbers(joint.card, 1)
        xx, yy, zz, xy, xz, yz = [*values, *[0.0] * 6][:6]
        six = np.zeros((6, 6))
        six[3:, 3:] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
        for label in self._carriers(joint.card, owner):
            self._builder.carry(f"{joint.card.place}: *ROTARY INERTIA", label, mass=as_six(six))
            self.notes.append(f"*ROTARY INERTIA: {listed(values)} kg m^2 at node {label[1]}")

    def _spring(self, joint: Joint, owner: Owner) -> None:
        card = joint.card
        if "NONLINEAR" in card.options or card.options.get("ORIENTATION"):
            raise MeshError(f"{card.place}: *SPRING cannot be followed: must be linear and global")
        (direction, *_), (stiffness, *_) = self._numbers(card, 2)
        axis = _axis(f"{direction:g}", card)
        along = diagonal(tuple(stiffness if axis == i else 0.0 for i in ALL))
        for label in self._carriers(card, owner):
            self._builder.carry(f"{card.place}: *SPRING", label, stiffness=along)
            self.notes.append(f"*SPRING: {stiffness:g} N/m or N m at node {label[1]}")

    def _numbers(self, card: Card, lines: int) -> list[list[float]]:
        """Numbers of the first lines.

        Raises:
            MeshError: if there are fewer lines, or more.
        """
        if len(card.rows) != lines or not all(row[0] for row in card.rows):
            raise MeshError(f"{card.place}: *{card.keyword}: must have {lines} lines of numbers")
        return [[real_number(entry, card) for entry in row if entry] for row in card.rows]

    def _carriers(self, card: Card, owner: Owner) -> Iterator[Label]:
        """Nodes of the elements of one node that a keyword is about."""
        for label in self._elements(card, owner):
            yield self._model.elements[label][1][0]

    def _elements(self, card: Card, owner: Owner) -> list[Label]:
        name = card.option("ELSET")
        return labels_of(self._model, card, name, owner.instance, owner.prefix, elements=True)

    def _labels(self, card: Card, name: str, owner: Owner) -> list[Label]:
        found = labels_of(self._model, card, name, owner.instance, owner.prefix)
        for label in found:
            self._builder.where(label, card.place)
        return found

    def _reference(self, card: Card, owner: Owner) -> Label:
        found = self._labels(card, card.option("REF NODE"), owner)
        if len(set(found)) != 1:
            raise MeshError(f"{card.place}: *{card.keyword}: REF NODE must be one node")
        return found[0]

    def _surface(self, card: Card, owner: Owner) -> list[Label]:
        """All nodes of a surface, middle nodes included."""
        sides = sides_of(self._model, card, card.option("SURFACE"), owner.prefix)
        rows = [[self._builder.rows[label] for label in side] for side in sides]
        width = self._facets.corners.shape[1]
        whole = [row for row in rows if len(row) > 1]
        padded = np.array([[*row, *[-1] * width][:width] for row in whole], dtype=np.int64)
        found = self._facets.find(padded.reshape(-1, width))
        found = found[found >= 0]
        nodes = np.unique([self._facets.corners[found], self._facets.middles[found]])
        single = [row[0] for row in rows if len(row) == 1]
        return [self._labels_by_row[row] for row in (*nodes[nodes >= 0].tolist(), *single)]


def _axes(card: Card, rows: list[list[str]]) -> tuple[int, ...]:
    """Axes of lines of the first and last direction; all without lines."""
    given = [[entry for entry in row if entry] for row in rows]
    found: set[int] = set()
    for row in given:
        if row:
            first, last = (_axis(entry, card) for entry in (row[0], row[-1]))
            found |= set(range(first, last + 1))
    return tuple(sorted(found)) if found else ALL


def _axis(entry: str, card: Card) -> int:
    """Axis from 0 of a direction from 1."""
    number = whole_number(entry, card)
    if number not in range(1, 7):
        raise MeshError(f"{card.place}: direction {number}: must be one of 1 to 6")
    return number - 1


def listed(values: list[float]) -> str:
    """Numbers in words."""
    return ", ".join(f"{value:g}" for value in values)


def joint_of(card: Card, head: Card | None) -> Joint:
    """*KINEMATIC or *DISTRIBUTING with the *COUPLING before it.

    Raises:
        MeshError: if there is none.
    """
    if head is None:
        raise MeshError(f"{card.place}: *{card.keyword}: must stand after *COUPLING")
    return Joint(card, head)


def nowhere(label: Label, key: str) -> Array:
    """For nodes that a file does not have."""
    raise MeshError(f"{key}: there is no node {label[1]}")
