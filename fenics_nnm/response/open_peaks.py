"""Peaks of the response without contact, located between the wanted frequencies."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.response.driven import NothingTouches, open_motion
from fenics_nnm.response.peaks import Peak, most_moved, peaks
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.structure import DrivenStructure

#: Peaks are located to this part of the distance between two wanted frequencies.
_PART = 1e-7


def open_peaks(
    structure: DrivenStructure, series: FourierSeries, points: Sequence[ResponsePoint]
) -> Iterator[Peak]:
    """Peaks of the places before the contact points, and of the contact point that moves most.

    Args:
        structure: Driven structure at the level of the points.
        series: Series in time.
        points: Its motions at the wanted frequencies, ascending.
    """
    every, others = range(len(structure.monitors)), structure.watched.before_contact
    first = _amplitudes(structure, series)
    step = float(np.diff([point.frequency for point in points]).max(initial=0.0))
    for monitor in (*every[:others], most_moved(points, every[others:])):
        for peak in peaks(points, monitor):
            yield _located(peak, first, step)


def _amplitudes(
    structure: DrivenStructure, series: FourierSeries
) -> Callable[[float, int], complex]:
    """The complex amplitude of a place at a frequency in Hz."""
    equations = HarmonicEquations(structure.mechanics, series, NothingTouches())
    first, second = np.flatnonzero(series.order == 1)

    def amplitude(frequency: float, monitor: int) -> complex:
        q = open_motion(equations, 2 * np.pi * frequency).q
        x = q[[first, second]] @ structure.watched.shapes[monitor]
        return complex(x[0], -x[1])

    return amplitude


def _located(peak: Peak, first: Callable[[float, int], complex], step: float) -> Peak:
    """The top near the highest of some points."""
    found = minimize_scalar(
        lambda frequency: -abs(first(float(frequency), peak.monitor)),
        bounds=(peak.frequency - step, peak.frequency + step),
        method="bounded",
        options={"xatol": _PART * step},
    )
    top = first(float(found.x), peak.monitor)
    if abs(top) < peak.amplitude:
        return peak
    phase = float(np.rad2deg(-np.angle(top)) % 360.0)
    return Peak(peak.monitor, float(found.x), abs(top), phase, peak.level)
