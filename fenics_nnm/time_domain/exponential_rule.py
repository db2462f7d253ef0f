r"""Collocation for oscillators with a smooth remainder: x'' + nu^2 x = f(t), exact in nu.

On a step of length h the remainder is the polynomial through its values at the s Gauss points, and
variation of constants gives, for each oscillator,

    x(t) = cos(nu t) x_0 + sin(nu t) / nu x'_0 + int_0^t sin(nu (t - r)) / nu f(r) dr.

So a step is as long as the remainder is smooth, however fast the oscillators are; where these are
slow it is the Gauss method of order 2 s. M. Hochbruck, A. Ostermann, Acta Numerica 19 (2010)
209-286, section 2.2, for exponential collocation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from fenics_nnm.arrays import Array

#: Legendre coefficients that a guess beyond a step is made of; higher ones grow too fast there.
_FIRST_FEW = 7

_TINY = float(np.finfo(float).tiny)

#: Gauss points of the integrals, besides half the angle that the fastest oscillator turns by.
_POINTS = 16


@dataclass(frozen=True, slots=True)
class GaussPoints:
    """Gauss points on [0, 1].

    Attributes:
        at: Points, shape (s,).
        weight: Weights of the integral over [0, 1], shape (s,).
    """

    at: Array
    weight: Array


@dataclass(frozen=True, slots=True)
class GaussNodes:
    """Gauss points on [0, 1], and polynomials through values there.

    Attributes:
        at: Points, shape (s,).
        to_legendre: From values to Legendre coefficients, shape (s, s).
        barycentric: Weights of the barycentric formula, shape (s,).
        first_few: From values to a polynomial of lower degree, in powers of the place, that has
            the same first Legendre coefficients, shape (min(7, s), s).
    """

    at: Array
    to_legendre: Array
    barycentric: Array
    first_few: Array

    @classmethod
    def of(cls, count: int) -> GaussNodes:
        """So many points, two or more."""
        x, weight = np.polynomial.legendre.leggauss(count)
        degree = np.arange(count)
        P = np.polynomial.legendre.legvander(x, count - 1)
        signs = (-1.0) ** np.arange(count)
        to_legendre = (P * weight[:, None]).T * (degree[:, None] + 0.5)
        return cls(
            at=(x + 1) / 2,
            to_legendre=to_legendre,
            barycentric=signs * np.sqrt((1 - x**2) * weight),
            first_few=_powers(min(_FIRST_FEW, count)) @ to_legendre[:_FIRST_FEW],
        )

    @property
    def weight(self) -> Array:
        """Weights of Gauss' rule, shape (s,)."""
        return self.to_legendre[0]

    def basis(self, at: Array) -> Array:
        """Polynomials that are 1 at one of the points, at places of shape (..), shape (.., s).

        By the barycentric formula: J.-P. Berrut, L. N. Trefethen, SIAM Rev. 46 (2004) 501-517.
        """
        apart = at[..., None] - self.at
        parts = self.barycentric / np.where(apart == 0, _TINY, apart)
        return np.asarray(parts / parts.sum(axis=-1, keepdims=True))

    def beyond(self, at: Array, values: Array) -> Array:
        """A guess at values of shape (n, s) at places beyond 1, shape (t,), of shape (n, t)."""
        return np.asarray(
            values @ self.first_few.T @ (at ** np.arange(len(self.first_few))[:, None])
        )


def _powers(count: int) -> Array:
    """Coefficients of powers of t, rows, of the Legendre polynomials of 2 t - 1."""
    shifted = np.polynomial.Polynomial([-1.0, 2.0])
    columns = np.zeros((count, count))
    for degree in range(count):
        power = np.polynomial.legendre.Legendre.basis(degree).convert(kind=np.polynomial.Polynomial)
        columns[: degree + 1, degree] = power(shifted).coef
    return columns


@cache
def gauss_points(count: int) -> GaussPoints:
    """So many points; they are made once."""
    x, weight = np.polynomial.legendre.leggauss(count)
    return GaussPoints((x + 1) / 2, weight / 2)


@cache
def gauss_nodes(count: int) -> GaussNodes:
    """So many points; they are made once."""
    return GaussNodes.of(count)


@dataclass(frozen=True, slots=True)
class Weights:
    """What values of the remainder at the nodes do to oscillators at some times of a step.

    Coordinates at the times come first, then velocities.

    Attributes:
        by_x: By coordinates at the start: cos(nu t) and -nu sin(nu t), shape (J, 2 t).
        by_rate: By velocities there: sin(nu t) / nu and cos(nu t), shape (J, 2 t).
        both: By values of the remainder, shape (J, 2 t, s).
    """

    by_x: Array
    by_rate: Array
    both: Array

    @classmethod
    def of(cls, nodes: GaussNodes, nu: Array, step: float, times: Array) -> Weights:
        """At times from 0 to `step`, shape (t,), of oscillators with nu > 0, shape (J,)."""
        longest = float(times.max(initial=0.0))
        inner = gauss_points(_POINTS + int(np.ceil(longest * nu[-1] / 2)))
        passed = times[:, None] * inner.at
        basis = nodes.basis(passed / step) * (times[:, None] * inner.weight)[:, :, None]
        angle = nu[:, None] * (times[:, None] - passed)[:, None, :]
        both = np.concatenate([np.sin(angle) @ basis / nu[:, None], np.cos(angle) @ basis])
        frequency = nu[:, None]
        turned = frequency * times
        cosine, sine = np.cos(turned), np.sin(turned)
        return cls(
            by_x=np.concatenate([cosine, -frequency * sine], axis=1),
            by_rate=np.concatenate([sine / frequency, cosine], axis=1),
            both=np.ascontiguousarray(both.swapaxes(0, 1)),
        )

    def motion(self, x: Array, rate: Array, remainder: Array) -> Array:
        """Coordinates and, beside them, velocities of a motion, shape (J, 2 t).

        Args:
            x: Coordinates at the start, shape (J,).
            rate: Their velocities, shape (J,).
            remainder: Remainder at the nodes, shape (J, s).
        """
        moved = (self.both @ remainder[:, :, None])[:, :, 0]
        moved += self.by_x * x[:, None]
        moved += self.by_rate * rate[:, None]
        return np.asarray(moved)

    @property
    def by_start(self) -> Array:
        """Coordinates and, below, velocities at the only time by those before, (2 J, 2 J)."""
        columns = [[np.diag(at) for at in each.T] for each in (self.by_x, self.by_rate)]
        return np.block([list(rows) for rows in zip(*columns, strict=True)])

    def by_pushes(self, directions: Array) -> Array:
        """The same by pushes at the nodes, along directions of shape (J, p), (2 J, p s)."""
        by_pushes = self.both.swapaxes(0, 1)[:, :, None] * directions[:, :, None]
        return by_pushes.reshape(2 * len(directions), -1)

    def carried(self, start: Array, directions: Array, pushes: Array) -> Array:
        """Changes of coordinates and, below, velocities at the only time, shape (2 J, c).

        Args:
            start: Those at the start, shape (2 J, c).
            directions: Directions of the pushes, shape (J, p).
            pushes: Changes of the pushes at the nodes, shape (p s, c).
        """
        x, rate = np.split(start, 2)
        moved = (self.by_pushes(directions) @ pushes).reshape(2, *x.shape)
        moved += self.by_x.T[:, :, None] * x
        moved += self.by_rate.T[:, :, None] * rate
        return moved.reshape(start.shape)
