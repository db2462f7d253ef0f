"""Peaks of a response over frequency."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.response.driven import ResponsePoint


@dataclass(frozen=True, slots=True)
class Peak:
    """A largest amplitude between smaller ones.

    Attributes:
        monitor: Number of the point that is watched, from 0.
        frequency: Frequency in Hz, one of those of the response.
        amplitude: Amplitude in m, 0-peak.
        phase: Lag in degrees.
    """

    monitor: int
    frequency: float
    amplitude: float
    phase: float


def peaks(points: Sequence[ResponsePoint], monitor: int) -> Iterator[Peak]:
    """Peaks of the amplitude of a point that is watched, among the frequencies of a response.

    Frequencies at the ends, and beside one without amplitude, are none: the top may lie beyond.
    """
    amplitude = np.array([point.amplitude[monitor] for point in points])
    for here in range(1, len(points) - 1):
        if amplitude[here - 1] < amplitude[here] >= amplitude[here + 1]:
            point = points[here]
            yield Peak(
                monitor, point.frequency, float(amplitude[here]), float(point.phase[monitor])
            )


def most_moved(points: Sequence[ResponsePoint], monitors: Sequence[int]) -> int:
    """The one of some monitors with the largest amplitude; the first if there are none."""
    largest = [max(np.nan_to_num(p.amplitude[each]) for p in points) for each in monitors]
    return monitors[int(np.argmax(largest))]
