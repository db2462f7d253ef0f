r"""What second-order kinematics add to the linear motion of a stage, by few numbers.

While the points in contact stay the same, contact forces are polynomials of the coordinates and
join the stiffness of the kinematics. With t_c = 1/2 q^T Theta_c q and masters j, k, l

    lambda = R_AA^-1 (Phi q - gap + t),     alpha_A = alpha + 1/2 Phi^T R_AA^-1 Theta,
    g_jk = 2 sum_a alpha_ajk q_a + Theta_jk . R_AA^-1 (Phi q - gap),     a: no master,
    beta_A = beta + 1/2 Theta R_AA^-1 Theta, made symmetric.

So the remainder n of q'' = -K_A (q - rest) + n sees few linear functions of the state,
y = (q_j, w_j = (K_A (q - rest))_j, g_jk, q'_j), and pushes along few directions, by u:

    n_a = -alpha_A,ajk q_j q_k,        n_i = w_i - M_ij^-1 (w_j + F_j),        u = (q_j q_k, n_i),
    F_i = alpha_A,ijk q_j q_k + (g_ij + beta_A,ijkl q_k q_l + D_ijkl q'_k q'_l) q_j.

Pairs of masters j <= k stand for both orders.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import symmetrised
from fenics_nnm.time_domain.linear_stage import LinearStage
from fenics_nnm.time_domain.master_pairs import MasterPairs, tensors_of


@dataclass(frozen=True, slots=True)
class _Tensors:
    """Tensors that act on products of pairs, of k masters and P pairs.

    Attributes:
        alpha: alpha_A of the masters, shape (k, k, k).
        quadratic: The same for products of positions, shape (P, k).
        cubic: beta_A for products of positions, to matrices by pairs, shape (P, P).
        centrifugal: D for products of velocities, to matrices by pairs, shape (P, P).
        mass: D for products of positions, to M - 1 by pairs, shape (P, P).
        D: Shape (k, k, k, k).
    """

    alpha: Array
    quadratic: Array
    cubic: Array
    centrifugal: Array
    mass: Array
    D: Array

    @classmethod
    def of(cls, pairs: MasterPairs, alpha: Array, beta: Array, D: Array) -> _Tensors:
        """Those of alpha_A and beta_A of the masters, and D."""
        at = pairs.first, pairs.second
        turned = D.transpose(0, 2, 1, 3)  # M_ij = D_ikjl q_k q_l
        return cls(
            alpha=alpha,
            quadratic=pairs.weighted(alpha).T,
            cubic=pairs.weighted(beta)[at].T,
            centrifugal=pairs.weighted(D)[at].T,
            mass=pairs.weighted(turned)[at].T,
            D=D,
        )


@dataclass(frozen=True, slots=True)
class Remainder:
    """The remainder of a stage, in its own coordinates x, q = rest + V x.

    Attributes:
        pairs: Pairs of masters.
        position: What is seen of x: q_j, w_j and g, shape (2 k + P, J).
        offset: The same at x = 0, shape (2 k + P,).
        rate: What is seen of x': q'_j, shape (k, J).
        directions: Directions of the pushes, as columns, shape (J, P + k).
    """

    pairs: MasterPairs
    position: Array
    offset: Array
    rate: Array
    directions: Array
    _unit: Array
    _tensors: _Tensors

    @classmethod
    def of(cls, model: ReducedModel, linear: LinearStage, give: Array) -> Remainder:
        """The remainder of a stage.

        Args:
            model: Reduced model.
            linear: The stage with linear kinematics.
            give: R_AA^-1, zero rows and columns for open points, shape (n_c, n_c).
        """
        masters, V = model.kinematics.masters, linear.V
        k, pairs = len(masters), MasterPairs.of(len(masters))
        Theta, alpha, beta, D = tensors_of(model)
        coupled = alpha.copy()
        coupled[masters] = 0.0
        pulled = give @ model.Phi
        alpha = alpha + np.tensordot(pulled, Theta, (0, 0)) / 2
        given = np.tensordot(give, Theta, 1)
        beta = beta + symmetrised(np.tensordot(Theta, given, (0, 0))) / 2
        g = (2 * coupled + np.tensordot(pulled, Theta, (0, 0)))[:, pairs.first, pairs.second].T
        of_gap = np.tensordot(give @ model.gap, Theta, 1)[pairs.first, pairs.second]
        push = np.zeros((model.modes, pairs.count + k))
        push[:, : pairs.count] = -pairs.weighted(alpha)
        push[masters] = 0.0
        push[masters, pairs.count + np.arange(k)] = 1.0
        return cls(
            pairs=pairs,
            position=np.concatenate([V[masters], V[masters] * linear.nu**2, g @ V]),
            offset=np.concatenate([linear.rest[masters], np.zeros(k), g @ linear.rest - of_gap]),
            rate=V[masters],
            directions=V.T @ push,
            _unit=np.where(pairs.first == pairs.second, 1.0, 0.0),
            _tensors=_Tensors.of(pairs, alpha[masters], beta, D),
        )

    @property
    def seen(self) -> int:
        """How many numbers it sees of a state, 3 k + P."""
        return len(self.position) + len(self.rate)

    @property
    def pushes(self) -> int:
        """How many numbers it pushes by, P + k."""
        return self.directions.shape[1]

    def __call__(self, seen: Array) -> Array:
        """U of what is seen at states, (s, 3 k + P), shape (s, P + k)."""
        q, w, g, velocity = self._parts(seen)
        products = self.pairs.monomials(q)
        accelerated = self._accelerated(q, w, products, self._inner(g, products, velocity))
        return np.concatenate([products, w - accelerated], axis=1)

    def slopes(self, seen: Array) -> Array:
        """Derivatives of u by what is seen, shape (s, P + k, 3 k + P)."""
        q, w, g, velocity = self._parts(seen)
        tensors, pairs, k = self._tensors, self.pairs, q.shape[1]
        products = pairs.monomials(q)
        inner = self._inner(g, products, velocity)
        a = self._accelerated(q, w, products, inner)
        by_q = 2 * np.tensordot(q, tensors.alpha, (1, 2))
        by_q += pairs.matrices(inner + 2 * products @ tensors.cubic)
        by_q -= _by_two(tensors.D, a, q, (2, 3, 0, 1)) + _by_two(tensors.D, q, a, (1, 2, 0, 3))
        by_velocity = 2 * _by_two(tensors.D, q, velocity, (1, 2, 0, 3))
        unit = np.tile(np.eye(k), (len(q), 1, 1))
        forced = np.concatenate([unit, by_q, pairs.matrix_slopes(q), by_velocity], axis=2)
        solved = self._over_mass(products, forced)
        found = np.zeros((len(q), self.pushes, self.seen))
        found[:, : pairs.count, :k] = pairs.product_slopes(q)
        below = found[:, pairs.count :]
        below[:, :, :k] = -solved[:, :, k : 2 * k]
        below[:, :, k : 2 * k] = np.eye(k) - solved[:, :, :k]
        below[:, :, 2 * k :] = -solved[:, :, 2 * k :]
        return found

    def _parts(self, seen: Array) -> tuple[Array, Array, Array, Array]:
        """Positions, w, g and velocities."""
        k, P = len(self.rate), self.pairs.count
        return seen[:, :k], seen[:, k : 2 * k], seen[:, 2 * k : 2 * k + P], seen[:, 2 * k + P :]

    def _inner(self, g: Array, products: Array, velocity: Array) -> Array:
        """What multiplies positions in F, by pairs, shape (s, P)."""
        squares = self.pairs.monomials(velocity)
        return g + products @ self._tensors.cubic + squares @ self._tensors.centrifugal

    def _accelerated(self, q: Array, w: Array, products: Array, inner: Array) -> Array:
        """M^-1 (w + F), shape (s, k)."""
        forced = (self.pairs.matrices(inner) @ q[:, :, None])[:, :, 0]
        forced += w
        forced += products @ self._tensors.quadratic
        return self._over_mass(products, forced[:, :, None])[:, :, 0]

    def _over_mass(self, products: Array, right: Array) -> Array:
        """M^-1 times columns (s, k, c)."""
        return _solved(self.pairs.matrices(products @ self._tensors.mass + self._unit), right)


def _solved(matrices: Array, right: Array) -> Array:
    """Products of inverses of symmetric matrices (s, k, k) with columns (s, k, c)."""
    k = matrices.shape[1]
    if k == 1:
        return np.asarray(right / matrices)
    if k != 2:
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
