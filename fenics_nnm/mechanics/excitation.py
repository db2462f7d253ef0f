"""Forces that are given as functions of time, in harmonics of the frequency of the motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import Series


@dataclass(frozen=True, slots=True)
class Excitation:
    """A modal force cosine cos(n omega t) + sine sin(n omega t), n the number of its harmonic.

    Attributes:
        harmonic: Number n of the harmonic, at least 0.
        cosine: Modal force in phase with cos(n omega t), N kg^-1/2, shape (J,).
        sine: Modal force in phase with sin(n omega t), shape (J,).
    """

    harmonic: int
    cosine: Array
    sine: Array

    def harmonics(self, series: Series) -> Array:
        """Coefficients in a general series, on the right-hand side, shape (2 N + 1, J).

        Raises:
            ValueError: if the series has no such harmonic, or no sines.
        """
        rows = np.flatnonzero(series.order == self.harmonic)
        if len(rows) != (2 if self.harmonic else 1):
            raise ValueError(f"harmonic {self.harmonic} of an excitation is not in the series")
        parts = np.zeros((len(series.order), len(self.cosine)))
        for row, part in zip(rows, (self.cosine, self.sine), strict=False):
            parts[row] = part
        return parts
