"""What the remainder of a smooth stage pushes by, from what it sees; see `remainder`.

There q_j, w_j, g_jk and q'_j are seen, and u = (q_j q_k, n_i) with n = w - M^-1 (w + F) is pushed
by. Arrays have a row for each of these numbers and a column for each state.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.master_pairs import MasterPairs


class Pushes(Protocol):
    """U of the remainder, with k masters and P pairs of them."""

    def at(self, seen: Array) -> Array:
        """U at states of which (3 k + P, s) is seen, shape (P + k, s)."""

    def slopes(self, seen: Array) -> Array:
        """Derivatives of u by what is seen, shape (s, P + k, 3 k + P)."""


def pushes_of(pairs: MasterPairs, alpha: Array, beta: Array, D: Array) -> Pushes:
    """Those of alpha_A and beta_A of the masters, and of D."""
    if pairs.count == 1:
        return OneMaster(float(alpha.item()), float(beta.item()), float(D.item()))
    return Masters.of(pairs, alpha, beta, D)


@dataclass(frozen=True, slots=True)
class OneMaster:
    """Of one master: n = q (q (D w - alpha - beta q) - g - D q'^2) / M with M = 1 + D q^2.

    Attributes:
        alpha: alpha_A.
        beta: beta_A.
        D: Inertia of the second-order displacement.
    """

    alpha: float
    beta: float
    D: float

    def at(self, seen: Array) -> Array:
        """U at states of which (4, s) is seen, shape (2, s)."""
        q, w, g, velocity = seen
        found = np.empty((2, len(q)))
        square = np.multiply(q, q, out=found[0])
        pushed = self.D * w
        pushed -= self.beta * q
        pushed -= self.alpha
        pushed *= q
        pushed -= g
        squared = velocity * velocity
        squared *= self.D
        pushed -= squared
        pushed *= q
        mass = self.D * square
        mass += 1
        np.divide(pushed, mass, out=found[1])
        return found

    def slopes(self, seen: Array) -> Array:
        """Derivatives of u by what is seen, shape (s, 2, 4)."""
        q, w, g, velocity = seen
        turned = self.D * velocity
        along = (2 * (self.D * w - self.alpha) - 3 * self.beta * q) * q - g - turned * velocity
        mass, n = self.D * (q * q) + 1, self.at(seen)[1]
        found = np.zeros((len(q), 2, 4))
        found[:, 0, 0] = 2 * q
        found[:, 1, 0] = (along - 2 * self.D * q * n) / mass
        found[:, 1, 1] = self.D * (q * q) / mass
        found[:, 1, 2] = -q / mass
        found[:, 1, 3] = -2 * q * turned / mass
        return found


@dataclass(frozen=True, slots=True)
class Masters:
    """Of any number of masters.

    Attributes:
        pairs: Pairs of masters.
        alpha: alpha_A of the masters, shape (k, k, k).
        D: Shape (k, k, k, k).
        by_products: beta_A and, beside it, D for products of positions, then of velocities, to
            matrices by pairs, shape (P, 2 P).
        quadratic: alpha_A for products of positions, shape (k, P).
        mass: D for products of positions, to M - 1 by pairs, shape (P, P).
    """

    pairs: MasterPairs
    alpha: Array
    D: Array
    by_products: Array
    quadratic: Array
    mass: Array

    @classmethod
    def of(cls, pairs: MasterPairs, alpha: Array, beta: Array, D: Array) -> Masters:
        """Those of alpha_A and beta_A of the masters, and of D."""
        at = pairs.first, pairs.second
        turned = D.transpose(0, 2, 1, 3)  # M_ij = D_ikjl q_k q_l
        return cls(
            pairs=pairs,
            alpha=alpha,
            D=D,
            by_products=np.hstack([pairs.weighted(beta)[at], pairs.weighted(D)[at]]),
            quadratic=pairs.weighted(alpha),
            mass=pairs.weighted(turned)[at],
        )

    def at(self, seen: Array) -> Array:
        """U at states of which (3 k + P, s) is seen, shape (P + k, s)."""
        q, w, g, velocity = self._parts(seen)
        products, inner = self._inner(q, g, velocity)
        found = np.empty((len(products) + len(q), seen.shape[1]))
        found[: len(products)] = products
        found[len(products) :] = w - self._accelerated(q, w, products, inner)
        return found

    def slopes(self, seen: Array) -> Array:
        """Derivatives of u by what is seen, shape (s, P + k, 3 k + P)."""
        q, w, g, velocity = self._parts(seen)
        products, inner = self._inner(q, g, velocity)
        a = self._accelerated(q, w, products, inner).T
        q, velocity, (k, P) = q.T, velocity.T, (len(q), self.pairs.count)
        forced = np.concatenate(
            [
                np.tile(np.eye(k), (len(q), 1, 1)),
                self._forced_by_position(q, a, products.T, inner.T),
                self.pairs.matrix_slopes(q),
                2 * _by_two(self.D, q, velocity, (1, 2, 0, 3)),
            ],
            axis=2,
        )
        solved = self._over_mass(products, forced)
        found = np.zeros((len(q), P + k, len(seen)))
        found[:, :P, :k] = self.pairs.product_slopes(q)
        below = found[:, P:]
        below[:, :, :k] = -solved[:, :, k : 2 * k]
        below[:, :, k : 2 * k] = np.eye(k) - solved[:, :, :k]
        below[:, :, 2 * k :] = -solved[:, :, 2 * k :]
        return found

    def _parts(self, seen: Array) -> tuple[Array, Array, Array, Array]:
        """Positions, w, g and velocities."""
        k, P = len(self.D), self.pairs.count
        return seen[:k], seen[k : 2 * k], seen[2 * k : 2 * k + P], seen[2 * k + P :]

    def _inner(self, q: Array, g: Array, velocity: Array) -> tuple[Array, Array]:
        """Products of positions, and what multiplies positions in F by pairs, each (P, s)."""
        first, second = self.pairs.first, self.pairs.second
        products, squares = q[first] * q[second], velocity[first] * velocity[second]
        return products, g + self.by_products @ np.concatenate([products, squares])

    def _accelerated(self, q: Array, w: Array, products: Array, inner: Array) -> Array:
        """M^-1 (w + F), shape (k, s)."""
        forced = (inner[self.pairs.place] * q).sum(axis=1)
        forced += w
        forced += self.quadratic @ products
        return self._over_mass(products, forced.T[:, :, None])[:, :, 0].T

    def _forced_by_position(self, q: Array, a: Array, products: Array, inner: Array) -> Array:
        """Derivatives of F + (1 - M) a by positions, a held, shape (s, k, k)."""
        bent = inner + 2 * products @ self.by_products[:, : self.pairs.count].T
        by_q = 2 * np.tensordot(q, self.alpha, (1, 2)) + self.pairs.matrices(bent)
        return by_q - _by_two(self.D, a, q, (2, 3, 0, 1)) - _by_two(self.D, q, a, (1, 2, 0, 3))

    def _over_mass(self, products: Array, right: Array) -> Array:
        """M^-1 times columns (s, k, c), products of shape (P, s)."""
        added = (self.mass @ products)[self.pairs.place]
        return _solved(added.transpose(2, 0, 1) + np.eye(len(self.D)), right)


def _solved(matrices: Array, right: Array) -> Array:
    """Products of inverses of symmetric matrices (s, k, k) with columns (s, k, c)."""
    if matrices.shape[1] != 2:
        return np.linalg.solve(matrices, right)
    (first, mixed), (_, second) = matrices.transpose(1, 2, 0)[..., None]
    turned = np.stack(
        [second * right[:, 0] - mixed * right[:, 1], first * right[:, 1] - mixed * right[:, 0]],
        axis=1,
    )
    return np.asarray(turned / (first * second - mixed**2)[:, None])


def _by_two(D: Array, one: Array, other: Array, order: tuple[int, int, int, int]) -> Array:
    """Sums of D, its indices in an order, over x_a y_b of vectors (s, k), shape (s, k, k)."""
    k, states = len(D), len(one)
    pairs = (one[:, :, None] * other[:, None, :]).reshape(states, k**2)
    return (pairs @ D.transpose(order).reshape(k**2, k**2)).reshape(states, k, k)
