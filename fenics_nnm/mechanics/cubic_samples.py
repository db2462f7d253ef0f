"""The fewest samples in which cubic forces of a series are exact.

The cube of N harmonics has 3 N of them. Of m samples harmonic n looks like m - n, so that m > 4 N
leave those up to N, and the mean of a fourth power, as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import Series


@dataclass(frozen=True, slots=True)
class CubicSamples:
    """Samples of a series of N harmonics and 4 N + 1 samples.

    Attributes:
        analysis: Samples to coefficients, shape (c, s).
        weight: Share of the period for each sample, shape (s,).
        basis: Coefficients to samples, and to derivatives of first and second order by the phase
            there, shape (3, s, c).
    """

    analysis: Array
    weight: Array
    basis: Array

    @classmethod
    def of(cls, series: Series) -> CubicSamples:
        """Those of a series; they are made once."""
        return _of_kind(type(series), series.harmonics)

    def states(self, q: Array, omega: float) -> tuple[Array, Array, Array]:
        """Displacement, velocity and acceleration of coefficients (c, k), each (s, k)."""
        displacement, by_phase, twice = self.basis @ q
        return displacement, omega * by_phase, omega**2 * twice

    def tangent(self, blocks: Array, omega: float) -> Array:
        """Derivative of the harmonics of forces by coefficients, shape (c, k, c, k').

        Args:
            blocks: Derivatives of the forces by displacement, velocity and acceleration at the
                samples, or by the first of these alone, shape (1 to 3, s, k, k').
            omega: Circular frequency.
        """
        powers = omega ** np.arange(len(blocks))[:, None, None, None]
        scaled = (powers * blocks).transpose(0, 2, 3, 1)[..., None]
        moved = np.sum(scaled * self.basis[: len(blocks), None, None], axis=0)
        return np.asarray((self.analysis @ moved).transpose(2, 0, 3, 1))


@cache
def _of_kind(kind: type[Series], harmonics: int) -> CubicSamples:
    series = kind(harmonics, 4 * harmonics + 1)
    synthesis, rates = series.synthesis, series.rate_at(series.phase)
    basis = np.array([synthesis, rates, -synthesis * series.order**2])
    return CubicSamples(series.analysis, series.weight, basis)
