"""A small body that bends far, with its polynomial potential known in full: M = 1, K diagonal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder, symmetrised


@dataclass(frozen=True, slots=True)
class BentBody:
    """V = 1/2 u K u + f2 u u u / 6 + f3 u u u u / 24, unit vectors as modes.

    Attributes:
        omega: Natural frequencies, shape (n,).
        f2: Second derivative of the internal force at rest, symmetric, shape (n, n, n).
        f3: Third one, shape (n, n, n, n).
        B: Contact rows, shape (n_c, n).
    """

    omega: Array
    f2: Array
    f3: Array
    B: Array

    @classmethod
    def random(cls, size: int, points: int, seed: int) -> BentBody:
        """A body with random terms."""
        rng = np.random.default_rng(seed)
        omega = np.cumsum(rng.uniform(0.8, 2.0, size))
        f2, f3 = rng.normal(size=(size,) * 3), rng.normal(size=(size,) * 4)
        B = rng.normal(size=(points, size))
        return cls(omega, symmetrised(f2), symmetrised(f3), B)

    def potential(self, u: Array) -> float:
        """V of a displacement."""
        quadratic = np.sum((self.omega * u) ** 2) / 2
        cubic = np.einsum("ijk,i,j,k->", self.f2, u, u, u) / 6
        return float(quadratic + cubic + np.einsum("ijkl,i,j,k,l->", self.f3, u, u, u, u) / 24)

    def derivatives(self, masters: Indices) -> Array:
        """Static modal derivatives theta_jk free of masters, shape (n, k, k)."""
        theta = -self.f2[:, masters[:, None], masters] / self.omega[:, None, None] ** 2
        theta[masters] = 0.0
        return theta

    def model(self, modes: int, masters: Indices) -> ReducedModel:
        """The reduced model with second-order kinematics, all gaps 1."""
        B, omega, theta = self.B[:, :modes], self.omega[:modes], self.derivatives(masters)
        flexible = self.B[:, modes:] / self.omega[modes:]
        whole = ReducedModel(omega, B, flexible @ flexible.T, np.ones(len(B)))
        cubic = self.f3[np.ix_(masters, masters, masters, masters)] / 6
        coupled = np.einsum("ija,akl->ijkl", self.f2[masters[:, None], masters], theta) / 2
        record = SecondOrder(
            masters=masters,
            Theta=np.einsum("cn,njk->cjk", self.B, theta),
            alpha=self.f2[:modes][:, masters[:, None], masters] / 2,
            beta=cubic + symmetrised(coupled),
            D=np.einsum("nij,nkl->ijkl", theta, theta),
        )
        return ReducedModel(
            omega, B, whole.R, whole.gap, kinematics=record.apart(whole, theta[:modes])
        )
