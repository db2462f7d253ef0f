r"""The equations of motions in phase resonance in time, and their derivatives.

A force -level p sin(omega t) keeps a damped motion up. With Y = (omega_j q, q') / A the state at
its phase 0 in the energy norm of a guess, and P the state after a period,

    P(Y, omega, level) - Y = 0,
    <p . q sin(omega t)> = 0               the force does not push against the motion,
    <|q'|^2> / (2 omega^2) = gamma         the motion has the wanted modal energy,

<> the mean over the period. Nothing is truncated: motion, means and their derivatives by Y are
exact between changes of contact; those by omega and level are
differences. Harmonic by harmonic it is `nonlinear.resonant`, which has the source.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.stretch_means import gradients_of, integrals

#: Differences of frequency and level, in their units, from which the slopes by them follow.
_DIFFERENCE = 1e-7


@dataclass(frozen=True, slots=True)
class Course:
    """One period of a motion.

    Attributes:
        end: State (q, q') after it, shape (2 J,).
        transition: Derivative of that by the first state, shape (2 J, 2 J).
        across: Mean of p . q sin(omega t).
        along: Mean of p . q cos(omega t).
        squared_speed: Mean of |q'|^2.
        slopes: Derivatives of `across` and `squared_speed` by the first state, shape (2, 2 J).
        contact_fraction: Share of the period with contact somewhere.
        changes: Changes of contact.
    """

    end: Array
    transition: Array
    across: float
    along: float
    squared_speed: float
    slopes: Array
    contact_fraction: float
    changes: int


@dataclass(frozen=True, slots=True)
class Missed:
    """By how much unknowns miss the equations, and the derivatives of that.

    Attributes:
        values: Left-hand sides, shape (2 J + 2,).
        jacobian: Their derivatives by the unknowns; empty where not asked for.
        course: The period that was followed.
    """

    values: Array
    jacobian: Array
    course: Course

    @property
    def size(self) -> float:
        """Norm of the left-hand sides; infinite where they are not numbers."""
        size = float(np.linalg.norm(self.values))
        return size if np.isfinite(size) else float("inf")


@dataclass(frozen=True, slots=True)
class ResonantMap:
    """Equations in the units of a guess.

    Attributes:
        flow: Flow, driven by the force of level 1.
        push: p, shape (J,), not zero.
        gamma: Wanted modal energy coordinate in kg m^2.
        omega: Unit of the frequency in rad/s.
        level: Unit of the level.
    """

    flow: DampedFlow
    push: Array
    gamma: float
    omega: float
    level: float

    @property
    def amplitude(self) -> float:
        """Unit of the energy norm in kg^1/2 m/s: the largest speed of one mode with this gamma."""
        return 2 * self.omega * float(np.sqrt(self.gamma))

    @property
    def scale(self) -> Array:
        """From a state (q, q') to Y, shape (2 J,)."""
        omega = self.flow.model.omega
        return np.concatenate([omega, np.ones_like(omega)]) / self.amplitude

    def unknowns(self, q: Array, velocity: Array, omega: float, level: float) -> Array:
        """Y, and frequency and level in their units, shape (2 J + 2,)."""
        state = self.scale * np.concatenate([q, velocity])
        return np.concatenate([state, [omega / self.omega, level / self.level]])

    def state(self, unknowns: Array) -> tuple[Array, Array]:
        """Coordinates and velocities."""
        q, velocity = np.split(unknowns[:-2] / self.scale, 2)
        return q, velocity

    def driven(self, unknowns: Array) -> DampedFlow:
        """The flow at the frequency and level of unknowns."""
        drive, level = self.flow.drive, float(unknowns[-1]) * self.level
        omega = float(unknowns[-2]) * self.omega
        return self.flow.driven_by(Drive(omega, drive.order, level * drive.amplitude))

    def missed(self, unknowns: Array) -> Missed:
        """Left-hand sides alone."""
        course = followed(self.driven(unknowns), *self.state(unknowns), self.push, slopes=False)
        return Missed(self._values(unknowns, course), np.empty((0, 0)), course)

    def linearised(self, unknowns: Array) -> Missed:
        """Left-hand sides with their derivatives."""
        course = followed(self.driven(unknowns), *self.state(unknowns), self.push, slopes=True)
        size, scale = len(unknowns) - 2, self.scale
        jacobian = np.empty((size + 2, size + 2))
        jacobian[:size, :size] = scale[:, None] * course.transition / scale - np.eye(size)
        jacobian[size:, :size] = self._weights(unknowns)[:, None] * course.slopes / scale
        values = self._values(unknowns, course)
        for parameter in (-2, -1):
            jacobian[:, parameter] = self._slope(unknowns, values, parameter)
        return Missed(values, jacobian, course)

    def _weights(self, unknowns: Array) -> Array:
        """From the means of a period to the left-hand sides, shape (2,)."""
        omega = float(unknowns[-2]) * self.omega
        across = 2 * self.omega / (float(np.linalg.norm(self.push)) * self.amplitude)
        return np.array([across, 1 / (2 * omega**2 * self.gamma)])

    def _values(self, unknowns: Array, course: Course) -> Array:
        means = self._weights(unknowns) * (course.across, course.squared_speed)
        return np.concatenate([self.scale * course.end - unknowns[:-2], means - (0.0, 1.0)])

    def _slope(self, unknowns: Array, values: Array, parameter: int) -> Array:
        """Derivative of the left-hand sides by frequency or level."""
        ahead = unknowns.copy()
        ahead[parameter] += _DIFFERENCE
        change = float(ahead[parameter] - unknowns[parameter])
        return np.asarray((self.missed(ahead).values - values) / change)


def followed(flow: DampedFlow, q: Array, velocity: Array, push: Array, *, slopes: bool) -> Course:
    """One period of a motion from a state at phase 0 of the force."""
    omega, size = flow.drive.omega, 2 * len(q)
    period = 2 * np.pi / omega
    transition: Array = np.eye(size)
    gradients, means = np.zeros((2, size)), np.zeros(3)
    touching, changes = 0.0, -1
    for stretch in flow.stretches(q, velocity, period):
        means += integrals(stretch, omega, push)
        if slopes:
            gradients += gradients_of(stretch, omega, push) @ transition
            transition = stretch.motion.carried(transition, stretch.duration)
        q, velocity = stretch.motion.state(stretch.duration)
        touching += stretch.duration * stretch.motion.contact
        changes += 1
    across, along, squared = (float(mean) / period for mean in means)
    end = np.concatenate([q, velocity])
    share = touching / period
    return Course(end, transition, across, along, squared, gradients / period, share, changes)
