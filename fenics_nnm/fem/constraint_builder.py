"""Constraints collected from the cards of a mesh file, by the labels of its nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

import numpy as np

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.constraints import (
    NOTHING,
    Coupling,
    Equation,
    LinearConstraints,
    Reference,
    Six,
)

Label = TypeVar("Label")

#: Part of the largest below which a negative mass or stiffness is round-off.
_ROUND_OFF = 1e-12

#: Axes of displacement, and all axes.
SHIFTS, ALL = (0, 1, 2), (0, 1, 2, 3, 4, 5)


@dataclass(slots=True)
class ConstraintBuilder(Generic[Label]):
    """Takes one constraint after the other.

    Attributes:
        rows: Row of the points of each node of the file that has one.
        points: Coordinates of these points, shape (nodes, 3).
        body: Which points cells of the body have.
        names: From a label to its words, and to names of sets that it belongs to.
        place: Coordinates of nodes without a row.
    """

    rows: Mapping[Label, int]
    points: Array
    body: Mask
    words: Callable[[Label], str]
    names: Callable[[Label], tuple[str, ...]]
    place: Callable[[Label, str], Array]
    _references: list[Reference] = field(default_factory=list)
    _known: dict[Label, int] = field(default_factory=dict)
    _rigid: dict[tuple[int, tuple[int, ...]], Coupling] = field(default_factory=dict)
    _means: list[Coupling] = field(default_factory=list)
    _equations: list[Equation] = field(default_factory=list)

    @property
    def found(self) -> LinearConstraints:
        """All that was taken."""
        return LinearConstraints(
            tuple(self._references),
            (*self._rigid.values(), *self._means),
            tuple(self._equations),
        )

    def in_body(self, label: Label) -> bool:
        """Whether cells of the body have a node."""
        return label in self.rows and bool(self.body[self.rows[label]])

    def reference(self, label: Label, key: str) -> int:
        """A node as a point with rotations.

        Args:
            label: The node.
            key: What names it, for messages.

        Raises:
            MeshError: if it has no coordinates.
        """
        if label not in self._known:
            self._known[label] = len(self._references)
            self._references.append(
                Reference(
                    f"{key}: {self.words(label)}",
                    tuple(float(x) for x in self.where(label, key)),
                    self.names(label),
                    node=self.rows[label] if self.in_body(label) else -1,
                )
            )
        return self._known[label]

    def uses(self, label: Label) -> bool:
        """Whether a node outside of the body is used."""
        return label in self._known

    def where(self, label: Label, key: str) -> Array:
        """Coordinates of a node.

        Raises:
            MeshError: if it has none.
        """
        return self.points[self.rows[label]] if label in self.rows else self.place(label, key)

    def rigid(
        self, key: str, reference: Label, members: Iterable[Label], axes: tuple[int, ...]
    ) -> int:
        """Nodes that follow another one as a rigid body; how many they are.

        All that follow one node along the same axes are one coupling, and that node is one of
        them, so that what lies between them follows, too.
        """
        given = [label for label in dict.fromkeys(members) if label != reference]
        nodes = [self.rows[label] for label in given if self.in_body(label)]
        others = [label for label in given if not self.in_body(label)]
        followers = [self.reference(label, key) for label in others]
        place = self.reference(reference, key)
        if self.in_body(reference):
            nodes.append(self.rows[reference])
        before = self._rigid.get((place, axes), Coupling(key, "rigid", place, axes))
        self._rigid[place, axes] = replace(
            before,
            nodes=tuple(dict.fromkeys([*before.nodes, *nodes])),
            followers=tuple(dict.fromkeys([*before.followers, *followers])),
        )
        return len(given)

    def mean(
        self,
        key: str,
        reference: Label,
        weights: Mapping[Label, tuple[float, ...]],
        axes: tuple[int, ...],
    ) -> None:
        """A node that follows the weighted mean motion of others.

        Raises:
            MeshError: if one of them is no node of the body.
        """
        for label in weights:
            if not self.in_body(label):
                raise MeshError(
                    f"{key} cannot be followed: {self.words(label)} is no node of the body"
                )
        nodes = tuple(self.rows[label] for label in weights)
        place = self.reference(reference, key)
        self._means.append(
            Coupling(key, "mean", place, axes, nodes, weights=tuple(weights.values()))
        )

    def equation(self, key: str, terms: Iterable[tuple[Label, int, float]]) -> None:
        """A sum of coefficients times displacements along axes that is zero."""
        found = tuple((self._term(label, key), axis, value) for label, axis, value in terms)
        if not any(value for _, _, value in found):
            raise MeshError(f"{key} cannot be followed: all its coefficients are zero")
        if not np.isfinite([value for _, _, value in found]).all():
            raise MeshError(f"{key} cannot be followed: its coefficients must be finite numbers")
        self._equations.append(Equation(key, found))

    def pin(self, key: str, first: Label, second: Label) -> None:
        """Two nodes with one displacement."""
        for axis in SHIFTS:
            self.equation(key, [(first, axis, 1.0), (second, axis, -1.0)])

    def link(self, key: str, first: Label, second: Label) -> None:
        """Two nodes whose distance does not change.

        Raises:
            MeshError: if they are at one place.
        """
        along = self.where(first, key) - self.where(second, key)
        if not np.linalg.norm(along) > 0:
            raise MeshError(f"{key} cannot be followed: its two nodes are at one place")
        along = along / np.linalg.norm(along)
        signs = ((first, 1.0), (second, -1.0))
        self.equation(
            key,
            [(node, i, sign * float(along[i])) for node, sign in signs for i in SHIFTS if along[i]],
        )

    def carry(
        self, key: str, label: Label, *, mass: Six | None = None, stiffness: Six | None = None
    ) -> None:
        """Mass, or springs to the ground, at a node.

        Raises:
            MeshError: if one is negative or no number.
        """
        for six in (mass, stiffness):
            _assert_positive(key, six or NOTHING)
        place = self.reference(label, key)
        found = self._references[place]
        if mass is not None:
            found = found.with_mass(mass)
        if stiffness is not None:
            found = found.with_stiffness(stiffness)
        self._references[place] = replace(found, key=f"{key}: {self.words(label)}")

    def _term(self, label: Label, key: str) -> int:
        return self.rows[label] if self.in_body(label) else -1 - self.reference(label, key)


def _assert_positive(key: str, six: Six) -> None:
    """Refuse what a body cannot have: mass, inertia or stiffness below zero."""
    matrix = np.array(six)
    if not np.isfinite(matrix).all():
        raise MeshError(f"{key}: must be finite numbers")
    strengths = np.linalg.eigvalsh(matrix)
    if strengths[0] < -_ROUND_OFF * np.abs(strengths).max():
        raise MeshError(f"{key}: must not be negative along any direction")
