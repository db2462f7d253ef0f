r"""Gaps that move: an obstacle that passes by, such as a casing that is not round past its blade.

    g(t) = g0 + Re(sum_n G_n exp(i n omega t)),

in harmonics of the frequency of the motion. In the frame of the contact points such a gap is a
displacement -(g - g0) that is given, which is all that contact laws see of it. It does the work
-lambda g' on the structure.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.mechanics.fourier import Series

#: Instants of a period of the highest harmonic among which the smallest gap is looked for; between
#: them by a parabola, to 1e-6 of the amplitude.
_INSTANTS = 128


@dataclass(frozen=True, slots=True)
class GapMotion:
    """How gaps differ from their mean over a period.

    Attributes:
        harmonics: Numbers n of the harmonics, from 1, each once; none where gaps stand still.
        amplitudes: G in m, shape (F, n_c); (0, 1) of any number of gaps that stand still.
    """

    harmonics: tuple[int, ...]
    amplitudes: Complex

    @property
    def moves(self) -> bool:
        """Whether gaps move at all."""
        return bool(self.harmonics)

    @property
    def highest(self) -> int:
        """Number of the highest harmonic, 0 without any."""
        return max(self.harmonics, default=0)

    def scaled(self, level: float) -> GapMotion:
        """The same with all amplitudes times a factor."""
        return replace(self, amplitudes=level * self.amplitudes)

    def coefficients(self, series: Series) -> Array:
        """Coefficients of g - g0 in a general series, shape (c, n_c), or (c, 1) of still gaps.

        Raises:
            ValueError: if the series lacks a harmonic.
        """
        found = np.zeros((len(series.order), self.amplitudes.shape[1]))
        for n, amplitude in zip(self.harmonics, self.amplitudes, strict=True):
            rows = np.flatnonzero(series.order == n)
            if len(rows) != 2:
                raise ValueError(f"harmonic {n} of a moving gap is not in the series")
            found[rows] = amplitude.real, -amplitude.imag
        return found

    def at(self, phase: Array | float) -> Array:
        """The change g - g0 in m at phases, shape (.., n_c), or (.., 1) of still gaps."""
        return np.asarray((self._waves(phase) @ self.amplitudes).real)

    def rate(self, phase: Array | float) -> Array:
        """Its derivative by the phase, as `at`."""
        turned = 1j * np.array(self.harmonics, float)[:, None] * self.amplitudes
        return np.asarray((self._waves(phase) @ turned).real)

    @property
    def lowest(self) -> Array:
        """Smallest change in m over a period, shape (n_c,), or (1,) of still gaps."""
        count = _INSTANTS * max(self.highest, 1)
        values = self.at(2 * np.pi * np.arange(count) / count)
        at, columns = values.argmin(axis=0), np.arange(values.shape[1])
        before, here, after = (values[(at + n) % count, columns] for n in (-1, 0, 1))
        bend = before - 2 * here + after
        fall = (after - before) ** 2 / np.where(bend > 0, 8 * bend, 1.0)
        return np.asarray(here - np.where(bend > 0, fall, 0.0))

    def _waves(self, phase: Array | float) -> Complex:
        return np.asarray(np.exp(1j * np.multiply.outer(phase, np.array(self.harmonics, float))))


#: Gaps that stand still.
STILL = GapMotion((), np.zeros((0, 1), complex))
