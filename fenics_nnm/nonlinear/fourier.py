"""Harmonics and time samples: the two descriptions of a periodic motion."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError


@dataclass(frozen=True, slots=True)
class CosineSeries:
    """Time-reversible motion: a_0 + sum a_n cos(n omega t), n = 1..N.

    The m uniform samples of a period lie symmetric about the half period, so only those of
    its first half are kept; `weight` counts each as often as it occurs. A mean over the samples
    is `weight @ values`.

    Attributes:
        harmonics: Number of harmonics N.
        samples: Number of uniform time samples m of one period, m > 2N.
        order: Harmonic number n of each coefficient, shape (N + 1,).
        phase: omega t of the samples kept, shape (m // 2 + 1,).
        weight: Share of the period for each of them, shape (m // 2 + 1,).
        mean_square: Mean over the period of each basis function squared, shape (N + 1,).
        synthesis: Coefficients to samples, shape (m // 2 + 1, N + 1).
        analysis: Samples to coefficients, shape (N + 1, m // 2 + 1).

    Raises:
        ModelError: if m < 2N + 1, which would alias the highest harmonic.
    """

    harmonics: int
    samples: int
    order: Array = field(init=False, repr=False)
    phase: Array = field(init=False, repr=False)
    weight: Array = field(init=False, repr=False)
    mean_square: Array = field(init=False, repr=False)
    synthesis: Array = field(init=False, repr=False)
    analysis: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.harmonics < 1 or self.samples < 2 * self.harmonics + 1:
            raise ModelError(
                f"samples = {self.samples} with harmonics = {self.harmonics}: "
                f"must be at least 2 harmonics + 1 = {2 * self.harmonics + 1}"
            )
        order = np.arange(self.harmonics + 1.0)
        half = np.arange(self.samples // 2 + 1)
        occurs_once = (half == 0) | (2 * half == self.samples)
        weight = np.where(occurs_once, 1.0, 2.0) / self.samples
        mean_square = np.where(order == 0, 1.0, 0.5)
        synthesis = self.basis_at(2 * np.pi * half / self.samples)
        values = {
            "order": order,
            "phase": 2 * np.pi * half / self.samples,
            "weight": weight,
            "mean_square": mean_square,
            "synthesis": synthesis,
            "analysis": (synthesis * weight[:, None]).T / mean_square[:, None],
        }
        for name, value in values.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    def basis_at(self, phase: Array) -> Array:
        """Basis functions at given phases omega t, shape (len(phase), N + 1)."""
        return np.cos(np.outer(phase, np.arange(self.harmonics + 1)))

    def rate_at(self, phase: Array) -> Array:
        """Derivatives of the basis functions by the phase, shape (len(phase), N + 1)."""
        order = np.arange(self.harmonics + 1)
        return -order * np.sin(np.outer(phase, order))

    def fitted(self, coefficients: Array) -> Array:
        """Coefficients of another truncation, cut or filled with zeros to N + 1 rows."""
        fitted = np.zeros((self.harmonics + 1, coefficients.shape[1]))
        rows = min(len(fitted), len(coefficients))
        fitted[:rows] = coefficients[:rows]
        return fitted
