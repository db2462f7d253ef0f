"""Gauss quadrature over a stretch of time, of functions that turn no faster than a given rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array

#: Points of a panel; a panel lasts for so many radians of the fastest part.
_POINTS, _RADIANS = 12, 2.0
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)


@dataclass(frozen=True, slots=True)
class Panels:
    """Times and weights.

    Attributes:
        times: Ascending times in s, shape (g,).
        weights: Weights in s, shape (g,).
    """

    times: Array
    weights: Array

    @classmethod
    def over(cls, time: float, fastest: float) -> Panels:
        """Those from 0 to a time in s, for functions of rates up to `fastest` in rad/s."""
        count = max(int(np.ceil(fastest * time / _RADIANS)), 1)
        half = time / count / 2
        middles = half * (2 * np.arange(count) + 1)
        times = (middles[:, None] + half * _NODES).ravel()
        return cls(times, np.tile(half * _WEIGHTS, count))
