"""The first change of contact between given times, from margins and their rates there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask

Exact = Callable[[int, float], tuple[float, float]]
"""From a contact point and a time to its margin and the rate of that."""

#: A number, or numbers at many places.
Value = TypeVar("Value", Array, float)

#: Parts of an interval at which a cubic through margins and rates is looked at.
_INSIDE = np.linspace(0.0, 1.0, 17)[1:-1]

#: A margin that comes down to this part of what it has at both ends is looked at closely.
_NEAR = 0.1

#: The cubic is below the lower of its ends by this part of its slopes at both, at most.
_DEEPEST = 4 / 27 + 1e-6

#: Steps to a zero, and the part of the time at which it has arrived.
_STEPS, _ARRIVED = 60, 1e-14

#: Value, over that at the start, at which the zero of a cubic is found.
_ROUGH = 1e-6


@dataclass(frozen=True, slots=True)
class Margins:
    """Margins of the contact points at times, see `mechanics.closed`.

    Attributes:
        times: Times, ascending, so close that margins are nearly cubic in between, shape (d,).
        margins: Margins, shape (d, n_c).
        rates: Their rates, shape (d, n_c).
        zero: Margins below this are negative, shape (n_c,).
    """

    times: Array
    margins: Array
    rates: Array
    zero: Array

    def first_negative(self, exact: Exact) -> float:
        """First time at which a margin is negative, or the last time."""
        points = self._near()
        if not points.size:
            return float(self.times[-1])
        margins, zero = self.margins[:, points], self.zero[points]
        if (margins[0] < zero).any():
            return float(self.times[0])
        near = Margins(self.times, margins, self.rates[:, points], zero)
        return near._first_negative(lambda point, time: exact(int(points[point]), time))

    def _near(self) -> Indices:
        """Points whose margins may be negative: cubics of the others stay well above zero."""
        times, lowest = self.times, self.margins.min(axis=0)
        deepest = 2 * _DEEPEST / (1 - _NEAR) * float((times[1:] - times[:-1]).max(initial=0.0))
        far = lowest > deepest * np.abs(self.rates).max(axis=0)
        return (~far).nonzero()[0]

    def _first_negative(self, exact: Exact) -> float:
        """The same where no margin is negative at first."""
        ends, dips = self.margins[1:] < self.zero, self._dips()
        for at in np.flatnonzero((ends | dips).any(axis=1)):
            found = [self._crossing(at, c, exact) for c in np.flatnonzero(ends[at] | dips[at])]
            times = [time for time in found if time is not None]
            if times:
                return min(times)
        return float(self.times[-1])

    def _dips(self) -> Mask:
        """Where a margin falls, rises, and may be negative in between, shape (d - 1, n_c)."""
        turns = (self.rates[:-1] < 0) & (self.rates[1:] > 0)
        at, point = np.nonzero(turns)
        if len(at):
            before, after, falls, rises = ends = self._ends(at, point)
            low = np.minimum(before, after)
            near = low - _DEEPEST * (rises - falls) < _NEAR * low
            turns[at, point] = near
            if near.any():
                lowest = _cubic(_INSIDE[:, None], *(each[near] for each in ends))[0].min(axis=0)
                turns[at[near], point[near]] = lowest < _NEAR * low[near]
        return np.asarray(turns)

    def _ends(self, at: Indices | int, point: Indices | int) -> tuple[Array, Array, Array, Array]:
        """Margins at the ends of intervals, and rates there times their lengths."""
        length = self.times[at + 1] - self.times[at]
        margins, rates = self.margins, self.rates
        slopes = length * rates[at, point], length * rates[at + 1, point]
        return (margins[at, point], margins[at + 1, point], *slopes)

    def _crossing(self, at: int, point: int, exact: Exact) -> float | None:
        """First time after the time number `at` at which a margin comes to zero, if it does."""
        start, end = float(self.times[at]), float(self.times[at + 1])
        zero, ends = float(self.zero[point]), [float(each) for each in self._ends(at, point)]
        if self.margins[at + 1, point] >= zero:
            end = _root(lambda time: (-exact(point, time)[1], None), start, end, 0.0)
            lowest, _ = exact(point, end)
            if lowest >= zero:
                return None
            ends = [
                ends[0],
                lowest,
                ends[2] * (end - start) / (float(self.times[at + 1]) - start),
                0.0,
            ]
        if self.margins[at, point] <= 0:
            return start
        first = start + (end - start) * _cubic_root(*ends)
        return _root(lambda time: exact(point, time), start, end, -zero, first)


def _cubic(
    t: Value, before: Value, after: Value, falls: Value, rises: Value
) -> tuple[Value, Value]:
    """A cubic in t = 0 .. 1 with values and slopes at both ends, and its slope.

    Args:
        t: Where.
        before: Value at 0.
        after: Value at 1.
        falls: Slope at 0.
        rises: Slope at 1.
    """
    square, steep = 3 * (after - before) - 2 * falls - rises, 2 * (before - after) + falls + rises
    value = before + t * (falls + t * (square + t * steep))
    return value, falls + t * (2 * square + 3 * t * steep)


def _cubic_root(before: float, after: float, falls: float, rises: float) -> float:
    """Where the cubic changes sign, from positive to not positive, to a few digits."""

    def function(t: float) -> tuple[float, float | None]:
        return _cubic(t, before, after, falls, rises)

    return _root(function, 0.0, 1.0, _ROUGH * before)


def _root(
    function: Callable[[float], tuple[float, float | None]],
    start: float,
    end: float,
    zero: float,
    first: float | None = None,
) -> float:
    """Where a function that is positive at the start and not at the end changes sign.

    By Newton's steps where there are slopes and they stay inside, else by halving, until its value
    is below what counts as zero, or the next step would be: steps of Newton's iteration are, from
    some step on, a factor times the square of those before.
    """
    time = (start + end) / 2 if first is None else first
    arrived, last = _ARRIVED * end, end - start
    for _ in range(_STEPS):
        value, slope = function(time)
        if abs(value) <= zero:
            break
        start, end = (time, end) if value > 0 else (start, time)
        before, newton = time, bool(slope)
        time = time - value / slope if slope else start
        if not start < time < end:
            time, newton = (start + end) / 2, False
        step = abs(time - before)
        following = step * (step / last) ** 2 if newton else step
        last = step if newton else end - start
        if min(step, following) <= arrived or end - start <= arrived:
            break
    return time
