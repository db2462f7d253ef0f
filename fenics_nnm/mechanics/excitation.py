r"""Forces that are given as functions of time, in harmonics of the frequency of the motion.

With second-order kinematics a place that is pushed moves by x = psi q + 1/2 q^T theta q, so that a
force F(t) along x acts on the coordinates by (psi + theta q)^T F(t): it turns with the motion.
"""

from __future__ import annotations

from dataclasses import dataclass, field

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
        turning: What each of both adds per master of second-order kinematics, on these, in
            N kg^-1/2 per kg^1/2 m = N/(kg m), shape (2, k, k); k = 0 where it does not turn.
    """

    harmonic: int
    cosine: Array
    sine: Array
    turning: Array = field(default_factory=lambda: np.zeros((2, 0, 0)))

    def harmonics(self, series: Series) -> Array:
        """Coefficients in a general series, on the right-hand side, shape (2 N + 1, J).

        Raises:
            ValueError: if the series has no such harmonic, or no sines.
        """
        return self._placed(series, self.cosine, self.sine)

    def turning_harmonics(self, series: Series) -> Array:
        """Coefficients of `turning`, shape (2 N + 1, k, k).

        Raises:
            ValueError: as `harmonics`.
        """
        return self._placed(series, *self.turning)

    def _placed(self, series: Series, cosine: Array, sine: Array) -> Array:
        """Parts in phase with the cosine and the sine, in their places."""
        rows = np.flatnonzero(series.order == self.harmonic)
        if len(rows) != (2 if self.harmonic else 1):
            raise ValueError(f"harmonic {self.harmonic} of an excitation is not in the series")
        parts = np.zeros((len(series.order), *cosine.shape))
        for row, part in zip(rows, (cosine, sine), strict=False):
            parts[row] = part
        return parts
