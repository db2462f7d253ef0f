"""Harmonics and time samples: the two descriptions of a periodic motion."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError


@dataclass(frozen=True, slots=True)
class Series(ABC):
    """How a periodic motion is written in time: N harmonics, m uniform samples of the period.

    c coefficients of the basis functions, s samples kept; a mean over the period is
    `weight @ values` with values at the samples.

    Attributes:
        harmonics: Number of harmonics N.
        samples: Number of uniform time samples m of one period, m > 2N.
        order: Harmonic number n of each coefficient, shape (c,).
        phase: omega t of the samples kept, shape (s,).
        weight: Share of the period for each of them, shape (s,).
        mean_square: Mean over the period of each basis function squared, shape (c,).
        synthesis: Coefficients to samples, shape (s, c).
        analysis: Samples to coefficients, shape (c, s).

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
        _check_samples(self.harmonics, self.samples)
        order, (kept, weight) = self._orders(), self._kept_samples()
        phase = 2 * np.pi * kept / self.samples
        mean_square = np.where(order == 0, 1.0, 0.5)
        synthesis = self.basis_at(phase)
        values = {
            "order": order,
            "phase": phase,
            "weight": weight,
            "mean_square": mean_square,
            "synthesis": synthesis,
            "analysis": (synthesis * weight[:, None]).T / mean_square[:, None],
        }
        for name, value in values.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    @abstractmethod
    def free_phase(self) -> bool:
        """Whether a shift in time gives another motion of the series."""

    @abstractmethod
    def basis_at(self, phase: Array) -> Array:
        """Basis functions at given phases omega t, shape (len(phase), c)."""

    @abstractmethod
    def rate_at(self, phase: Array) -> Array:
        """Derivatives of the basis functions by the phase, shape (len(phase), c)."""

    @abstractmethod
    def rotation(self) -> Array:
        """Derivative by the phase as a matrix on the coefficients, shape (c, c)."""

    @property
    @abstractmethod
    def images(self) -> tuple[int, ...]:
        """Signs of the samples at which the motion of a sample kept is repeated in the period."""

    @abstractmethod
    def interpolated(self, values: Array, phase: Array) -> Array:
        """Values at phases of a period, linear between those at the samples, (len(phase), n)."""

    @abstractmethod
    def fitted(self, coefficients: Array) -> Array:
        """Coefficients of another truncation, cut or filled with zeros to c rows."""

    @abstractmethod
    def _orders(self) -> Array:
        """Harmonic number of each coefficient."""

    @abstractmethod
    def _kept_samples(self) -> tuple[Indices, Array]:
        """Numbers of the samples kept, and the share of the period for each."""


