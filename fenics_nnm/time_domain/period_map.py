"""The equations of shooting: what a periodic motion of given energy has to obey."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.integrator import Integrator, Trajectory


@dataclass(frozen=True, slots=True)
class Target:
    """State and period of the guess, and the energy to keep.

    Attributes:
        q: Modal coordinates in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        period: Period in s.
        energy: Total energy in J.
    """

    q: Array
    velocity: Array
    period: float
    energy: float

    @property
    def amplitude(self) -> float:
        """sqrt(2 E): norm of (omega q, q') in a motion without contact."""
        return float(np.sqrt(2 * self.energy))


@dataclass(frozen=True, slots=True)
class Miss:
    """What the equations miss at some unknowns.

    Attributes:
        values: Left-hand sides, the energy's last.
        derivative: Gives their derivative by the unknowns.
        failure: Empty, or why there are none.
    """

    values: Array
    derivative: Callable[[], Array]
    failure: str = ""

    @property
    def jacobian(self) -> Array:
        """Derivative of the left-hand sides by the unknowns."""
        return self.derivative()

    @property
    def energy_error(self) -> float:
        """H / E - 1."""
        return float(self.values[-1])


class PeriodMap(Protocol):
    """Equations for dimensionless unknowns, the last of which is T / T0."""

    @property
    def target(self) -> Target:
        """Guess, and the energy to keep."""

    @property
    def start(self) -> Array:
        """Unknowns of the guess."""

    def state(self, unknowns: Array) -> tuple[Array, Array, float]:
        """Modal coordinates, velocities and period."""

    def miss(self, unknowns: Array) -> Miss:
        """Left-hand sides and derivative."""


def period_map(flow: Integrator, target: Target, *, reversible: bool) -> PeriodMap:
    """The equations for a motion from rest to rest, or for any motion."""
    return ReversibleMap(flow, target) if reversible else GeneralMap(flow, target)


@dataclass(frozen=True, slots=True)
class ReversibleMap:
    """From rest to rest in half a period; unknowns omega q / sqrt(2 E) and T / T0."""

    flow: Integrator
    target: Target

    @property
    def start(self) -> Array:
        """Unknowns of the guess, shape (J + 1,)."""
        return np.append(self.flow.model.omega * self.target.q / self.target.amplitude, 1.0)

    def state(self, unknowns: Array) -> tuple[Array, Array, float]:
        """Modal coordinates, velocities (none) and period; of the guess to its last digit."""
        if np.array_equal(unknowns, self.start):
            return self.target.q, np.zeros_like(self.target.q), self.target.period
        q = unknowns[:-1] * self.target.amplitude / self.flow.model.omega
        return q, np.zeros_like(q), float(unknowns[-1]) * self.target.period

    def miss(self, unknowns: Array) -> Miss:
        """Velocities after half a period and error of the energy, J + 1 equations."""
        q, rest, period = self.state(unknowns)
        half = self.flow.run(q, rest, period / 2, along=np.eye(2 * len(q), len(q)))
        energy = self.flow.energy(q, rest) / self.target.energy - 1
        values = np.append(half.velocity / self.target.amplitude, energy)
        return Miss(values, cache(partial(self._jacobian, q, half)), half.failure)

    def _jacobian(self, q: Array, half: Trajectory) -> Array:
        """Derivative of what is missed from coordinates at rest."""
        target, omega, modes = self.target, self.flow.model.omega, len(q)
        jacobian = np.zeros((modes + 1, modes + 1))
        transition = half.transition
        if transition is not None:
            jacobian[:modes, :modes] = transition[modes:] / omega
        braking = self.flow.acceleration(half.q, half.velocity) * target.period / 2
        jacobian[:modes, modes] = braking / target.amplitude
        by_q = self.flow.energy_gradient(q, np.zeros_like(q))[:modes] / target.energy
        jacobian[modes, :modes] = by_q * target.amplitude / omega
        return jacobian


@dataclass(frozen=True, slots=True)
class GeneralMap:
    """Any state and back after a period; unknowns omega q, q' over sqrt(2 E), and T / T0."""

    flow: Integrator
    target: Target

    @property
    def start(self) -> Array:
        """Unknowns of the guess, shape (2 J + 1,)."""
        scaled = self._scale * np.concatenate([self.target.q, self.target.velocity])
        return np.append(scaled, 1.0)

    def state(self, unknowns: Array) -> tuple[Array, Array, float]:
        """Modal coordinates, velocities and period; of the guess to its last digit."""
        if np.array_equal(unknowns, self.start):
            return self.target.q, self.target.velocity, self.target.period
        q, velocity = np.split(unknowns[:-1] / self._scale, 2)
        return q, velocity, float(unknowns[-1]) * self.target.period

    def miss(self, unknowns: Array) -> Miss:
        """Return, phase and energy, 2 J + 2 equations.

        Energy is conserved, so the return along its gradient follows from the other equations
        where they hold. It is left out (projected), or it would be an equation without a slope.
        """
        q, velocity, period = self.state(unknowns)
        scale, size = self._scale, 2 * len(q)
        after = self.flow.run(q, velocity, period, along=np.eye(size))
        gradient = self.flow.energy_gradient(q, velocity) / scale
        across = _projection(gradient)
        ends = scale * np.concatenate([after.q, after.velocity])
        shift = self._phase_condition() @ (unknowns - self.start)[:-1]
        energy = self.flow.energy(q, velocity) / self.target.energy - 1
        values = np.concatenate([across @ (ends - unknowns[:-1]), [shift, energy]])
        return Miss(values, cache(partial(self._jacobian, after, gradient, across)), after.failure)

    def _jacobian(self, after: Trajectory, gradient: Array, across: Array) -> Array:
        """Derivative of what is missed from a state with a gradient of the energy."""
        target, scale, size = self.target, self._scale, len(gradient)
        jacobian = np.zeros((size + 2, size + 1))
        transition = after.transition
        if transition is not None:
            returned = scale[:, None] * transition / scale - np.eye(size)
            jacobian[:size, :size] = across @ returned
        jacobian[:size, size] = across @ self._rate(after.q, after.velocity) * target.period
        jacobian[size, :size] = self._phase_condition()
        jacobian[size + 1, :size] = gradient / target.energy
        return jacobian

    @property
    def _scale(self) -> Array:
        omega = self.flow.model.omega
        return np.concatenate([omega, np.ones_like(omega)]) / self.target.amplitude

    def _rate(self, q: Array, velocity: Array) -> Array:
        return self._scale * np.concatenate([velocity, self.flow.acceleration(q, velocity)])

    def _phase_condition(self) -> Array:
        """Unit vector along the flow at the guess."""
        rate = self._rate(self.target.q, self.target.velocity)
        return rate / np.linalg.norm(rate)


def _projection(normal: Array) -> Array:
    """Projection along a direction."""
    unit = normal / np.linalg.norm(normal)
    return np.eye(len(unit)) - np.outer(unit, unit)
