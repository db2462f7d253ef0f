"""Motion between two changes of contact with second-order kinematics: smooth, not linear.

With A the points in contact, lambda_A = R_AA^-1 (p_A - gap_A) whatever its sign, so that the
equations of motion are smooth, also a little beyond the end of the stage. What they differ by from
those of linear kinematics, K_A of `linear_stage`, is the remainder:

    q'' = -K_A (q - rest) + n(q, q').
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.time_domain.linear_stage import LinearStage


@dataclass(frozen=True, slots=True)
class SmoothStage:
    """Equations of motion while the points in contact stay the same.

    Attributes:
        mechanics: What a motion obeys.
        linear: The stage with linear kinematics.
        give: Contact forces by p - gap, zero rows for open points, shape (n_c, n_c).
        margin: Margins by p - gap, see `mechanics.closed`, shape (n_c, n_c).
    """

    mechanics: Mechanics
    linear: LinearStage
    give: Array
    margin: Array

    @classmethod
    def of(cls, mechanics: Mechanics, active: Mask) -> SmoothStage:
        """The stage with the given points in contact, shape (n_c,)."""
        model = mechanics.model
        give = np.zeros((model.points, model.points))
        margin = -np.eye(model.points)
        if active.any():
            both = np.ix_(active, active)
            inverse = np.linalg.inv(model.R[both])
            give[both] = (inverse + inverse.T) / 2
            margin += model.R @ give
            margin[active] = give[active] / np.diagonal(inverse)[:, None]
        return cls(mechanics, LinearStage.of(model, active), give, margin)

    @property
    def active(self) -> Mask:
        """Which points are in contact, shape (n_c,)."""
        return self.linear.active

    def excess(self, q: Array) -> Array:
        """P - gap at states of shape (s, J), shape (s, n_c)."""
        model = self.mechanics.model
        basis = np.eye(len(q))
        return model.kinematics.closing.displaced(q @ model.Phi.T, basis, q) - model.gap

    def margins(self, q: Array) -> Array:
        """Margins in m at states of shape (s, J), shape (s, n_c)."""
        return np.asarray(self.excess(q) @ self.margin.T)

    def margins_and_rates(self, q: Array, velocity: Array) -> tuple[Array, Array]:
        """Margins and their rates at states of shape (s, J), each of shape (s, n_c)."""
        model = self.mechanics.model
        shapes = model.kinematics.closing.shapes_at(model.Phi, q)
        rates = (shapes @ velocity[:, :, None])[:, :, 0]
        return self.margins(q), np.asarray(rates @ self.margin.T)

    def acceleration(self, q: Array, velocity: Array) -> Array:
        """Q'' of states of shape (s, J)."""
        model, kinematics = self.mechanics.model, self.mechanics.model.kinematics
        pull = model.omega**2 * q + sum(f.at(q, velocity) for f in self.mechanics.forces)
        if self.linear.contact:
            shapes = kinematics.closing.shapes_at(model.Phi, q)
            force = self.excess(q) @ self.give
            pull = pull + (force[:, None, :] @ shapes)[:, 0]
        return kinematics.inertia.accelerated(q, -pull[:, :, None])[:, :, 0]

    def remainder(self, q: Array, velocity: Array) -> Array:
        """N at states of shape (s, J)."""
        stage = self.linear
        linear = ((q - stage.rest) @ stage.V * stage.nu**2) @ stage.V.T
        return self.acceleration(q, velocity) + linear

    def tangents(self, q: Array, velocity: Array) -> tuple[Array, Array]:
        """Derivatives of n by q and q' at states of shape (s, J), each of shape (s, J, J)."""
        model, kinematics, stage = (
            self.mechanics.model,
            self.mechanics.model.kinematics,
            self.linear,
        )
        acceleration = self.acceleration(q, velocity)
        by_q = np.tile(np.diag(model.omega**2), (len(q), 1, 1))
        by_velocity = np.zeros_like(by_q)
        if stage.contact:
            shapes = kinematics.closing.shapes_at(model.Phi, q)
            by_q += shapes.swapaxes(1, 2) @ self.give @ shapes
            by_q = kinematics.closing.stiffened(by_q, self.excess(q) @ self.give)
        for force in self.mechanics.forces:
            one, other = force.tangent_at(q, velocity, acceleration)
            by_q, by_velocity = by_q + one, by_velocity + other
        linear = (stage.V * stage.nu**2) @ stage.V.T
        inertia = kinematics.inertia
        return inertia.accelerated(q, -by_q) + linear, inertia.accelerated(q, -by_velocity)
