"""Newton's iteration for one periodic motion, and a walk along the family it belongs to.

Periodic motions of a conservative model come in families of one parameter. At fixed energy a guess
can be close to a family and have no motion near it: the family turns back before it gets to this
energy, as the tongues of internal resonances do. With the energy left open the equations have one
unknown too many; the shortest Newton step then leads to the nearest motion of the family, and a
walk along its tangent to the energy that is wanted, if the family goes there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.period_map import Miss, PeriodMap


@dataclass(frozen=True, slots=True)
class Steps:
    """Bounds on steps and their number.

    Attributes:
        tolerance: Miss, relative in the energy norm, that ends Newton's iteration.
        accepted: A smaller miss that no step lowers is round-off, and taken as converged.
        iterations: Largest number of Newton steps.
        largest_step: Bound on the change of the state in one step, relative in the energy norm.
        largest_period_step: Bound on |d T| / T of one step.
        shortest_fraction: The line search gives up below this part of a step.
        walk: Largest number of steps along the family; 0 for no walk.
        walk_step: First step along the family, relative in the energy norm.
        longest_walk_step: Longest one.
        shortest_walk_step: A walk that needs shorter ones is given up.
        walk_tolerance: Miss that ends Newton's iteration on the way; the motion at its end obeys
            `tolerance`.
        farthest: A walk, or a motion, that is farther from the guess, relative in the energy norm,
            leads to, or is, another motion.
        stray: Newton's iteration is given up where it is farther from its guess.
    """

    tolerance: float = 1e-13
    accepted: float = 1e-10
    iterations: int = 20
    largest_step: float = 0.2
    largest_period_step: float = 0.02
    shortest_fraction: float = 2.0**-6
    walk: int = 40
    walk_step: float = 0.02
    longest_walk_step: float = 0.05
    shortest_walk_step: float = 1e-4
    walk_tolerance: float = 1e-6
    farthest: float = 0.3
    stray: float = float("inf")


@dataclass(frozen=True, slots=True)
class Found:
    """Where an iteration ended.

    Attributes:
        unknowns: Unknowns of the period map.
        miss: Its equations there.
        iterations: Newton steps taken.
        failure: Empty where they hold, else why not.
    """

    unknowns: Array
    miss: Miss
    iterations: int
    failure: str = ""


def periodic_motion(
    equations: PeriodMap, unknowns: Array, steps: Steps, *, keep_energy: bool
) -> Found:
    """Newton's iteration with bounded, damped steps.

    Args:
        equations: Equations, the last of which is that of the energy.
        unknowns: Guess.
        steps: Bounds.
        keep_energy: Solve all equations; else leave the energy open and take shortest steps.
    """
    at = Found(unknowns, equations.miss(unknowns), 0)
    if at.miss.failure:
        return Found(unknowns, at.miss, 0, at.miss.failure)
    while at.iterations < steps.iterations:
        values = _values(at.miss, keep_energy)
        if np.linalg.norm(values) <= steps.tolerance:
            return at
        jacobian = at.miss.jacobian[: len(values)]
        step = _bounded(np.linalg.lstsq(jacobian, -values, rcond=None)[0], steps)
        better = _line_search(equations, at, step, steps, keep_energy)
        if better is None:
            return _given_up(at, steps, keep_energy, "no step lowers the miss of {:.1e}")
        at = better
        if np.linalg.norm(at.unknowns - unknowns) > steps.stray:
            return replace(at, failure="the iteration strays from its guess")
    return _given_up(at, steps, keep_energy, "the miss is still {:.1e} after the last step allowed")


def motion_of_energy(equations: PeriodMap, steps: Steps) -> Found:
    """The periodic motion of the wanted energy: directly, or by the nearest of another energy.

    Where it is not reached, the nearest motion is given, with the reason.
    """
    direct = periodic_motion(equations, equations.start, steps, keep_energy=True)
    if not direct.failure or not steps.walk:
        return direct
    nearest = periodic_motion(equations, equations.start, steps, keep_energy=False)
    if nearest.failure:
        return direct
    return walk_to_energy(equations, nearest, steps)


def walk_to_energy(equations: PeriodMap, nearest: Found, steps: Steps) -> Found:
    """Along the family from a periodic motion to the one of the wanted energy.

    Args:
        equations: Equations with this energy.
        nearest: A periodic motion of another energy; given back, with the reason, where the wanted
            energy is not reached.
        steps: Bounds.
    """
    at, length = nearest, steps.walk_step
    before: Array = np.zeros(0)
    count, roughly = nearest.iterations, replace(steps, tolerance=steps.walk_tolerance)
    for _ in range(steps.walk):
        tangent = _tangent(at.miss, before)
        reach = -at.miss.energy_error / float(at.miss.jacobian[-1] @ tangent)
        there = 0 < reach <= length
        guess = at.unknowns + min(length, reach if there else length) * tangent
        found = periodic_motion(equations, guess, steps if there else roughly, keep_energy=there)
        count += found.iterations
        moved = float(np.linalg.norm(found.unknowns - at.unknowns))
        if found.failure or moved > 2 * length:
            length /= 2
            if length < steps.shortest_walk_step:
                return _not_reached(nearest, count, "the walk along the family is stuck")
        elif there:
            return Found(found.unknowns, found.miss, count)
        elif max(steps.farthest, _distance(equations, at)) < _distance(equations, found):
            return _not_reached(nearest, count, "the family leads away from the guess")
        else:
            passed = found.miss.energy_error * at.miss.energy_error <= 0
            before = np.zeros(0) if passed else tangent
            at, length = found, min(1.5 * length, steps.longest_walk_step)
    return _not_reached(nearest, count, f"not within {steps.walk} steps along the family")


def _not_reached(nearest: Found, iterations: int, why: str) -> Found:
    change = nearest.miss.energy_error
    return Found(
        nearest.unknowns,
        nearest.miss,
        iterations,
        f"no motion of this energy was reached from the nearest, which has {change:+.2%} of it:"
        f" {why}",
    )


def _distance(equations: PeriodMap, found: Found) -> float:
    """Distance of a motion from the guess, relative in the energy norm."""
    return float(np.linalg.norm((found.unknowns - equations.start)[:-1]))


def family_tangent(miss: Miss, along: Array) -> Array:
    """Unit tangent of the family at a periodic motion, in the sense of a direction `along`."""
    tangent = np.linalg.svd(miss.jacobian[:-1])[2][-1]
    return np.asarray(-tangent if tangent @ along < 0 else tangent)


def _tangent(miss: Miss, before: Array) -> Array:
    """Unit tangent of the family: on as before, or at first towards the wanted energy."""
    return family_tangent(miss, before if before.size else -miss.energy_error * miss.jacobian[-1])


def _values(miss: Miss, keep_energy: bool) -> Array:
    """What the equations to solve miss."""
    return miss.values if keep_energy else miss.values[:-1]


def _size(miss: Miss, keep_energy: bool) -> float:
    return float(np.linalg.norm(_values(miss, keep_energy)))


def _bounded(step: Array, steps: Steps) -> Array:
    """The step, shortened to the bounds on state and period (its last entry)."""
    state = float(np.linalg.norm(step[:-1])) / steps.largest_step
    period = abs(float(step[-1])) / steps.largest_period_step
    return step / max(1.0, state, period)


def _line_search(
    equations: PeriodMap, at: Found, step: Array, steps: Steps, keep_energy: bool
) -> Found | None:
    """The longest of the step, its half, its quarter .. that lowers the miss.

    Where the miss is accepted as it is, the step is round-off, and so are its parts.
    """
    fraction, size = 1.0, _size(at.miss, keep_energy)
    shortest = 1.0 if size <= steps.accepted else steps.shortest_fraction
    while fraction >= shortest:
        trial = at.unknowns + fraction * step
        miss = equations.miss(trial)
        if not miss.failure and _size(miss, keep_energy) < size:
            return Found(trial, miss, at.iterations + 1)
        fraction /= 2
    return None


def _given_up(at: Found, steps: Steps, keep_energy: bool, why: str) -> Found:
    size = _size(at.miss, keep_energy)
    if size <= steps.accepted:
        return at
    reason = f"{why.format(size)}: a guess with more harmonics may be nearer"
    return Found(at.unknowns, at.miss, at.iterations, reason)
