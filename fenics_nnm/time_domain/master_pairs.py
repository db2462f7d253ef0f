"""Pairs of masters, over which tensors of second-order kinematics are summed once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.pairs import Pairs


@dataclass(frozen=True, slots=True)
class MasterPairs(Pairs):
    """Pairs j <= k of k masters, P of them."""

    @property
    def count(self) -> int:
        """Number of pairs."""
        return len(self.first)

    def monomials(self, q: Array) -> Array:
        """Products of masters (k, ..), shape (P, ..)."""
        if self.count == 1:
            return q * q
        return np.asarray(q[self.first] * q[self.second])

    def product_slopes(self, q: Array) -> Array:
        """Their derivatives by the masters, shape (s, P, k)."""
        slopes, at = np.zeros((len(q), self.count, q.shape[1])), np.arange(self.count)
        slopes[:, at, self.first] = q[:, self.second]
        slopes[:, at, self.second] += q[:, self.first]
        return slopes

    def matrix_slopes(self, q: Array) -> Array:
        """Derivatives of matrices times q, (s, k), by the values of pairs, shape (s, k, P)."""
        slopes, at = np.zeros((len(q), q.shape[1], self.count)), np.arange(self.count)
        slopes[:, self.first, at] = q[:, self.second]
        slopes[:, self.second, at] = q[:, self.first]
        return slopes

    def weighted(self, tensor: Array) -> Array:
        """Tensor whose last two indices run over pairs, for products: T_jk + T_kj, (.., P)."""
        both = tensor[..., self.first, self.second] + tensor[..., self.second, self.first]
        return np.asarray(np.where(self.first == self.second, both / 2, both))

    def product_rates(self, q: Array, velocity: Array) -> Array:
        """Rates of products of masters (k, ..) that move, shape (P, ..)."""
        if self.count == 1:
            return 2 * q * velocity
        first, second = self.first, self.second
        return np.asarray(q[first] * velocity[second] + velocity[first] * q[second])

    def matrices(self, values: Array) -> Array:
        """Symmetric matrices of values of pairs (s, P), shape (s, k, k)."""
        return np.asarray(values[:, self.place])


def tensors_of(model: ReducedModel) -> tuple[Array, Array, Array, Array]:
    """Theta, alpha, beta and D of the kinematics of a model, empty where they have no masters."""
    known, (points, modes) = model.kinematics.tensors, model.Phi.shape
    k = len(model.kinematics.masters)
    sizes = {"Theta": (points, k, k), "alpha": (modes, k, k), "beta": (k,) * 4, "D": (k,) * 4}
    Theta, alpha, beta, D = (known.get(name, np.zeros(size)) for name, size in sizes.items())
    return Theta, alpha, beta, D
