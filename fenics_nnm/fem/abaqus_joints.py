"""Keywords of Abaqus and CalculiX that join nodes, as linear constraints."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.abaqus_cards import Card, real_number, whole_number
from fenics_nnm.fem.abaqus_named import Named, Owner, axis_of
from fenics_nnm.fem.abaqus_sets import Label
from fenics_nnm.fem.constraint_builder import ALL, SHIFTS

#: Keywords that stand after *COUPLING, and others that are taken here.
KINDS_OF_COUPLING = ("KINEMATIC", "DISTRIBUTING")
JOINTS = ("KINEMATIC COUPLING", "RIGID BODY", "EQUATION", "MPC")

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


class Joiner:
    """Puts keywords into constraints, one after the other."""

    def __init__(self, named: Named) -> None:
        """Prepare for a model."""
        self._named = named
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
        }
        how[joint.card.keyword](joint, owner)

    def assert_spread(self) -> None:
        """Refuse couplings that distribute at nodes that something else uses.

        Raises:
            MeshError: if there is one.
        """
        for label, card in self._spread.items():
            if self._named.builder.uses(label) or self._named.builder.in_body(label):
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
        nodes = self._named.surface(head, owner)
        axes = _axes(joint.card, joint.card.rows)
        self._follow(
            head, "*COUPLING with *KINEMATIC", self._named.reference(head, owner), nodes, axes
        )

    def _distributing(self, joint: Joint, owner: Owner) -> None:
        head = joint.head
        label = self._named.reference(head, owner)
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
            nodes = self._named.labels(card, row[0], owner)
            axes = _axes(card, [row[1:]])
            self._follow(
                card, "*KINEMATIC COUPLING", self._named.reference(card, owner), nodes, axes
            )

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
                nodes += self._named.labels(card, card.options[option], owner)
        if card.options.get("ELSET"):
            elements = self._named.elements(card, owner)
            nodes += [node for each in elements for node in self._named.model.elements[each][1]]
        self._follow(card, "*RIGID BODY", self._named.reference(card, owner), nodes, ALL)

    def _follow(
        self, card: Card, what: str, reference: Label, nodes: list[Label], axes: tuple[int, ...]
    ) -> None:
        count = self._named.builder.rigid(f"{card.place}: {what}", reference, nodes, axes)
        self.notes.append(f"{what} of node {reference[1]}: {count} nodes follow it")

    def _equation(self, joint: Joint, owner: Owner) -> None:
        card, entries = joint.card, iter(joint.card.entries())
        key = f"{card.place}: *EQUATION"
        made = 0
        for first in entries:
            count = whole_number(first, card)
            terms = list(islice(zip(entries, entries, entries, strict=False), max(count, 0)))
            if len(terms) < count:
                raise MeshError(f"{key}: {count} terms: must be as many nodes and coefficients")
            members = [self._named.labels(card, name, owner) for name, _, _ in terms]
            if not terms or len({len(each) for each in members}) > 1:
                raise MeshError(f"{key} cannot be followed: its sets must have as many nodes each")
            axes = [axis_of(direction, card) for _, direction, _ in terms]
            values = [real_number(value, card) for _, _, value in terms]
            for labels in zip(*members, strict=True):
                self._named.builder.equation(key, zip(labels, axes, values, strict=True))
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
            members = [self._named.labels(card, entry, owner) for entry in row[1:] if entry]
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
            self._named.builder.rigid(key, other, [one], ALL)
        elif kind == "LINK":
            self._named.builder.link(key, one, other)
        else:
            self._named.builder.pin(key, one, other)
            if kind == "TIE" and not (
                self._named.builder.in_body(one) or self._named.builder.in_body(other)
            ):
                for axis in (3, 4, 5):
                    self._named.builder.equation(key, [(one, axis, 1.0), (other, axis, -1.0)])


def _axes(card: Card, rows: list[list[str]]) -> tuple[int, ...]:
    """Axes of lines of the first and last direction; all without lines."""
    given = [[entry for entry in row if entry] for row in rows]
    found: set[int] = set()
    for row in given:
        if row:
            first, last = (axis_of(entry, card) for entry in (row[0], row[-1]))
            found |= set(range(first, last + 1))
    return tuple(sorted(found)) if found else ALL


def joint_of(card: Card, head: Card | None) -> Joint:
    """*KINEMATIC or *DISTRIBUTING with the *COUPLING before it.

    Raises:
        MeshError: if there is none.
    """
    if head is None:
        raise MeshError(f"{card.place}: *{card.keyword}: must stand after *COUPLING")
    return Joint(card, head)
