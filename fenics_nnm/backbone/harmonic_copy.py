"""A motion of period T written as one of period k T: the start of subharmonic branches.

With a fundamental frequency k times lower the harmonics n of a motion become k n, and there is
room for harmonics between them. The copy solves the same equations; where the motion doubles its
period (k = 2), or meets a subharmonic family of order k, the copy has a branch point. Since gamma
weighs harmonic n by n^2, it is k^2 times as large for the copy, and omega is k times smaller: the
kinetic energy stays.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.solution import Solution, evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns


def copy_equations(equations: HarmonicEquations, k: int) -> HarmonicEquations:
    """The same model and law with k N harmonics and k m samples, for periods k times as long.

    The samples are those of k periods, so a copy solves these equations as exactly as the motion
    does its own.

    Raises:
        ModelError: if k is less than 1.
    """
    if k < 1:
        raise ModelError(f"harmonic copy of order {k}: must be at least 1")
    series = equations.series
    return replace(equations, series=type(series)(k * series.harmonics, k * series.samples))


def harmonic_copy(
    equations: HarmonicEquations, solution: Solution, k: int, *, later: bool = False
) -> tuple[HarmonicEquations, Solution]:
    """A motion in harmonics k, 2 k .. k N of a k times lower frequency, and equations for it.

    Args:
        equations: Equations of the motion.
        solution: Motion.
        k: Order, at least 1.
        later: Begin half a period of the motion later. A time-reversible motion is even about both
            instants, but of the motions of k times its period a cosine series has only those that
            are even about its begin: where k is even, the two begins show different branches.

    Raises:
        ModelError: if k is less than 1.
    """
    longer = copy_equations(equations, k)
    order = equations.series.order.astype(int)
    sign = np.where(order % 2, -1.0, 1.0) if later else np.ones(len(order))
    q = np.zeros(longer.shape)
    q[_rows(longer.series, order * k)] = sign[:, None] * solution.q
    return longer, evaluated(longer, Unknowns.of(q, solution.omega / k))


def linear_motion(
    equations: HarmonicEquations, mode: int, *, harmonic: int = 1, amplitude: float = 0.9
) -> Solution:
    """A linear mode about the state of rest in a harmonic: where its subharmonic branches begin.

    Args:
        equations: Harmonic equations.
        mode: Index of the mode, from 0.
        harmonic: Number of the harmonic, 1..N; the fundamental frequency is omega_j over it.
        amplitude: Amplitude over that at which the mode just touches, less than 1.

    Raises:
        ModelError: if there is no such harmonic, or the motion would touch, or the mode never does,
            or small motions about the state of rest are not linear.
    """
    if not 1 <= harmonic <= equations.series.harmonics:
        raise ModelError(
            f"harmonic = {harmonic}: must be between 1 and {equations.series.harmonics}"
        )
    if not 0 < amplitude < 1:
        raise ModelError(
            f"amplitude = {amplitude:g}: must be between 0 and 1, where contact begins"
        )
    rest = equations.rest
    if not rest.is_linear(mode):
        raise ModelError("points touch at rest, so no motion is linear: harmonic must be 1")
    q = np.zeros(equations.shape)
    q[0] = rest.q
    q[harmonic] = amplitude * rest.amplitude(mode) * rest.shapes[:, mode]
    return evaluated(equations, Unknowns.of(q, float(rest.omega[mode]) / harmonic))


def _rows(series: Series, numbers: Indices) -> Indices:
    """Rows of harmonics 0, 1 .. in a longer series: cosines, then sines where it has them."""
    sines = np.cumsum(np.diff(numbers, prepend=0) < 0) > 0
    return np.asarray(numbers + np.where(sines, series.harmonics, 0))
