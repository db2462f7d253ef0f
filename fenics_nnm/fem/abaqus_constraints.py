"""Keywords of Abaqus and CalculiX that join nodes: collected, and ties followed.

Ties of surfaces whose nodes lie at the same places merge these nodes, which is exact. Couplings
that distribute loads leave the structure as it is. Equations that are removed again are none.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import KDTree

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.abaqus_cards import Card
from fenics_nnm.fem.abaqus_carriers import CARRIERS
from fenics_nnm.fem.abaqus_joints import JOINTS, KINDS_OF_COUPLING, Joint, joint_of
from fenics_nnm.fem.cell_shapes import FacetTable, facet_table
from fenics_nnm.fem.foreign_mesh import ForeignMesh, body_cells
from fenics_nnm.fem.merging import merged

#: Distance over the size of the facets within which two nodes lie at one place.
_SAME_PLACE = 1e-4


@dataclass(slots=True)
class Constraints:
    """What joins nodes in a file.

    Attributes:
        ties: *TIE cards.
        joints: Other keywords, each with the part that it stands in, "" outside of parts.
        coupling: *COUPLING whose kind is not known yet.
    """

    ties: list[Card] = field(default_factory=list)
    joints: list[tuple[Joint, str]] = field(default_factory=list)
    coupling: Card | None = None

    def take(self, card: Card, part: str) -> bool:
        """Take a keyword that joins nodes; whether it is one.

        Args:
            card: Keyword.
            part: Part that it stands in.

        Raises:
            MeshError: if it cannot be followed.
        """
        if card.keyword == "TIE":
            self._take_tie(card)
        elif card.keyword == "EQUATION" and _removes(card):
            self._remove_equations(card)
        elif card.keyword == "COUPLING":
            self.assert_whole()
            self.coupling = card
        elif card.keyword in KINDS_OF_COUPLING:
            self.joints.append((joint_of(card, self.coupling), part))
            self.coupling = None
        elif card.keyword in (*JOINTS, *CARRIERS):
            self.assert_whole()
            self.joints.append((Joint(card, card), part))
        else:
            return False
        return True

    def assert_whole(self) -> None:
        """Refuse a coupling without its kind.

        Raises:
            MeshError: if there is one.
        """
        if self.coupling is not None:
            raise MeshError(
                f"{self.coupling.place}: *COUPLING cannot be followed: must be followed by "
                "*KINEMATIC or *DISTRIBUTING"
            )

    def _take_tie(self, card: Card) -> None:
        if "CYCLIC SYMMETRY" in card.options or "MULTISTAGE" in card.options:
            raise MeshError(
                f"{card.place}: *TIE of cyclic symmetry cannot be followed: it joins the two sides "
                "of a sector"
            )
        self.ties.append(card)

    def _remove_equations(self, card: Card) -> None:
        equations = [each for each, _ in self.joints if each.card.keyword == "EQUATION"]
        if equations and not _removes_all(card):
            raise MeshError(
                f"{equations[0].card.place}: *EQUATION cannot be followed: it joins nodes, and "
                f"{card.place} removes some equations, not all"
            )
        self.joints = [each for each in self.joints if each[0].card.keyword != "EQUATION"]


def _removes(card: Card) -> bool:
    return _removes_all(card) or "REMOVE" in card.options


def _removes_all(card: Card) -> bool:
    return "REMOVEALL" in {name.replace(" ", "") for name in card.options} or (
        card.options.get("REMOVE", "").upper() == "ALL"
    )


def tied(foreign: ForeignMesh, ties: list[Card]) -> ForeignMesh:
    """A mesh whose tied surfaces have their nodes in common.

    Raises:
        MeshError: if a surface is not known, or its nodes do not lie at those of the other one.
    """
    for card in ties:
        for row in card.rows:
            foreign = _tied(foreign, card, row[0], row[1] if len(row) > 1 else "")
    return foreign


def _tied(foreign: ForeignMesh, card: Card, slave: str, master: str) -> ForeignMesh:
    table = facet_table(body_cells(foreign))
    own, other = (_nodes_of(foreign, card, name, table) for name in (slave, master))
    own = np.setdiff1d(own, other)
    if not len(own):
        return foreign
    size = float(np.ptp(foreign.points[own], axis=0).max())
    nearest = KDTree(foreign.points[other]).query(foreign.points[own])
    shortest = _shortest_edge(foreign, table, own)
    apart = np.asarray(nearest[0]) > _SAME_PLACE * (shortest or size)
    partner = other[np.asarray(nearest[1])]
    if apart.any() or len(np.unique(partner)) < len(partner):
        raise MeshError(
            f"{card.place}: *TIE of {slave} and {master} cannot be followed: {int(apart.sum())} of "
            f"{len(own)} nodes of {slave} have no node of {master} at their place: only nodes at "
            "the same places can be joined"
        )
    row = np.arange(len(foreign.points))
    row[own] = partner
    note = f"*TIE of {slave} and {master}: {len(own)} nodes are merged"
    return replace(merged(foreign, row), notes=(*foreign.notes, note))


def _nodes_of(foreign: ForeignMesh, card: Card, name: str, table: FacetTable) -> Indices:
    """All nodes of a surface, middle nodes included, or of a set of nodes."""
    names = {known.upper(): known for known in (*foreign.facets, *foreign.node_sets)}
    if name.upper() not in names:
        raise MeshError(f'{card.place}: there is no surface "{name}"')
    known = names[name.upper()]
    if known not in foreign.facets:
        return foreign.node_sets[known]
    rows = table.find(foreign.facets[known][:, : table.corners.shape[1]])
    nodes = np.unique([table.corners[rows[rows >= 0]], table.middles[rows[rows >= 0]]])
    return nodes[nodes >= 0]


def _shortest_edge(foreign: ForeignMesh, table: FacetTable, nodes: Indices) -> float:
    """Length of the shortest edge of the facets between some nodes, 0 without facets."""
    inside = np.isin(table.corners, nodes)
    both = inside & np.roll(inside, -1, axis=1)
    ends = foreign.points[table.corners], foreign.points[np.roll(table.corners, -1, axis=1)]
    lengths = np.linalg.norm(ends[0] - ends[1], axis=2)[both]
    return float(lengths[lengths > 0].min(initial=np.inf)) if (lengths > 0).any() else 0.0
