r"""The equations of periodic motions of a driven model, and their derivatives.

With Y = (omega_j q, q') / A the state in the energy norm of the guess, w = omega / omega_0, and P
the state after the period 2 pi / omega of the force,

    r(Y, w) = P(Y, w) - Y = 0,      dr/dY = M - 1,

with M the derivative of the flow over the period. At a fixed frequency Newton's iteration solves
r = 0 for Y; where that has no slope, near a fold, the shortest step in (Y, w) leads to the nearest
motion of the branch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.driven_flow import DrivenFlow

#: Relative difference of frequencies from which the slope by the frequency follows.
_DIFFERENCE = 1e-6


@dataclass(frozen=True, slots=True)
class Missed:
    """By how much a motion misses its start, and the derivatives of that.

    Attributes:
        values: The miss r, shape (2 J,).
        by_state: The matrix M - 1, shape (2 J, 2 J).
        failure: Empty, or why the motion was not followed.
    """

    values: Array
    by_state: Array
    failure: str = ""

    @property
    def size(self) -> float:
        """Norm of r, relative in the energy norm; infinite after a failure."""
        return float("inf") if self.failure else float(np.linalg.norm(self.values))


@dataclass(frozen=True, slots=True)
class DrivenMap:
    """Equations in the units of a guess.

    Attributes:
        flow: Flow, driven at the frequency of the guess.
        amplitude: Unit of the energy norm, kg^1/2 m/s.
    """

    flow: DrivenFlow
    amplitude: float

    @classmethod
    def around(cls, flow: DrivenFlow, q: Array, velocity: Array) -> DrivenMap:
        """In units of a state."""
        return cls(flow, float(np.linalg.norm([flow.model.omega * q, velocity])) or 1.0)

    @property
    def scale(self) -> Array:
        """From a state (q, q') to Y, shape (2 J,)."""
        omega = self.flow.model.omega
        return np.concatenate([omega, np.ones_like(omega)]) / self.amplitude

    def unknowns(self, q: Array, velocity: Array, omega: float) -> Array:
        """Y and w of a state at a circular frequency, shape (2 J + 1,)."""
        state = self.scale * np.concatenate([q, velocity])
        return np.append(state, omega / self.flow.drive.omega)

    def state(self, unknowns: Array) -> tuple[Array, Array]:
        """Coordinates and velocities."""
        q, velocity = np.split(unknowns[:-1] / self.scale, 2)
        return q, velocity

    def omega(self, unknowns: Array) -> float:
        """Circular frequency in rad/s."""
        return float(unknowns[-1]) * self.flow.drive.omega

    def driven(self, unknowns: Array) -> DrivenFlow:
        """The flow at the frequency of unknowns."""
        return self.flow.at(self.omega(unknowns))

    def miss(self, unknowns: Array) -> Missed:
        """R and its derivative by the state."""
        size, period = len(unknowns) - 1, 2 * np.pi / self.omega(unknowns)
        after = self.driven(unknowns).run(*self.state(unknowns), period, along=np.eye(size))
        ends, scale = self.scale * np.concatenate([after.q, after.velocity]), self.scale
        transition = np.eye(size) if after.transition is None else after.transition
        by_state = scale[:, None] * transition / scale - np.eye(size)
        return Missed(ends - unknowns[:-1], by_state, after.failure)

    def by_frequency(self, unknowns: Array) -> Array:
        """Derivative of r by w, from differences, shape (2 J,)."""
        ends = []
        for sign in (1, -1):
            near = unknowns.copy()
            near[-1] *= 1 + sign * _DIFFERENCE
            period = 2 * np.pi / self.omega(near)
            after = self.driven(near).run(*self.state(near), period)
            ends.append(self.scale * np.concatenate([after.q, after.velocity]))
        return np.asarray((ends[0] - ends[1]) / (2 * _DIFFERENCE * unknowns[-1]))

    def jacobian(self, unknowns: Array, miss: Missed) -> Array:
        """Derivative of r by Y and w, shape (2 J, 2 J + 1)."""
        return np.column_stack([miss.by_state, self.by_frequency(unknowns)])

    def tangent(self, unknowns: Array, along: Array) -> Array:
        """Unit tangent of the branch, in the sense of a given direction, shape (2 J + 1,)."""
        jacobian = self.jacobian(unknowns, self.miss(unknowns))
        tangent = np.linalg.svd(jacobian)[2][-1]
        return np.asarray(tangent if tangent @ along >= 0 else -tangent)