class CosineSeries(Series):
    """Time-reversible motion: a_0 + sum a_n cos(n omega t), n = 1..N.

    The m uniform samples of a period lie symmetric about the half period, so only those of
    its first half are kept, s = m // 2 + 1; `weight` counts each as often as it occurs.
    """

    __slots__ = ()

    @property
    def free_phase(self) -> bool:
        """Whether a shift in time gives another motion of the series."""
        return False

    def basis_at(self, phase: Array) -> Array:
        """Basis functions at given phases omega t, shape (len(phase), N + 1)."""
        return np.cos(np.outer(phase, np.arange(self.harmonics + 1)))

    def rate_at(self, phase: Array) -> Array:
        """Derivatives of the basis functions by the phase, shape (len(phase), N + 1)."""
        order = np.arange(self.harmonics + 1)
        return -order * np.sin(np.outer(phase, order))

    def rotation(self) -> Array:
        """Coefficients of the derivative by the phase: it has none, being sines."""
        raise TypeError("a cosine series has no derivative of its own kind")

    @property
    def images(self) -> tuple[int, ...]:
        """Signs of the samples at which the motion of a sample kept is repeated in the period."""
        return 1, -1

    def interpolated(self, values: Array, phase: Array) -> Array:
        """Values at phases of a period, linear between those at the samples, (len(phase), n)."""
        first_half = np.minimum(np.mod(phase, 2 * np.pi), 2 * np.pi - np.mod(phase, 2 * np.pi))
        return np.array([np.interp(first_half, self.phase, column) for column in values.T]).T

    def fitted(self, coefficients: Array) -> Array:
        """Coefficients of another truncation, cut or filled with zeros to N + 1 rows."""
        return _cut_or_filled(coefficients, self.harmonics + 1)

    def _orders(self) -> Array:
        return np.arange(self.harmonics + 1.0)

    def _kept_samples(self) -> tuple[Indices, Array]:
        half = np.arange(self.samples // 2 + 1)
        occurs_once = (half == 0) | (2 * half == self.samples)
        return half, np.where(occurs_once, 1.0, 2.0) / self.samples


class FourierSeries(Series):
    """General periodic motion: a_0 + sum a_n cos(n omega t) + b_n sin(n omega t), n = 1..N.

    Rows of coefficients are a_0, a_1 .. a_N, b_1 .. b_N. A shift in time gives the same motion, so
    a phase condition belongs to it.
    """

    __slots__ = ()

    @property
    def free_phase(self) -> bool:
        """Whether a shift in time gives another motion of the series."""
        return True

    def basis_at(self, phase: Array) -> Array:
        """Basis functions at given phases omega t, shape (len(phase), 2 N + 1)."""
        angle = np.outer(phase, np.arange(self.harmonics + 1))
        return np.hstack([np.cos(angle), np.sin(angle[:, 1:])])

    def rate_at(self, phase: Array) -> Array:
        """Derivatives of the basis functions by the phase, shape (len(phase), 2 N + 1)."""
        return self.basis_at(phase) @ self.rotation()

    def rotation(self) -> Array:
        """Derivative by the phase as a matrix on the coefficients, shape (2 N + 1, 2 N + 1)."""
        rows, N = 2 * self.harmonics + 1, self.harmonics
        rotation = np.zeros((rows, rows))
        for n in range(1, N + 1):
            rotation[n, N + n] = n
            rotation[N + n, n] = -n
        return rotation

    def turned(self, coefficients: Array) -> Array:
        """Coefficients of the derivative by the phase, shape of the coefficients (c, ..)."""
        N, order = self.harmonics, self.order.reshape(-1, *[1] * (coefficients.ndim - 1))
        found = np.zeros_like(coefficients)
        found[1 : N + 1] = order[N + 1 :] * coefficients[N + 1 :]
        found[N + 1 :] = -order[1 : N + 1] * coefficients[1 : N + 1]
        return found

    @property
    def images(self) -> tuple[int, ...]:
        """Signs of the samples at which the motion of a sample kept is repeated in the period."""
        return (1,)

    def interpolated(self, values: Array, phase: Array) -> Array:
        """Values at phases of a period, linear between those at the samples, (len(phase), n)."""
        columns = (np.interp(phase, self.phase, c, period=2 * np.pi) for c in values.T)
        return np.array(list(columns)).T

    def fitted(self, coefficients: Array) -> Array:
        """Coefficients of another truncation, cut or filled with zeros to 2 N + 1 rows."""
        given = len(coefficients) // 2
        cosines = _cut_or_filled(coefficients[: given + 1], self.harmonics + 1)
        sines = _cut_or_filled(coefficients[given + 1 :], self.harmonics)
        return np.vstack([cosines, sines])

    def _orders(self) -> Array:
        numbers = np.arange(1.0, self.harmonics + 1)
        return np.concatenate([[0.0], numbers, numbers])

    def _kept_samples(self) -> tuple[Indices, Array]:
        return np.arange(self.samples), np.full(self.samples, 1 / self.samples)


def doubled(series: FourierSeries) -> FourierSeries:
    """The series of products of two motions: twice the harmonics, which its samples tell apart."""
    return _kept(2 * series.harmonics, max(series.samples, 4 * series.harmonics + 1))


@cache
def _kept(harmonics: int, samples: int) -> FourierSeries:
    """A series that is made once."""
    return FourierSeries(harmonics, samples)


def _check_samples(harmonics: int, samples: int) -> None:
    if harmonics < 1 or samples < 2 * harmonics + 1:
        raise ModelError(
            f"samples = {samples} with harmonics = {harmonics}: "
            f"must be at least 2 harmonics + 1 = {2 * harmonics + 1}"
        )


def _cut_or_filled(coefficients: Array, rows: int) -> Array:
    fitted = np.zeros((rows, coefficients.shape[1]))
    kept = min(rows, len(coefficients))
    fitted[:kept] = coefficients[:kept]
    return fitted
