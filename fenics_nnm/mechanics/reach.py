"""Amplitudes at which a closing that is quadratic in the amplitude reaches a gap."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array


def reach(gap: Array, slope: Array, curvature: Array) -> Array:
    """Smallest amplitudes, to either side, with |slope| a + 1/2 curvature a^2 = gap.

    To the side that closes a gap in first order it is reached first, if at all: a positive
    curvature helps there, and a negative one opens both sides.

    Args:
        gap: Gaps, not negative, shape (n_c,).
        slope: Closing per unit of amplitude, of either sign, shape (n_c,).
        curvature: Its second derivative, shape (n_c,).

    Returns:
        Amplitudes, inf where the gap is never reached, shape (n_c,).
    """
    steep = np.abs(slope)
    square = steep**2 + 2 * curvature * gap
    with np.errstate(divide="ignore", over="ignore"):
        found = 2 * gap / (steep + np.sqrt(np.maximum(square, 0.0)))
    return np.where(square < 0, np.inf, found)


def nearest(gap: Array, slope: Array, curvature: Array) -> tuple[float, int]:
    """Amplitude at which a closing that reaches no gap takes the largest part of one, and where.

    Args:
        gap: Gaps, positive, shape (n_c,).
        slope: Closing per unit of amplitude, shape (n_c,).
        curvature: Its second derivative, shape (n_c,), negative where no gap is reached.
    """
    bent = np.maximum(-curvature, np.finfo(float).tiny)
    point = int(np.argmax(slope**2 / (2 * bent * gap)))
    return float(abs(slope[point]) / bent[point]), point
