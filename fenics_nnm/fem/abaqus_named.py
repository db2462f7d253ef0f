"""Nodes, elements and surfaces that keywords of Abaqus and CalculiX name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.abaqus_cards import Card, whole_number
from fenics_nnm.fem.abaqus_sets import Label, Model, labels_of, sides_of
from fenics_nnm.fem.cell_shapes import FacetTable
from fenics_nnm.fem.constraint_builder import ConstraintBuilder


@dataclass(frozen=True, slots=True)
class Owner:
    """Whose numbers are meant.

    Attributes:
        instance: Owner of numbers without one, "" for none.
        prefix: What names of its sets begin with.
    """

    instance: str
    prefix: str


@dataclass(frozen=True, slots=True)
class Named:
    """What keywords name in a model.

    Attributes:
        model: Model whose sets are named.
        builder: Takes constraints between its nodes.
        facets: Facets of its body.
    """

    model: Model
    builder: ConstraintBuilder[Label]
    facets: FacetTable

    def labels(self, card: Card, name: str, owner: Owner) -> list[Label]:
        """Nodes by a number or the name of a set.

        Raises:
            MeshError: if there is no such set, or a node is not in the file.
        """
        found = labels_of(self.model, card, name, owner.instance, owner.prefix)
        for label in found:
            self.builder.where(label, card.place)
        return found

    def elements(self, card: Card, owner: Owner) -> list[Label]:
        """Elements of the ELSET of a keyword.

        Raises:
            MeshError: if it names none, or one that is not in the file.
        """
        name = card.option("ELSET")
        return labels_of(self.model, card, name, owner.instance, owner.prefix, elements=True)

    def reference(self, card: Card, owner: Owner) -> Label:
        """The REF NODE of a keyword.

        Raises:
            MeshError: if it is not one node.
        """
        found = self.labels(card, card.option("REF NODE"), owner)
        if len(set(found)) != 1:
            raise MeshError(f"{card.place}: *{card.keyword}: REF NODE must be one node")
        return found[0]

    def surface(self, card: Card, owner: Owner) -> list[Label]:
        """All nodes of the SURFACE of a keyword, middle nodes included.

        Raises:
            MeshError: if there is no such surface.
        """
        sides = sides_of(self.model, card, card.option("SURFACE"), owner.prefix)
        rows = [[self.builder.rows[label] for label in side] for side in sides]
        width = self.facets.corners.shape[1]
        whole = [row for row in rows if len(row) > 1]
        padded = np.array([[*row, *[-1] * width][:width] for row in whole], dtype=np.int64)
        found = self.facets.find(padded.reshape(-1, width))
        found = found[found >= 0]
        nodes = np.unique([self.facets.corners[found], self.facets.middles[found]])
        single = [row[0] for row in rows if len(row) == 1]
        labels = list(self.model.nodes)
        return [labels[row] for row in (*nodes[nodes >= 0].tolist(), *single)]


def axis_of(entry: str, card: Card) -> int:
    """Axis from 0 of a direction from 1.

    Raises:
        MeshError: if it is none of 1 to 6.
    """
    number = whole_number(entry, card)
    if number not in range(1, 7):
        raise MeshError(f"{card.place}: direction {number}: must be one of 1 to 6")
    return number - 1


def nowhere(label: Label, key: str) -> Array:
    """For nodes that a file does not have."""
    raise MeshError(f"{key}: there is no node {label[1]}")
