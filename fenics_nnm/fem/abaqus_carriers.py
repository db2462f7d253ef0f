"""Masses, inertias and springs at single nodes of Abaqus and CalculiX."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.abaqus_cards import Card, real_number
from fenics_nnm.fem.abaqus_named import Named, Owner, axis_of
from fenics_nnm.fem.abaqus_sets import Label
from fenics_nnm.fem.constraint_builder import ALL
from fenics_nnm.fem.constraints import as_six, diagonal

#: Keywords that are taken here.
CARRIERS = ("MASS", "ROTARY INERTIA", "SPRING")


class Carriers:
    """Puts what nodes carry into constraints, one keyword after the other."""

    def __init__(self, named: Named) -> None:
        """Prepare for a model."""
        self._named = named
        self.notes: list[str] = []

    def take(self, card: Card, owner: Owner) -> None:
        """Take a keyword of `CARRIERS`.

        Raises:
            MeshError: if it cannot be followed.
        """
        how = {"MASS": self._mass, "ROTARY INERTIA": self._inertia, "SPRING": self._spring}
        how[card.keyword](card, owner)

    def _mass(self, card: Card, owner: Owner) -> None:
        (values,) = self._numbers(card, 1)
        if len(values) != 1:
            raise MeshError(f"{card.place}: *MASS: must have one number")
        mass = diagonal((values[0],) * 3 + (0.0,) * 3)
        for label in self._carriers(card, owner):
            self._named.builder.carry(f"{card.place}: *MASS", label, mass=mass)
            self.notes.append(f"*MASS: {values[0]:g} kg at node {label[1]}")

    def _inertia(self, card: Card, owner: Owner) -> None:
        (values,) = self._numbers(card, 1)
        xx, yy, zz, xy, xz, yz = [*values, *[0.0] * 6][:6]
        six = np.zeros((6, 6))
        six[3:, 3:] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
        for label in self._carriers(card, owner):
            self._named.builder.carry(f"{card.place}: *ROTARY INERTIA", label, mass=as_six(six))
            self.notes.append(f"*ROTARY INERTIA: {_listed(values)} kg m^2 at node {label[1]}")

    def _spring(self, card: Card, owner: Owner) -> None:
        if "NONLINEAR" in card.options or card.options.get("ORIENTATION"):
            raise MeshError(f"{card.place}: *SPRING cannot be followed: must be linear and global")
        (direction, *_), (stiffness, *_) = self._numbers(card, 2)
        axis = axis_of(f"{direction:g}", card)
        along = diagonal(tuple(stiffness if axis == i else 0.0 for i in ALL))
        for label in self._carriers(card, owner):
            self._named.builder.carry(f"{card.place}: *SPRING", label, stiffness=along)
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
        for label in self._named.elements(card, owner):
            kind, nodes = self._named.model.elements[label]
            if kind != "vertex":
                raise MeshError(
                    f"{card.place}: *{card.keyword}: element {label[1]} must be one of one node"
                )
            yield nodes[0]


def _listed(values: list[float]) -> str:
    """Numbers in words."""
    return ", ".join(f"{value:g}" for value in values)
