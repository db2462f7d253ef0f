"""Keywords of Abaqus and CalculiX that join nodes: those that can be followed, and where not.

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
from fenics_nnm.fem.cell_shapes import FacetTable, facet_table
from fenics_nnm.fem.foreign_mesh import KINDS, ForeignMesh

#: Distance over the size of the facets within which two nodes lie at one place.
_SAME_PLACE = 1e-4


@dataclass(slots=True)
class Constraints:
    """What joins nodes in a file.

    Attributes:
        ties: *TIE cards.
        equations: First *EQUATION that stands, if any.
        coupling: *COUPLING whose kind is not known yet.
        references: Reference nodes of couplings that distribute, with their places in the file.
        notes: What has no effect and is left out.
    """

    ties: list[Card] = field(default_factory=list)
    equations: list[Card] = field(default_factory=list)
    coupling: Card | None = None
    references: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def take(self, card: Card) -> bool:
        """Take a keyword that joins nodes; whether it is one.

        Raises:
            MeshError: if it cannot be followed.
        """
        if card.keyword == "TIE":
            self._take_tie(card)
        elif card.keyword == "EQUATION":
            self._take_equation(card)
        elif card.keyword == "COUPLING":
            self.assert_none()
            self.coupling = card
        elif card.keyword == "DISTRIBUTING" and self.coupling is not None:
            self._distribute(self.coupling)
        elif card.keyword == "KINEMATIC" and self.coupling is not None:
            self.assert_none()
        else:
            return False
        return True

    def assert_none(self) -> None:
        """Refuse what cannot be followed.

        Raises:
            MeshError: if equations stand, or a coupling that makes a surface rigid.
        """
        if self.equations:
            raise MeshError(
                f"{self.equations[0].place}: *EQUATION cannot be followed: it joins nodes"
            )
        if self.coupling is not None:
            raise MeshError(
                f"{self.coupling.place}: *COUPLING with *KINEMATIC cannot be followed: it makes a "
                "surface rigid"
            )

    def _take_tie(self, card: Card) -> None:
        if "CYCLIC SYMMETRY" in card.options or "MULTISTAGE" in card.options:
            raise MeshError(
                f"{card.place}: *TIE of cyclic symmetry cannot be followed: it joins the two sides "
                "of a sector"
            )
        self.ties.append(card)

    def _take_equation(self, card: Card) -> None:
        removes_all = "REMOVEALL" in {name.replace(" ", "") for name in card.options} or (
            card.options.get("REMOVE", "").upper() == "ALL"
        )
        if removes_all:
            self.equations.clear()
        elif "REMOVE" not in card.options:
            self.equations.append(card)
        else:
            self.assert_none()  # some of the equations may stay

    def _distribute(self, card: Card) -> None:
        node = card.option("REF NODE").upper()
        if node in self.references:
            raise MeshError(
                f"{card.place}: *COUPLING cannot be followed: its reference node {node} is that of "
                f"{self.references[node]} too, which joins the two surfaces"
            )
        self.references[node] = card.place
        self.coupling = None
        self.notes.append(
            f"not read: *COUPLING with *DISTRIBUTING of node {node}, which spreads loads alone"
        )


def tied(foreign: ForeignMesh, ties: list[Card]) -> ForeignMesh:
    """A mesh whose tied surfaces have their nodes in common.

    Raises:
        MeshError: if a surface is not known, or its nodes do not lie at those of the other one.
    """
    for card in ties:
        for row in card.rows:
            foreign = _merged(foreign, card, row[0], row[1] if len(row) > 1 else "")
    return foreign


def _merged(foreign: ForeignMesh, card: Card, slave: str, master: str) -> ForeignMesh:
    cells = _body(foreign)
    table = facet_table(cells)
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
    return replace(
        foreign,
        cells={kind: row[nodes] for kind, nodes in foreign.cells.items()},
        node_sets={name: np.unique(row[nodes]) for name, nodes in foreign.node_sets.items()},
        facets={
            name: np.where(corners >= 0, row[corners], -1)
            for name, corners in foreign.facets.items()
        },
        notes=(*foreign.notes, f"*TIE of {slave} and {master}: {len(own)} nodes are merged"),
    )


def _body(foreign: ForeignMesh) -> dict[str, Indices]:
    dim = max(KINDS[kind][0] for kind in foreign.cells)
    return {kind: rows for kind, rows in foreign.cells.items() if KINDS[kind][0] == dim}


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
