"""Walking from one damped motion to another: a number changes in steps, a motion follows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.resonant_motion import ResonantMotion

#: From a value of the number and a guess to the motion there.
Solver = Callable[[float, ResonantMotion], ResonantMotion]

#: Steps grow by this factor where Newton takes no more than so many, up to so many first ones.
_GROWTH, _EASY, _LARGEST = 1.5, 5, 4.0


@dataclass(frozen=True, slots=True)
class Step:
    """Steps of the number.

    Attributes:
        first: First step.
        smallest: A step that fails is halved down to this.
        jump: A motion whose frequency is farther from the expected one, relatively, is another one.
        leap: So is one whose state is, in the energy norm.
    """

    first: float
    smallest: float
    jump: float = 0.01
    leap: float = 0.25


@dataclass(frozen=True, slots=True)
class Walk:
    """Where a walk came to.

    Attributes:
        values: Values of the number, in the order of the walk.
        motions: Motions there.
        failure: Empty, or why it ended before its end.
    """

    values: tuple[float, ...]
    motions: tuple[ResonantMotion, ...]
    failure: str = ""

    def at(self, value: float) -> ResonantMotion | None:
        """The motion at a value that it came by."""
        known = dict(zip(self.values, self.motions, strict=True))
        return known.get(value)


def walk(
    solver: Solver,
    omega: Array,
    begin: tuple[float, ResonantMotion],
    end: float,
    step: Step,
    stops: Sequence[float] = (),
) -> Walk:
    """Walk from a motion to the end, and by all stops on the way.

    Args:
        solver: Finds motions.
        omega: Natural circular frequencies, for the energy norm, shape (J,).
        begin: First value, and a motion there.
        end: Last value.
        step: Steps.
        stops: Values that are to have a motion, between the two.
    """
    values, motions, length = [begin[0]], [begin[1]], step.first
    while values[-1] != end:
        to = _next(values[-1], end, length, stops)
        guess = _predicted(values, motions, to)
        found = solver(to, guess)
        failure = found.failure or _jump(omega, guess, found, step)
        if failure:
            length /= 2
            if length < step.smallest:
                return Walk(tuple(values), tuple(motions), failure)
            continue
        if found.iterations <= _EASY:
            length = min(_GROWTH * length, _LARGEST * step.first)
        values.append(to)
        motions.append(found)
    return Walk(tuple(values), tuple(motions))


def _next(at: float, end: float, length: float, stops: Sequence[float]) -> float:
    """The next value: a step away, or the next stop before that."""
    way = 1.0 if end > at else -1.0
    ahead = [stop for stop in (*stops, end) if way * (stop - at) > 0]
    return min([at + way * length, *ahead], key=lambda value: way * value)


def _predicted(
    values: Sequence[float], motions: Sequence[ResonantMotion], to: float
) -> ResonantMotion:
    """A guess on the line through the last two motions."""
    last = motions[-1]
    if len(values) < 2:
        return last
    part = (to - values[-1]) / (values[-1] - values[-2])
    guess = last.state + part * (last.state - motions[-2].state)
    return ResonantMotion.guessed(guess) if guess[-2:].min() > 0 else last


def _jump(omega: Array, guess: ResonantMotion, found: ResonantMotion, step: Step) -> str:
    """That a motion does not follow from those before it, or nothing."""
    if abs(shift := found.omega / guess.omega - 1) > step.jump:
        return f"the frequency jumps by {shift:+.2%}"
    old, new = (np.concatenate([omega * each.q, each.velocity]) for each in (guess, found))
    leap = float(np.linalg.norm(new - old) / np.linalg.norm(old))
    return f"the motion jumps by {leap:.0%} of its size" if leap > step.leap else ""
