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
from fenics_nnm.time_domain.master_pushes import Pushes, pushes_of


@dataclass(frozen=True, slots=True)
class Remainder:
    """The remainder of a stage, in its own coordinates x, q = rest + V x.

    Attributes:
        pairs: Pairs of masters.
        position: What is seen of x: q_j, w_j and g, shape (2 k + P, J).
        offset: The same at x = 0, shape (2 k + P,).
        rate: What is seen of x': q'_j, shape (k, J).
        directions: Directions of the pushes, as columns, shape (J, P + k).
        reach: Largest entry of each of these, shape (P + k,).
    """

    pairs: MasterPairs
    position: Array
    offset: Array
    rate: Array
    directions: Array
    reach: Array
    _pushes: Pushes

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
        directions = V.T @ push
        return cls(
            pairs=pairs,
            position=np.concatenate([V[masters], V[masters] * linear.nu**2, g @ V]),
            offset=np.concatenate([linear.rest[masters], np.zeros(k), g @ linear.rest - of_gap]),
            rate=V[masters],
            directions=directions,
            reach=np.abs(directions).max(axis=0),
            _pushes=pushes_of(pairs, alpha[masters], beta, D),
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
        """U of what is seen at states, (3 k + P, s), shape (P + k, s)."""
        return self._pushes.at(seen)

    def slopes(self, seen: Array) -> Array:
        """Derivatives of u by what is seen, shape (s, P + k, 3 k + P)."""
        return self._pushes.slopes(seen)
