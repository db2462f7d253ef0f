"""Motions as sums of the shapes that a branch is made of.

With masters among the modes these are those of their second-order displacement too, with amounts
q_i q_j, or half of that where i = j.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.motion import force_rates_at
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.results.stored_branch import PlacedMotion, StoredBranch


@dataclass(frozen=True, slots=True)
class MotionShapes:
    """Modes of a branch, its residual shapes taken negative, and what bending or full order adds.

    A motion has an amount of each at any time, and its displacement is the sum.

    Attributes:
        branch: Branch.
        inertia: Positions of points that full order adds its harmonics to; those of one point
            after those of another.
    """

    branch: StoredBranch
    inertia: tuple[float, ...]

    def at(self, nodes: Indices | slice) -> Array:
        """Displacement of each shape at some nodes, shape (shapes, nodes, dim)."""
        found = np.concatenate([part[:, nodes] for part in self._parts])
        residual = slice(len(self.branch.shapes), self.of_pairs.start)
        np.negative(found[residual], out=found[residual])
        return found

    @property
    def _parts(self) -> list[Array]:
        """Displacements of the shapes at all nodes, those of contact forces not yet negative."""
        branch = self.branch
        parts = [branch.shapes, branch.residual_shapes]
        parts += [branch.bent_shapes] if self._masters.size else []
        return parts + [branch.inertia[place] for place in self.inertia]

    def amounts(self, point: PlacedMotion, phase: Array) -> Array:
        """Amounts of the shapes in a motion at phases omega t, shape (len(phase), shapes)."""
        branch, basis = self.branch, self.branch.series.basis_at(phase)
        q, forces = basis @ point.motion.q, branch.forces(point, phase)
        return np.hstack([q, forces, self._products(q, q), *self._own(point, basis)])

    def rates(self, point: PlacedMotion, phase: Array) -> Array:
        """Their derivatives by time in 1/s."""
        branch, rates = self.branch, self.branch.series.rate_at(phase)
        forces = force_rates_at(branch.header.model, branch.series, point.motion, phase)
        q, moving = branch.series.basis_at(phase) @ point.motion.q, rates @ point.motion.q
        bending = 2 * self._products(q, moving)
        by_phase = np.hstack([moving, forces, bending, *self._own(point, rates)])
        return 2 * np.pi * point.motion.frequency * by_phase

    def of(self, q: Array, force: Array) -> Array:
        """Amounts in modal coordinates (J,) and contact forces in N (n_c,), shape (shapes,).

        They are those of linear kinematics.
        """
        rest = sum(len(self.branch.inertia[place]) for place in self.inertia)
        return np.concatenate([q, force, np.zeros(len(self.pairs.first) + rest)])

    def bent(self, q: Array, force: Array) -> Array:
        """The same with second-order displacement, where there is some."""
        found = self.of(q, force)
        found[self.of_pairs] = self._products(q[None], q[None])[0]
        return found

    @property
    def count(self) -> int:
        """Number of shapes."""
        return sum(map(len, self._parts))

    @property
    def pairs(self) -> Pairs:
        """Pairs of masters that have a shape of second-order displacement."""
        return Pairs.of(len(self._masters))

    @property
    def of_pairs(self) -> slice:
        """Places of these shapes."""
        start = len(self.branch.shapes) + len(self.branch.residual_shapes)
        return slice(start, start + len(self.pairs.first))

    @property
    def masters_of_pairs(self) -> tuple[Indices, Indices]:
        """Modes whose shapes make each of them."""
        return self._masters[self.pairs.first], self._masters[self.pairs.second]

    @property
    def _masters(self) -> Indices:
        return self.branch.header.model.kinematics.masters

    def _products(self, one: Array, other: Array) -> Array:
        """Amounts of second-order displacement of coordinates (k, J), shape (k, pairs)."""
        return self.pairs.products(one[:, self._masters], other[:, self._masters])

    def fields(self, amounts: Array) -> Array:
        """Sums of the shapes at all nodes, (k, n, dim), for amounts (k, shapes)."""
        found = np.zeros((len(amounts), *self.branch.shapes.shape[1:]))
        signed = amounts.copy()
        signed[:, len(self.branch.shapes) : self.of_pairs.start] *= -1
        start = 0
        for part in self._parts:
            own = signed[:, start : start + len(part)]
            if own.any():
                found += np.tensordot(own, part, 1)
            start += len(part)
        return found

    def _own(self, point: PlacedMotion, harmonics: Array) -> list[Array]:
        """Amounts of what full order adds: to the points that it belongs to."""
        none = np.zeros_like(harmonics)
        return [harmonics if place == point.position else none for place in self.inertia]


def motion_shapes(branch: StoredBranch, points: Sequence[PlacedMotion]) -> MotionShapes:
    """The shapes that some points of a branch are made of."""
    return MotionShapes(branch, tuple(p.position for p in points if p.position in branch.inertia))
