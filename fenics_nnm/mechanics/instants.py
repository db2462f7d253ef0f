"""Instants of a period at which contact forces are known, and how harmonics follow from them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import Series


class Instants(Protocol):
    """Instants with weights, for the coefficients of a series."""

    def weight(self, series: Series) -> Array:
        """Share of the period that each stands for, shape (s,)."""

    def synthesis(self, series: Series) -> Array:
        """Coefficients to values at the instants, shape (s, c)."""

    def analysis(self, series: Series) -> Array:
        """Values at the instants to coefficients, shape (c, s)."""


class Samples:
    """The samples of the series itself, evenly spread."""

    __slots__ = ()

    def weight(self, series: Series) -> Array:
        """Share of the period that each stands for, shape (s,)."""
        return series.weight

    def synthesis(self, series: Series) -> Array:
        """Coefficients to values at the samples, shape (s, c)."""
        return series.synthesis

    def analysis(self, series: Series) -> Array:
        """Values at the samples to coefficients, shape (c, s)."""
        return series.analysis


SAMPLES = Samples()


@dataclass(frozen=True, slots=True)
class Quadrature:
    """Points of a rule of integration over parts of the period; elsewhere the values are zero.

    Attributes:
        phase: Phases omega t, ascending, shape (s,).
        share: Weights as parts of the period, shape (s,).
    """

    phase: Array
    share: Array

    def weight(self, series: Series) -> Array:
        """Share of the period that each stands for, shape (s,)."""
        return self.share

    def synthesis(self, series: Series) -> Array:
        """Coefficients to values at the points, shape (s, c)."""
        return series.basis_at(self.phase)

    def analysis(self, series: Series) -> Array:
        """Values at the points to coefficients, shape (c, s)."""
        weighted = series.basis_at(self.phase) * self.share[:, None]
        return np.asarray(weighted.T / series.mean_square[:, None])
