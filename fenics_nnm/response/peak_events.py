"""Peaks along the curve of a response: where the displacement of a place is largest.

Of the displacement x of a place, psi q or what second-order kinematics make of it, the amplitude
|x_1| of its first harmonic, and its largest value over the period, rise and fall along the curve.
Their slopes by the length of the curve are

    Re(x_1* dx_1) / |x_1|,      dx at the time of the largest x,

the second because the time at which x is largest does not change it in first order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import CurvePoint, Problem
from fenics_nnm.continuation.events import EventTest
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.response.watched import Watched

#: Kinds of peaks.
PEAK, HIGHEST = "peak of the amplitude", "peak of the largest displacement"

#: Instants of a period among which the largest displacement is looked for at first.
_INSTANTS = 256

#: Newton steps to the time of the largest displacement.
_STEPS = 6


@dataclass(frozen=True, slots=True)
class Crest:
    """Slopes of a place's amplitude and largest displacement along a curve.

    Attributes:
        series: Series in time.
        watched: Places that are watched.
        place: Number of the place.
    """

    series: FourierSeries
    watched: Watched
    place: int = 0

    def amplitude_slope(self, problem: Problem, point: CurvePoint) -> float:
        """Of the amplitude of the first harmonic, relative."""
        first = self.series.order == 1
        x, dx = self._moved(point)
        return float(x[first] @ dx[first] / max(float(x[first] @ x[first]), 1e-300))

    def largest_slope(self, problem: Problem, point: CurvePoint) -> float:
        """Of the largest displacement, relative to the amplitude."""
        x, dx = self._moved(point)
        basis = self.series.basis_at(np.array([self._time(x)]))[0]
        return float(basis @ dx / max(float(np.linalg.norm(x)), 1e-300))

    def _moved(self, point: CurvePoint) -> tuple[Array, Array]:
        """Coefficients of the displacement and of its change along the curve, shape (c,)."""
        change = point.metric.unscaled(point.tangent)
        watched, place, q = self.watched, self.place, point.solution.q
        moved = watched.free_harmonics(self.series, place, q)
        return moved, watched.slope_harmonics(self.series, place, q, change.q)

    def _time(self, x: Array) -> float:
        """Phase of the largest displacement."""
        phases = 2 * np.pi * np.arange(_INSTANTS) / _INSTANTS
        at = float(phases[np.argmax(self.series.basis_at(phases) @ x)])
        rate = self.series.turned(x)
        bend = self.series.turned(rate)
        for _ in range(_STEPS):
            basis = self.series.basis_at(np.array([at]))[0]
            if basis @ bend < 0:
                at -= float(np.clip(basis @ rate / (basis @ bend), -0.02, 0.02))
        return at


def crests(crest: Crest, problem: Problem) -> tuple[EventTest, ...]:
    """Tests for peaks: slopes that fall through zero in the order of the curve."""

    def test(kind: str, slope: Callable[[Problem, CurvePoint], float]) -> EventTest:
        def falls(first: CurvePoint, second: CurvePoint) -> bool:
            return slope(problem, first) > 0 > slope(problem, second)

        return EventTest(kind, slope, falls)

    return test(PEAK, crest.amplitude_slope), test(HIGHEST, crest.largest_slope)
