"""Motions in phase resonance to round-off: damped, kept up, of a given modal energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.resonant_map import Missed, ResonantMap

#: Miss, relative in the energy norm, that ends Newton's iteration; a smaller one that no step
#: lowers is round-off.
TOLERANCE, ACCEPTED = 1e-11, 1e-9

#: Most Newton steps; bounds on the change of state and of the frequency by one; and the part of a
#: step below which the search gives up.
_STEPS, _LARGEST_STEP, _LARGEST_SHIFT, _SHORTEST = 16, 0.2, 0.03, 2.0**-8


@dataclass(frozen=True, slots=True)
class ResonantMotion:
    """A motion, kept up against damping by a force in phase resonance.

    Attributes:
        q: Modal coordinates at phase 0 of the force -level p sin(omega t), shape (J,).
        velocity: Their velocities, shape (J,).
        omega: Circular frequency in rad/s.
        level: Level of the force.
        damping_ratio: Power of the force over 4 omega times the mean kinetic energy.
        slope: d ln omega / d ln gamma along the family; nan where it is not known.
        return_error: Miss of all its equations, relative in the energy norm.
        multipliers: All Floquet multipliers under the force, by falling modulus, shape (2 J,).
        contact_fraction: Share of the period with contact somewhere.
        changes: Changes of contact in a period.
        iterations: Newton steps taken.
        failure: Empty, or why no motion was found.
    """

    q: Array
    velocity: Array
    omega: float
    level: float
    damping_ratio: float = float("nan")
    slope: float = float("nan")
    return_error: float = float("nan")
    multipliers: Complex = ()  # type: ignore[assignment]
    contact_fraction: float = float("nan")
    changes: int = 0
    iterations: int = 0
    failure: str = ""

    @property
    def state(self) -> Array:
        """All that is unknown of it, shape (2 J + 2,)."""
        return np.concatenate([self.q, self.velocity, [self.omega, self.level]])

    @classmethod
    def guessed(cls, state: Array) -> ResonantMotion:
        """A guess."""
        q, velocity = np.split(state[:-2], 2)
        return cls(q, velocity, float(state[-2]), float(state[-1]))


def driven_by_push(model: ReducedModel, rate: Array, push: Array) -> DampedFlow:
    """The flow of a damped model under -p sin(omega t).

    Args:
        model: Reduced model, contact points without mass, linear kinematics.
        rate: C in 1/s, shape (J, J).
        push: p, shape (J,).
    """
    force = Excitation(1, np.zeros_like(push), -push)
    return DampedFlow(model, rate, Drive.of(float(model.omega[0]), [force], model.modes))


def resonant_motion(
    flow: DampedFlow, push: Array, gamma: float, guess: ResonantMotion
) -> ResonantMotion:
    """The motion of a modal energy near a guess, by Newton's iteration; never raises for failure.

    Args:
        flow: Flow of `driven_by_push`.
        push: The same p.
        gamma: Modal energy coordinate in kg m^2.
        guess: Motion nearby.
    """
    equations = ResonantMap(flow, push, gamma, guess.omega, guess.level)
    at = equations.unknowns(guess.q, guess.velocity, guess.omega, guess.level)
    missed, failure, steps = equations.linearised(at), "", 0
    while missed.size > TOLERANCE:
        after = _searched(equations, at, missed) if steps < _STEPS else None
        if after is None:
            if missed.size > ACCEPTED:
                failure = (
                    f"no motion found: Newton's iteration stops at a miss of {missed.size:.1e}"
                )
            break
        at, steps = after, steps + 1
        missed = equations.linearised(at)
    if not failure and at[-1] <= 0:
        failure = "the force brakes the motion"
    return _motion(equations, at, missed, steps, failure)


def _searched(equations: ResonantMap, at: Array, missed: Missed) -> Array | None:
    """The unknowns after one more step; None if no part of it lowers the miss."""
    try:
        change = np.linalg.solve(missed.jacobian, -missed.values)
    except np.linalg.LinAlgError:
        return None
    size = max(float(np.linalg.norm(change[:-2])), 1e-300)
    shift = max(abs(float(change[-2])), 1e-300)
    fraction = min(1.0, _LARGEST_STEP / size, _LARGEST_SHIFT / shift)
    while fraction > _SHORTEST:
        trial = at + fraction * change
        if trial[-2] > 0 and equations.missed(trial).size < missed.size:
            return np.asarray(trial)
        fraction /= 2
    return None


def _motion(
    equations: ResonantMap, at: Array, missed: Missed, steps: int, failure: str
) -> ResonantMotion:
    """The motion that an iteration ended with."""
    q, velocity = equations.state(at)
    omega, level = float(at[-2]) * equations.omega, float(at[-1]) * equations.level
    course = missed.course
    multipliers = np.linalg.eigvals(course.transition).astype(complex)
    return ResonantMotion(
        q=q,
        velocity=velocity,
        omega=omega,
        level=level,
        damping_ratio=level * course.along / (2 * course.squared_speed),
        slope=_slope(at, missed),
        return_error=missed.size,
        multipliers=multipliers[np.argsort(-np.abs(multipliers), kind="stable")],
        contact_fraction=course.contact_fraction,
        changes=course.changes,
        iterations=steps,
        failure=failure,
    )


def _slope(at: Array, missed: Missed) -> float:
    """D ln omega / d ln gamma: the last equation is gamma over the wanted one."""
    unit = np.zeros_like(at)
    unit[-1] = 1.0
    try:
        return float(np.linalg.solve(missed.jacobian, unit)[-2] / at[-2])
    except np.linalg.LinAlgError:
        return float("nan")
