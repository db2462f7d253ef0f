"""Periodic motions of driven models to round-off, by shooting, with their Floquet multipliers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.driven_flow import DrivenFlow
from fenics_nnm.time_domain.driven_map import DrivenMap, Missed

#: Kinds of instability, by the largest multiplier.
FOLD = "real multiplier above 1: fold or symmetry breaking"
DOUBLING = "real multiplier below -1: period doubling"
TORUS = "complex multipliers outside the unit circle: quasi-periodic motion begins"

#: Multipliers within this distance of the unit circle are on it, and do not make unstable.
_ON_CIRCLE = 1e-9


@dataclass(frozen=True, slots=True)
class DrivenSteps:
    """Bounds on Newton's iteration.

    Attributes:
        tolerance: Miss, relative in the energy norm, that ends it.
        accepted: A smaller miss that no step lowers is round-off, and taken as converged.
        iterations: Largest number of steps.
        largest_step: Bound on a step, relative in the energy norm.
        shortest_fraction: The line search gives up below this part of a step.
    """

    tolerance: float = 1e-12
    accepted: float = 1e-9
    iterations: int = 25
    largest_step: float = 0.2
    shortest_fraction: float = 2.0**-8


@dataclass(frozen=True, slots=True)
class DrivenOrbit:
    """A periodic motion of a driven model.

    Attributes:
        q: Modal coordinates at phase 0 of the force in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        omega: Circular frequency in rad/s.
        return_error: Distance of the state after a period from its start, relative in the energy
            norm of the guess.
        multipliers: All Floquet multipliers, by falling modulus, shape (2 J,).
        changes: Changes of contact in a period.
        contact_fraction: Share of the period with contact somewhere.
        iterations: Newton steps taken.
        failure: Empty where the motion is periodic, else why not.
    """

    q: Array
    velocity: Array
    omega: float
    return_error: float
    multipliers: Complex
    changes: int
    contact_fraction: float
    iterations: int
    failure: str = ""

    @property
    def largest_multiplier(self) -> float:
        """Largest modulus of the multipliers; nan if there are none."""
        return float(np.abs(self.multipliers[0])) if self.multipliers.size else float("nan")

    @property
    def instability(self) -> str:
        """Kind of its instability; nothing where it is stable."""
        return instability_of(self.multipliers)

    @property
    def stable(self) -> bool:
        """Whether all multipliers are inside the unit circle, or on it."""
        return not self.failure and not self.instability


def instability_of(multipliers: Complex) -> str:
    """Kind of instability by Floquet multipliers of falling modulus; nothing where stable."""
    if not multipliers.size or not abs(multipliers[0]) > 1 + _ON_CIRCLE:
        return ""
    largest = multipliers[0]
    if abs(largest.imag) > _ON_CIRCLE * abs(largest):
        return TORUS
    return FOLD if largest.real > 0 else DOUBLING


@dataclass(frozen=True, slots=True)
class Arrived:
    """Where Newton's iteration ended."""

    unknowns: Array
    miss: Missed
    iterations: int
    failure: str = ""


Step = Callable[[Array, Missed], Array]
"""From unknowns and their miss to a Newton step."""


def driven_orbit(
    flow: DrivenFlow,
    q: Array,
    velocity: Array,
    *,
    keep_frequency: bool = True,
    steps: DrivenSteps | None = None,
) -> DrivenOrbit:
    """Shoot for the periodic motion near a state at phase 0 of the force.

    Args:
        flow: Flow, driven at the frequency of the guess.
        q: Modal coordinates of the guess, shape (J,).
        velocity: Their velocities, shape (J,).
        keep_frequency: Look for the motion at this frequency; else for the nearest of the branch.
        steps: Bounds on the iteration.
    """
    equations = DrivenMap.around(flow, q, velocity)
    start = equations.unknowns(q, velocity, flow.drive.omega)
    step = at_fixed_frequency if keep_frequency else _nearest(equations)
    return orbit_of(equations, arrived(equations, start, step, steps))


def arrived(
    equations: DrivenMap, unknowns: Array, step: Step, steps: DrivenSteps | None = None
) -> Arrived:
    """Newton's iteration with bounded, damped steps; never raises for non-convergence."""
    steps = steps or DrivenSteps()
    at = Arrived(unknowns, equations.miss(unknowns), 0)
    while at.miss.size > steps.tolerance:
        if at.miss.failure:
            return Arrived(at.unknowns, at.miss, at.iterations, at.miss.failure)
        after = _searched(equations, at, step, steps) if at.iterations < steps.iterations else None
        if after is None:
            return Arrived(at.unknowns, at.miss, at.iterations, _stalled(at, steps))
        at = after
    return at


def _stalled(at: Arrived, steps: DrivenSteps) -> str:
    """Nothing where what is left is round-off."""
    if at.miss.size <= steps.accepted:
        return ""
    return f"no periodic motion found: Newton's iteration stops at a miss of {at.miss.size:.1e}"


def _searched(equations: DrivenMap, at: Arrived, step: Step, steps: DrivenSteps) -> Arrived | None:
    """The iteration after one more step; None if no part of it lowers the miss."""
    try:
        change = step(at.unknowns, at.miss)
    except np.linalg.LinAlgError:
        return None
    fraction = min(1.0, steps.largest_step / max(float(np.linalg.norm(change)), 1e-300))
    while fraction > steps.shortest_fraction:
        trial = at.unknowns + fraction * change
        miss = equations.miss(trial)
        if miss.size < at.miss.size:
            return Arrived(trial, miss, at.iterations + 1)
        fraction /= 2
    return None


def at_fixed_frequency(unknowns: Array, miss: Missed) -> Array:
    """A step of the state alone."""
    return np.append(np.linalg.solve(miss.by_state, -miss.values), 0.0)


def _nearest(equations: DrivenMap) -> Step:
    """Shortest steps of state and frequency."""

    def step(unknowns: Array, miss: Missed) -> Array:
        return np.asarray(np.linalg.lstsq(equations.jacobian(unknowns, miss), -miss.values)[0])

    return step


def orbit_of(equations: DrivenMap, found: Arrived) -> DrivenOrbit:
    """The motion that an iteration ended with."""
    flow, (q, velocity) = equations.driven(found.unknowns), equations.state(found.unknowns)
    period = 2 * np.pi / flow.drive.omega
    whole = flow.run(q, velocity, period)
    failure = found.failure or whole.failure
    multipliers: Complex = np.empty(0, complex)
    if not failure:
        multipliers = np.linalg.eigvals(found.miss.by_state + np.eye(2 * len(q))).astype(complex)
    return DrivenOrbit(
        q=q,
        velocity=velocity,
        omega=flow.drive.omega,
        return_error=found.miss.size,
        multipliers=multipliers[np.argsort(-np.abs(multipliers), kind="stable")],
        changes=whole.changes,
        contact_fraction=whole.contact_time / period,
        iterations=found.iterations,
        failure=failure,
    )
