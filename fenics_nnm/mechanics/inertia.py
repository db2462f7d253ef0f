"""Inertia of the modal coordinates: T = 1/2 q'^T M(q) q', as motion in time needs it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Indices


class Inertia(Protocol):
    """M(q) of the coordinates."""

    def accelerated(self, q: Array, pull: Array) -> Array:
        """M(q)^-1 times columns of forces, shape (.., J, c), at states of shape (.., J)."""

    def momentum(self, q: Array, velocity: Array) -> Array:
        """P = M(q) q' at states, shape (.., J)."""

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of 1/2 q'^T M(q) q' by q, shape (J,)."""

    def to_momenta(self, q: Array, velocity: Array, changes: Array) -> Array:
        """Changes (dq, dp) of changes (dq, dq') of a state, columns of shape (2 J, ..)."""

    def from_momenta(self, q: Array, velocity: Array, changes: Array) -> Array:
        """Changes (dq, dq') of changes (dq, dp) of a state, columns of shape (2 J, ..)."""


class ConstantInertia:
    """M = 1: modes are mass-normalised."""

    __slots__ = ()

    def accelerated(self, q: Array, pull: Array) -> Array:
        """The forces themselves."""
        return pull

    def momentum(self, q: Array, velocity: Array) -> Array:
        """The velocities themselves."""
        return velocity

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Nothing."""
        return np.zeros_like(q)

    def to_momenta(self, q: Array, velocity: Array, changes: Array) -> Array:
        """The changes themselves."""
        return changes

    def from_momenta(self, q: Array, velocity: Array, changes: Array) -> Array:
        """The changes themselves."""
        return changes


CONSTANT = ConstantInertia()


@dataclass(frozen=True, slots=True)
class QuadraticInertia:
    """M_ij = delta_ij + D_ikjl q_k q_l among some of the coordinates, see `second_order`.

    Attributes:
        masters: Places of these coordinates, shape (k,).
        D: Shape (k, k, k, k).
    """

    masters: Indices
    D: Array

    def accelerated(self, q: Array, pull: Array) -> Array:
        """M(q)^-1 times columns of forces, shape (.., J, c), at states of shape (.., J)."""
        found, own, mass = pull.copy(), self.masters, self._mass(q)
        one = len(own) == 1
        pulled = pull[..., own, :]
        found[..., own, :] = pulled / mass if one else np.linalg.solve(mass, pulled)
        return found

    def momentum(self, q: Array, velocity: Array) -> Array:
        """P = M(q) q' at states, shape (.., J)."""
        found, own = velocity.copy(), velocity[..., self.masters]
        found[..., self.masters] = (self._mass(q) @ own[..., None])[..., 0]
        return found

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of 1/2 q'^T M(q) q' by q: D_inkl q_l q_i' q_k', shape (J,)."""
        found, own = np.zeros_like(q), velocity[self.masters]
        moving = np.einsum("inkl,l,k->in", self.D, q[self.masters], own)
        found[self.masters] = own @ moving
        return found

    def to_momenta(self, q: Array, velocity: Array, changes: Array) -> Array:
        """Changes (dq, dp) of changes (dq, dq') of a state, columns of shape (2 J, ..)."""
        found, own = changes.copy(), len(q) + self.masters
        found[own] = self._mass(q) @ changes[own]
        found[own] += self._momentum_by_q(q, velocity) @ changes[self.masters]
        return found

    def from_momenta(self, q: Array, velocity: Array, changes: Array) -> Array:
        """Changes (dq, dq') of changes (dq, dp) of a state, columns of shape (2 J, ..)."""
        found, own = changes.copy(), len(q) + self.masters
        left = changes[own] - self._momentum_by_q(q, velocity) @ changes[self.masters]
        found[own] = np.linalg.solve(self._mass(q), left)
        return found

    def _mass(self, q: Array) -> Array:
        """Rows and columns of M(q) of the masters, shape (.., k, k)."""
        own = q[..., self.masters]
        added = np.einsum("ikjl,...k,...l->...ij", self.D, own, own)
        return np.asarray(np.eye(len(self.masters)) + added)

    def _momentum_by_q(self, q: Array, velocity: Array) -> Array:
        """D (M q')_i / d q_n = D_injl q_l q_j' + D_ikjn q_k q_j', shape (k, k)."""
        own, rate = q[self.masters], velocity[self.masters]
        first = np.einsum("injl,l,j->in", self.D, own, rate)
        return np.asarray(first + np.einsum("ikjn,k,j->in", self.D, own, rate))
