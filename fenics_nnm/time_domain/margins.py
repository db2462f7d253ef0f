"""The first change of contact between given times, from margins and their rates there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Mask

Exact = Callable[[int, float], tuple[float, float]]
"""From a contact point and a time to its margin and the rate of that."""

#: Parts of an interval at which a cubic through margins and rates is looked at.
_INSIDE = np.linspace(0.0, 1.0, 17)[1:-1]

#: A margin that comes down to this part of what it has at both ends is looked at closely.
_NEAR = 0.1

#: Steps to a zero, and the part of the time at which it has arrived.
_STEPS, _ARRIVED = 60, 1e-14


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
        if (self.margins[0] < self.zero).any():
            return float(self.times[0])
        ends, dips = self.margins[1:] < self.zero, self._dips()
        for at in np.flatnonzero((ends | dips).any(axis=1)):
            found = [self._crossing(at, c, exact) for c in np.flatnonzero(ends[at] | dips[at])]
            times = [time for time in found if time is not None]
            if times:
                return min(times)
        return float(self.times[-1])

    def _dips(self) -> Mask:
        """Where a margin falls, rises, and may be negative in between, shape (d - 1, n_c)."""
        before, after = self.margins[:-1], self.margins[1:]
        turns = (self.rates[:-1] < 0) & (self.rates[1:] > 0)
        if not turns.any():
            return turns
        length, t = np.diff(self.times)[:, None], _INSIDE[:, None, None]
        cubic = (
            (1 + 2 * t) * (1 - t) ** 2 * before
            + t * (1 - t) ** 2 * length * self.rates[:-1]
            + t**2 * (3 - 2 * t) * after
            + t**2 * (t - 1) * length * self.rates[1:]
        )
        return np.asarray(turns & (cubic.min(axis=0) < _NEAR * np.minimum(before, after)))

    def _crossing(self, at: int, point: int, exact: Exact) -> float | None:
        """First time after the time number `at` at which a margin comes to zero, if it does."""
        start, end = float(self.times[at]), float(self.times[at + 1])
        zero = float(self.zero[point])
        if self.margins[at + 1, point] >= zero:
            end = _root(lambda time: (-exact(point, time)[1], None), start, end, 0.0)
            if exact(point, end)[0] >= zero:
                return None
        if self.margins[at, point] <= 0:
            return start
        return _root(lambda time: exact(point, time), start, end, -zero)


def _root(
    function: Callable[[float], tuple[float, float | None]], start: float, end: float, zero: float
) -> float:
    """Where a function that is positive at the start and not at the end changes sign.

    By Newton's steps where there are slopes and they stay inside, else by halving, until its value
    is below what counts as zero.
    """
    time = (start + end) / 2
    for _ in range(_STEPS):
        value, slope = function(time)
        if abs(value) <= zero:
            break
        start, end = (time, end) if value > 0 else (start, time)
        before = time
        time = time - value / slope if slope else start
        if not start < time < end:
            time = (start + end) / 2
        if abs(time - before) <= _ARRIVED * end or end - start <= _ARRIVED * end:
            break
    return time
