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
class GaussNodes:
    """Gauss points on [0, 1], and polynomials through values there.

    Attributes:
        at: Points, shape (s,).
        weight: Weights of the integral over [0, 1], shape (s,).
        to_legendre: From values to Legendre coefficients, shape (s, s).
        barycentric: Weights of the barycentric formula, shape (s,).
    """

    at: Array
    weight: Array
    to_legendre: Array
    barycentric: Array

    @classmethod
    def of(cls, count: int) -> GaussNodes:
        """So many points, two or more."""
        x, weight = np.polynomial.legendre.leggauss(count)
        degree = np.arange(count)
        P = np.polynomial.legendre.legvander(x, count - 1)
        signs = (-1.0) ** np.arange(count)
        return cls(
            at=(x + 1) / 2,
            weight=weight / 2,
            to_legendre=(P * weight[:, None]).T * (degree[:, None] + 0.5),
            barycentric=signs * np.sqrt((1 - x**2) * weight),
        )

    def basis(self, at: Array) -> Array:
        """Polynomials that are 1 at one of the points, at places of shape (..), shape (.., s).

        By the barycentric formula: J.-P. Berrut, L. N. Trefethen, SIAM Rev. 46 (2004) 501-517.
        """
        apart = at[..., None] - self.at
        parts = self.barycentric / np.where(apart == 0, _TINY, apart)
        return np.asarray(parts / parts.sum(axis=-1, keepdims=True))

    def beyond(self, at: Array, values: Array) -> Array:
        """A guess at values of shape (s, n) at places beyond 1, shape (t,), of shape (t, n)."""
        coefficients = self.to_legendre[:_FIRST_FEW] @ values
        return np.polynomial.legendre.legvander(2 * at - 1, _FIRST_FEW - 1) @ coefficients


@cache
def gauss_nodes(count: int) -> GaussNodes:
    """So many points; they are made once."""
    return GaussNodes.of(count)


@dataclass(frozen=True, slots=True)
class Weights:
    """What values of the remainder at the nodes do to oscillators at some times of a step.

    Attributes:
        nu: Circular frequencies of the oscillators, shape (J,).
        cosine: cos(nu t), shape (J, t).
        sine: sin(nu t), shape (J, t).
        both: Weights of the remainder in x, and below them those in x', shape (J, 2 t, s).
    """

    nu: Array
    cosine: Array
    sine: Array
    both: Array

    @classmethod
    def of(cls, nodes: GaussNodes, nu: Array, step: float, times: Array) -> Weights:
        """At times from 0 to `step`, shape (t,), of oscillators with nu > 0, shape (J,)."""
        longest = float(times.max(initial=0.0))
        inner = gauss_nodes(_POINTS + int(np.ceil(longest * nu[-1] / 2)))
        passed = times[:, None] * inner.at
        basis = nodes.basis(passed / step) * (times[:, None] * inner.weight)[:, :, None]
        angle = nu[:, None] * (times[:, None] - passed)[:, None, :]
        turned = nu[:, None] * times
        both = np.concatenate([np.sin(angle) @ basis / nu[:, None], np.cos(angle) @ basis])
        return cls(nu, np.cos(turned), np.sin(turned), np.ascontiguousarray(both.swapaxes(0, 1)))

    def motion(self, x: Array, rate: Array, remainder: Array) -> tuple[Array, Array]:
        """Coordinates and velocities of a motion, each of shape (J, t).

        Args:
            x: Coordinates at the start, shape (J,).
            rate: Their velocities, shape (J,).
            remainder: Remainder at the nodes, shape (J, s).
        """
        x, rate, nu = x[:, None], rate[:, None], self.nu[:, None]
        pulled = (self.both @ remainder[:, :, None])[:, :, 0]
        count = self.cosine.shape[1]
        return (
            self.cosine * x + self.sine / nu * rate + pulled[:, :count],
            self.cosine * rate - self.sine * nu * x + pulled[:, count:],
        )

    def carried(self, start: Array, directions: Array, pushes: Array) -> tuple[Array, Array]:
        """Changes of coordinates and velocities at the only time, each of shape (J, c).

        Args:
            start: Those at the start, one below the other, shape (2 J, c).
            directions: Directions of the pushes, shape (J, p).
            pushes: Changes of the pushes at the nodes, shape (s, p, c).
        """
        modes, columns = len(self.nu), start.shape[1]
        by_pushes = self.both[:, :, :, None] * directions[:, None, None, :]
        count = pushes.shape[0] * pushes.shape[1]
        pulled = by_pushes.reshape(2 * modes, count) @ pushes.reshape(count, columns)
        x, rate = start[:modes], start[modes:]
        pulled = pulled.reshape(modes, 2, columns)
        return (
            self.cosine * x + self.sine / self.nu[:, None] * rate + pulled[:, 0],
            self.cosine * rate - self.sine * self.nu[:, None] * x + pulled[:, 1],
        )
