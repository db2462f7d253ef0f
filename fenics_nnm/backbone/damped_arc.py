"""Down in damping by arc-length: through folds, and where a motion changes much over little of it.

Near internal resonances, and where contact points begin to touch once more, a damped motion of one
energy changes with the damping so fast that steps of the damping lose it, or the family turns back
before it goes on to less damping.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.resonant_arc import ArcPoint, ResonantArc
from fenics_nnm.time_domain.resonant_map import ResonantMap
from fenics_nnm.time_domain.resonant_motion import ResonantMotion, resonant_motion

#: First, longest and shortest step, relative in the energy norm, and their largest number.
_FIRST, _LONGEST, _SHORTEST, _MOST = 0.03, 0.2, 1e-5, 400

#: Steps grow by this factor where Newton takes no more than so many.
_GROWTH, _EASY = 1.5, 4

#: A family that comes back to more than this is back at heavy damping.
_BACK = 1.0

#: The motion at the end is within so many last steps of the one before it.
_LANDS = 2.0


@dataclass(frozen=True, slots=True)
class Place:
    """A motion on the way.

    Attributes:
        s: The number.
        motion: Motion there.
        grazes: Whether a contact begins or ends there.
    """

    s: float
    motion: ResonantMotion
    grazes: bool = False


@dataclass(frozen=True, slots=True)
class ArcWalk:
    """Where a way along a family came to.

    Attributes:
        last: The last place on the way.
        folds: Places at which the family turns back.
        motion: The motion at s = 0; None if it does not come there.
        failure: Empty, or why it does not.
    """

    last: Place
    folds: tuple[Place, ...] = ()
    motion: ResonantMotion | None = None
    failure: str = ""


def arc_walk(
    equations: Callable[[float], ResonantMap], begin: tuple[float, ResonantMotion]
) -> ArcWalk:
    """Along a family from a motion at a number s > 0 down to s = 0.

    Args:
        equations: Equations at a value of s, in the same units at all of them.
        begin: Number and a motion there.
    """
    arc, (s, motion) = ResonantArc(equations), begin
    start = equations(s).unknowns(motion.q, motion.velocity, motion.omega, motion.level)
    at, length = arc.first(np.append(start, s), -1.0), _FIRST
    folds: list[Place] = []
    failure, steps = "", 0
    while not failure:
        landing = _to_zero(at)
        if landing <= length:
            if (found := _landed(equations, at, landing)) is not None:
                return ArcWalk(Place(0.0, found), tuple(folds), found)
            length = landing / 2
        after, steps = arc.next(at, length), steps + 1
        if after is None:
            length /= 2
        else:
            if after.heading * at.heading < 0:
                folds.append(_place(equations, after, at))
            length = _longer(length, after)
            at = after
        failure = _end(at, length, steps)
    return ArcWalk(_place(equations, at, at), tuple(folds), failure=failure)


def _longer(length: float, after: ArcPoint) -> float:
    """The length of the next step after one that was taken."""
    return min(_GROWTH * length, _LONGEST) if after.iterations <= _EASY else length


def _end(at: ArcPoint, length: float, steps: int) -> str:
    """Why a way ends, or nothing."""
    if length < _SHORTEST:
        return "its steps get too short"
    if at.s > _BACK:
        return "it leads back to heavy damping"
    return f"no end after {_MOST} steps" if steps >= _MOST else ""


def _to_zero(at: ArcPoint) -> float:
    """Length along the tangent to s = 0; infinite where that leads away."""
    return at.s / -at.heading if at.heading < 0 else float("inf")


def _landed(
    equations: Callable[[float], ResonantMap], at: ArcPoint, length: float
) -> ResonantMotion | None:
    """The motion at s = 0, a length ahead; None if there is none that follows."""
    there = equations(0.0)
    guess = _motion(there, at.x + length * at.tangent)
    if guess.omega <= 0 or guess.level <= 0:
        return None
    found = resonant_motion(there.flow, there.push, there.gamma, guess)
    reached = there.unknowns(found.q, found.velocity, found.omega, found.level)
    far = float(np.linalg.norm(reached - at.x[:-1])) > _LANDS * length
    return None if found.failure or far else found


def _place(equations: Callable[[float], ResonantMap], at: ArcPoint, before: ArcPoint) -> Place:
    """The place of a point, with the point before it."""
    grazes = at.course.changes != before.course.changes
    return Place(at.s, _motion(equations(at.s), at.x), grazes)


def _motion(equations: ResonantMap, x: Array) -> ResonantMotion:
    """The motion of unknowns, the last of which is s."""
    q, velocity = equations.state(x[:-1])
    omega, level = float(x[-3]) * equations.omega, float(x[-2]) * equations.level
    return ResonantMotion(q, velocity, omega, level)
