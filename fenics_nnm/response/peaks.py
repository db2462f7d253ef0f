"""Peaks of a response over frequency."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.response.point import ResponsePoint

#: A peak is no noise of round-off if it stands this much of its height above the valleys beside it,
#: and is this part of the largest amplitude of any place.
_ABOVE, _PART = 1e-9, 1e-12


@dataclass(frozen=True, slots=True)
class Peak:
    """A largest amplitude between smaller ones.

    Attributes:
        monitor: Number of the place that is watched, from 0.
        frequency: Frequency in Hz, one of those of the response.
        amplitude: Amplitude in m, 0-peak.
        phase: Lag in degrees.
        level: Factor of the forces.
    """

    monitor: int
    frequency: float
    amplitude: float
    phase: float
    level: float = 1.0


def peaks(points: Sequence[ResponsePoint], monitor: int) -> Iterator[Peak]:
    """Peaks of the amplitude of a place that is watched, among the points of one curve.

    Points at the ends, and beside one without amplitude, are none: the top may lie beyond. Nor is
    the round-off of a place that does not move, or of a curve that is level.
    """
    amplitude = np.array([point.amplitude[monitor] for point in points])
    least = _PART * max(np.nan_to_num(point.amplitude).max() for point in points)
    for here in range(1, len(points) - 1):
        if amplitude[here - 1] < amplitude[here] >= amplitude[here + 1] and (
            amplitude[here] > least and _stands_out(amplitude, here)
        ):
            point = points[here]
            yield Peak(
                monitor,
                point.frequency,
                float(amplitude[here]),
                float(point.phase[monitor]),
                point.level,
            )


def _stands_out(amplitude: Array, here: int) -> bool:
    """Whether a peak is above the valleys between it and higher points, or the ends.

    Of peaks of one height the first counts as the highest.
    """
    top, before, after = amplitude[here], amplitude[:here][::-1], amplitude[here + 1 :]
    valley = max(_valley(before, before >= top), _valley(after, after > top))
    return bool(top - valley > _ABOVE * top)


def _valley(side: Array, higher: Array) -> float:
    """Smallest amplitude on one side of a peak, up to the first that is higher."""
    ends = np.flatnonzero(higher)
    return float(np.nanmin(side[: ends[0] if len(ends) else None]))


def curve_peaks(points: Sequence[ResponsePoint], others: int) -> Iterator[Peak]:
    """Peaks of all levels and branches, of the places before the contact points and one of these.

    Args:
        points: Points in the order of the curves.
        others: Number of places before the contact points.
    """
    for _, each in itertools.groupby(points, key=lambda point: (point.level, point.branch)):
        own = list(each)
        every = range(len(own[0].amplitude))
        for monitor in (*every[:others], most_moved(own, every[others:])):
            yield from peaks(own, monitor)


def most_moved(points: Sequence[ResponsePoint], monitors: Sequence[int]) -> int:
    """The one of some places with the largest amplitude; the first if there are none."""
    largest = [max(np.nan_to_num(p.amplitude[each]) for p in points) for each in monitors]
    return monitors[int(np.argmax(largest))]
