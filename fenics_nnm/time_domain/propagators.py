r"""Exact solutions of z' = A z + sum_f B_f exp(i nu_f t), resonant ones among them.

With A = diag(d), each component by itself is

    z(t) = exp(d t) z(0) + sum_f B_f exp(i nu_f t) g(d - i nu_f),      g(s) = (exp(s t) - 1) / s,

where g = t at s = 0: growth in resonance without damping is no special case. Where A has no
well-conditioned basis of eigenvectors, as at critical damping, the exponential of the matrix

    [[A, B], [0, diag(i nu)]]

gives the same.

So that no change of contact is missed, a course also bounds |z_k| for a window of time.
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

    def window(self, growth: float) -> float:
        """A part of a period of the force, and of the time in which free motions grow."""
        return min(_GROWTH / max(growth, _TINY), 1 / max(self.fastest, _TINY))


class Course(Protocol):
    """One solution."""

    @property
    def start(self) -> Complex:
        """The solution at first, shape (K,)."""

    @property
    def push(self) -> Push:
        """The inhomogeneous part."""

    @property
    def window(self) -> float:
        """For how long `sizes` bounds it."""

    def at(self, time: float) -> Complex:
        """The solution after a time, shape (K,)."""

    def through(self, times: Array) -> Complex:
        """The solution at times, shape (len(times), K)."""

    def sizes(self, z: Complex) -> Array:
        """Bounds of |z_k| for the window that begins at z, shape (K,)."""

    def bends(self, rows: Complex) -> tuple[Array, Array]:
        """What bounds |(rows z)''| by M sizes + c: the matrix M and the vector c."""


class Propagator(Protocol):
    """Solutions for a matrix A of size K."""

    @property
    def exponents(self) -> Complex:
        """Eigenvalues of A that each component has by itself, shape (K,); none where A is dense."""

    def carried(self, z: Complex, time: float) -> Complex:
        """exp(A t) z, shape of z, (K,) or (K, c)."""

    def gathered(self, rows: Complex, times: Array) -> Complex:
        """sum_k rows_k exp(A t_k), shape (K,), of rows of shape (g, K) at times of shape (g,)."""

    def course(self, z: Complex, push: Push) -> Course:
        """The solution from z."""


@dataclass(frozen=True, slots=True)
class Diagonal:
    """A = diag(d).

    Attributes:
        d: Eigenvalues in 1/s, shape (K,).
    """

    d: Complex

    @property
    def exponents(self) -> Complex:
        """The diagonal."""
        return self.d

    def carried(self, z: Complex, time: float) -> Complex:
        """exp(A t) z."""
        return np.asarray((np.exp(time * self.d) * z.T).T)

    def gathered(self, rows: Complex, times: Array) -> Complex:
        """sum_k rows_k exp(A t_k)."""
        return np.asarray(np.sum(rows * np.exp(np.outer(times, self.d)), axis=0))

    def course(self, z: Complex, push: Push) -> DiagonalCourse:
        """The solution from z."""
        return DiagonalCourse.of(self.d, z, push)


@dataclass(frozen=True, slots=True)
class DiagonalCourse:
    """A solution for A = diag(d).

    Attributes:
        d: Eigenvalues in 1/s, shape (K,).
        start: The solution at first, shape (K,).
        push: The force.
        apart: d - i nu, shape (K, F).
        window: For how long `sizes` bounds it in s.
        pushed: Bounds of what the force adds in a window, shape (K,).
        growth: Bounds of the growth of free motions in a window, shape (K,).
    """

    d: Complex
    start: Complex
    push: Push
    apart: Complex
    window: float
    pushed: Array
    growth: Array

    @classmethod
    def of(cls, d: Complex, start: Complex, push: Push) -> DiagonalCourse:
        """The solution from `start`; a force adds at most min(window, 2 / |d - i nu|) |B|."""
        rising = np.maximum(d.real, 0.0)
        window = push.window(float(rising.max()))
        apart = d[:, None] - 1j * push.rates
        longest = np.minimum(window, 2 / np.maximum(np.abs(apart), _TINY))
        pushed = np.sum(np.abs(push.amplitude) * longest, axis=1)
        growth = np.exp(rising * window) if rising.any() else np.ones(len(d))
        return cls(d, start, push, apart, window, pushed, growth)

    def at(self, time: float) -> Complex:
        """The solution after a time, shape (K,)."""
        own = np.exp(time * self.d) * self.start
        if not self.push.rates.size:
            return np.asarray(own)
        grown = self.push.amplitude * _grown(self.apart, time)
        return np.asarray(own + grown @ np.exp(1j * time * self.push.rates))

    def through(self, times: Array) -> Complex:
        """The solution at times, shape (len(times), K)."""
        found = np.exp(np.outer(times, self.d)) * self.start
        for force, rate in enumerate(self.push.rates):
            wave = np.exp(1j * rate * times)[:, None] * self.push.amplitude[:, force]
            found += wave * _grown(self.apart[:, force], times[:, None])
        return np.asarray(found)

    def sizes(self, z: Complex) -> Array:
        """Bounds of |z_k| for the window that begins at z, shape (K,)."""
        return np.asarray((np.abs(z) + self.pushed) * self.growth)

    def bends(self, rows: Complex) -> tuple[Array, Array]:
        """As z'' = d^2 z + sum_f (d + i nu_f) B_f exp(i nu_f t)."""
        size, sizes = np.abs(rows), np.abs(self.d)
        both = sizes[:, None] + np.abs(self.push.rates)
        return size * sizes**2, size @ np.sum(both * np.abs(self.push.amplitude), axis=1)


def _grown(apart: Complex, time: float | Array) -> Complex:
    """The function g(s) for s = `apart`."""
    resonant = apart == 0
    if not resonant.any():
        return np.asarray(np.expm1(time * apart) / apart)
    return np.where(resonant, time, np.expm1(time * apart) / np.where(resonant, 1.0, apart))


@dataclass(frozen=True, slots=True)
class Dense:
    """Any real A; z are real numbers.

    Attributes:
        A: In 1/s, shape (K, K).
    """

    A: Array
    growth: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        growth = float(eigvalsh((self.A + self.A.T) / 2)[-1])
        object.__setattr__(self, "growth", max(growth, 0.0))

    @property
    def exponents(self) -> Complex:
        """None: components do not move by themselves."""
        return np.empty(0, complex)

    def carried(self, z: Complex, time: float) -> Complex:
        """exp(A t) z."""
        return np.asarray(expm(time * self.A) @ z)

    def gathered(self, rows: Complex, times: Array) -> Complex:
        """sum_k rows_k exp(A t_k)."""
        found = [row @ expm(time * self.A) for row, time in zip(rows, times, strict=True)]
        return np.asarray(np.sum(found, axis=0))

    def course(self, z: Complex, push: Push) -> DenseCourse:
        """The solution from z."""
        return DenseCourse(self, z, push)


@dataclass(frozen=True, slots=True)
class DenseCourse:
    """A solution for any real A.

    Attributes:
        propagator: Propagator of A.
        start: The solution at first, shape (K,).
        push: The force.
    """

    propagator: Dense
    start: Complex
    push: Push

    @property
    def window(self) -> float:
        """For how long `sizes` bounds it in s."""
        return self.push.window(self.propagator.growth)

    def at(self, time: float) -> Complex:
        """The solution after a time, shape (K,)."""
        A, push = self.propagator.A, self.push
        size, more = len(A), len(push.rates)
        whole = np.zeros((size + more, size + more), complex)
        whole[:size, :size], whole[:size, size:] = A, push.amplitude
        whole[size:, size:] = np.diag(1j * push.rates)
        after = expm(time * whole)[:size] @ np.concatenate([self.start, np.ones(more)])
        return np.asarray(after.real)

    def through(self, times: Array) -> Complex:
        """The solution at times, shape (len(times), K)."""
        found = [self.at(float(time)) for time in times]
        return np.reshape(np.array(found), (len(times), len(self.start)))

    def sizes(self, z: Complex) -> Array:
        """|z(t)| <= exp(mu t) (|z(0)| + t |B|), mu the largest eigenvalue of (A + A^T) / 2."""
        size, mu = float(np.linalg.norm(z)), self.propagator.growth
        if self.push.rates.size:
            pushed = np.linalg.norm(self.push.amplitude, axis=0).sum()
            size += self.window * float(pushed)
        return np.full(len(z), size * (np.exp(mu * self.window) if mu else 1.0))

    def bends(self, rows: Complex) -> tuple[Array, Array]:
        """As rows z'' = rows A^2 z + sum_f rows (A + i nu_f) B_f exp(i nu_f t)."""
        once = rows @ self.propagator.A
        matrix = np.zeros(rows.shape)
        matrix[:, 0] = np.linalg.norm(once @ self.propagator.A, axis=1)
        pushed = once @ self.push.amplitude + 1j * (rows @ self.push.amplitude) * self.push.rates
        return matrix, np.abs(pushed).sum(axis=1)
