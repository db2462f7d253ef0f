"""Motion between two changes of contact with second-order kinematics: smooth, not linear.

With A the points in contact, lambda_A = R_AA^-1 (p_A - gap_A) whatever its sign, so that the
equations of motion are smooth, also a little beyond the end of the stage. What they differ by from
those of linear kinematics, K_A of `linear_stage`, is the remainder, see `time_domain.remainder`:

    q'' = -K_A (q - rest) + n(q, q').
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.linear_stage import LinearStage
from fenics_nnm.time_domain.remainder import Remainder
from fenics_nnm.time_domain.stage_margins import StageMargins


@dataclass(frozen=True, slots=True)
class SmoothStage:
    """Equations of motion while the points in contact stay the same.

    Attributes:
        mechanics: What a motion obeys.
        linear: The stage with linear kinematics.
        give: Contact forces by p - gap, zero rows for open points, shape (n_c, n_c).
        margin: Margins by p - gap, shape (n_c, n_c).
        remainder: N.
        course: Margins along the motion, from the coordinates of the stage.
    """

    mechanics: Mechanics
    linear: LinearStage
    give: Array
    margin: Array
    remainder: Remainder
    course: StageMargins

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
        linear = LinearStage.of(model, active)
        remainder = Remainder.of(model, linear, give)
        course = StageMargins.of(model, linear, margin)
        return cls(mechanics, linear, give, margin, remainder, course)

    @property
    def active(self) -> Mask:
        """Which points are in contact, shape (n_c,)."""
        return self.linear.active

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        own = self.give, self.margin, self.remainder.position, self.remainder.directions
        return self.linear.nbytes + self.course.nbytes + bytes_of(*own)

    def excess(self, q: Array) -> Array:
        """P - gap at states of shape (s, J), shape (s, n_c)."""
        model = self.mechanics.model
        basis = np.eye(len(q))
        return model.kinematics.closing.displaced(q @ model.Phi.T, basis, q) - model.gap

    def forces(self, q: Array) -> Array:
        """Contact forces in N at coordinates of shape (J,), shape (n_c,)."""
        return np.asarray(self.linear.stiffness * self.margins(q))

    def margins(self, q: Array) -> Array:
        """Margins in m at coordinates of shape (J,), shape (n_c,)."""
        return self.course.at(((q - self.linear.rest) @ self.linear.V)[:, None])[:, 0]

    def acceleration(self, q: Array, velocity: Array) -> Array:
        """Q'' of states of shape (s, J)."""
        model, kinematics = self.mechanics.model, self.mechanics.model.kinematics
        pull = model.omega**2 * q + sum(f.at(q, velocity) for f in self.mechanics.forces)
        if self.linear.contact:
            shapes = kinematics.closing.shapes_at(model.Phi, q)
            force = self.excess(q) @ self.give
            pull = pull + (force[:, None, :] @ shapes)[:, 0]
        return kinematics.inertia.accelerated(q, -pull[:, :, None])[:, :, 0]

    def accelerated(self, q: Array, velocity: Array) -> Array:
        """Q'' of a state of shape (J,), by the remainder."""
        linear, remainder = self.linear, self.remainder
        pushed = remainder.directions @ remainder(self.seen(q[None], velocity[None]))[:, 0]
        return np.asarray(linear.V @ (pushed - linear.nu**2 * ((q - linear.rest) @ linear.V)))

    def seen(self, q: Array, velocity: Array) -> Array:
        """What the remainder sees of states of shape (s, J), shape (3 k + P, s)."""
        linear, remainder = self.linear, self.remainder
        position = remainder.position @ (linear.V.T @ (q - linear.rest).T)
        position += remainder.offset[:, None]
        return np.concatenate([position, remainder.rate @ (linear.V.T @ velocity.T)])
