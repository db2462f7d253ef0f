r"""Exact solutions of z' = A z + sum_f B_f exp(i nu_f t), resonant ones among them.

With A = diag(d), each component by itself is

    z(t) = exp(d t) z(0) + sum_f B_f exp(i nu_f t) g(d - i nu_f),      g(s) = (exp(s t) - 1) / s,

where g = t at s = 0: growth in resonance without damping is no special case. Where A has no
well-conditioned basis of eigenvectors, as at critical damping, the exponential of the matrix

    [[A, B], [0, diag(i nu)]]

gives the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.linalg import eigvalsh, expm

from fenics_nnm.arrays import Array, Complex

_TINY = np.finfo(float).tiny

#: Growth in the exponent, over the time for which sizes are bounded.
_GROWTH = 0.5


@dataclass(frozen=True, slots=True)
class Push:
    """The inhomogeneous part.

    Attributes:
        amplitude: B, shape (K, F).
        rates: nu in rad/s, shape (F,).
    """

    amplitude: Complex
    rates: Array

    @property
    def fastest(self) -> float:
        """Largest |nu|; 0 without a force."""
        return float(np.abs(self.rates).max(initial=0.0))


class Propagator(Protocol):
    """Solutions for a matrix A of size K."""

    def carried(self, z: Complex, time: float) -> Complex:
        """exp(A t) z, shape of z, (K,) or (K, c)."""

    def at(self, z: Complex, push: Push, time: float) -> Complex:
        """The solution from z after a time, shape (K,)."""

    def through(self, z: Complex, push: Push, times: Array) -> Complex:
        """The solution from z at times, shape (len(times), K)."""

    def window(self, push: Push) -> float:
        """For how long `sizes` are good bounds."""

    def sizes(self, z: Complex, push: Push, window: float) -> Array:
        """Bounds of |z_k| for a window from z, shape (K,)."""

    def bends(self, rows: Complex, sizes: Array, push: Push) -> Array:
        """Bounds of |(rows z)''| where |z_k| is at most `sizes`, shape of (rows z)."""


@dataclass(frozen=True, slots=True)
class Diagonal:
    """A = diag(d).

    Attributes:
        d: Eigenvalues in 1/s, shape (K,).
    """

    d: Complex

    def carried(self, z: Complex, time: float) -> Complex:
        """exp(A t) z."""
        return np.asarray((np.exp(time * self.d) * z.T).T)

    def at(self, z: Complex, push: Push, time: float) -> Complex:
        """The solution from z after a time, shape (K,)."""
        own = np.exp(time * self.d) * z
        if not push.rates.size:
            return np.asarray(own)
        apart = self._apart(push)
        grown = push.amplitude * _grown(apart, time)
        return np.asarray(own + grown @ np.exp(1j * time * push.rates))

    def through(self, z: Complex, push: Push, times: Array) -> Complex:
        """The solution from z at times, shape (len(times), K)."""
        found = np.exp(np.outer(times, self.d)) * z
        apart = self._apart(push)
        for force, rate in enumerate(push.rates):
            wave = np.exp(1j * rate * times)[:, None] * push.amplitude[:, force]
            found += wave * _grown(apart[:, force], times[:, None])
        return np.asarray(found)

    def window(self, push: Push) -> float:
        """A part of a period of the force, and of the time in which free motions grow."""
        growth = max(float(self.d.real.max()), 0.0)
        return min(_GROWTH / max(growth, _TINY), 1 / max(push.fastest, _TINY))

    def sizes(self, z: Complex, push: Push, window: float) -> Array:
        """The force adds at most min(window, 2 / |d - i nu|) times its amplitude."""
        grown = np.abs(z)
        if push.rates.size:
            apart = np.maximum(np.abs(self._apart(push)), _TINY)
            grown = grown + np.sum(np.abs(push.amplitude) * np.minimum(window, 2 / apart), axis=1)
        if not np.isfinite(window):
            return np.asarray(grown)
        return np.asarray(grown * np.exp(np.maximum(self.d.real, 0.0) * window))

    def bends(self, rows: Complex, sizes: Array, push: Push) -> Array:
        """As z'' = d^2 z + sum_f (d + i nu_f) B_f exp(i nu_f t)."""
        size = np.abs(self.d)
        bend = size**2 * sizes
        if push.rates.size:
            both = size[:, None] + np.abs(push.rates)
            bend = bend + np.sum(both * np.abs(push.amplitude), axis=1)
        return np.asarray(np.abs(rows) @ bend)

    def _apart(self, push: Push) -> Complex:
        return np.asarray(self.d[:, None] - 1j * push.rates)


def _grown(apart: Complex, time: float | Array) -> Complex:
    """The function g(s) for s = `apart`."""
    resonant = apart == 0
    return np.where(resonant, time, np.expm1(time * apart) / np.where(resonant, 1.0, apart))


@dataclass(frozen=True, slots=True)
class Dense:
    """Any real A; z are real numbers.

    Attributes:
        A: In 1/s, shape (K, K).
    """

    A: Array
    _growth: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        growth = float(eigvalsh((self.A + self.A.T) / 2)[-1])
        object.__setattr__(self, "_growth", max(growth, 0.0))

    def carried(self, z: Complex, time: float) -> Complex:
        """exp(A t) z."""
        return np.asarray(expm(time * self.A) @ z)

    def at(self, z: Complex, push: Push, time: float) -> Complex:
        """The solution from z after a time, shape (K,)."""
        if not push.rates.size:
            return self.carried(z, time)
        size, more = len(self.A), len(push.rates)
        whole = np.zeros((size + more, size + more), complex)
        whole[:size, :size], whole[:size, size:] = self.A, push.amplitude
        whole[size:, size:] = np.diag(1j * push.rates)
        after = expm(time * whole)[:size] @ np.concatenate([z, np.ones(more)])
        return np.asarray(after.real)

    def through(self, z: Complex, push: Push, times: Array) -> Complex:
        """The solution from z at times, shape (len(times), K)."""
        found = [self.at(z, push, float(time)) for time in times]
        return np.reshape(np.array(found), (len(times), len(z)))

    def window(self, push: Push) -> float:
        """A part of a period of the force, and of the time in which the energy may grow."""
        return min(_GROWTH / max(self._growth, _TINY), 1 / max(push.fastest, _TINY))

    def sizes(self, z: Complex, push: Push, window: float) -> Array:
        """|z(t)| <= exp(mu t) (|z(0)| + t |B|), mu the largest eigenvalue of (A + A^T) / 2."""
        size = float(np.linalg.norm(z))
        if push.rates.size:
            size += window * float(np.linalg.norm(push.amplitude, axis=0).sum())
        growth = np.exp(self._growth * window) if self._growth else 1.0
        return np.full(len(self.A), size * growth)

    def bends(self, rows: Complex, sizes: Array, push: Push) -> Array:
        """As rows z'' = rows A^2 z + sum_f rows (A + i nu_f) B_f exp(i nu_f t)."""
        once = rows @ self.A
        bend = np.linalg.norm(once @ self.A, axis=1) * sizes.max(initial=0.0)
        if push.rates.size:
            pushed = once @ push.amplitude + 1j * (rows @ push.amplitude) * push.rates
            bend = bend + np.abs(pushed).sum(axis=1)
        return np.asarray(bend)
