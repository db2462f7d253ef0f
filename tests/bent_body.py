"""A small body that bends far, with its polynomial potential known in full: M = 1, K diagonal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import symmetrised
from fenics_nnm.reduction.modal_derivatives import (
    Deflection,
    by_triples,
    pairwise,
    with_second_order,
)
from fenics_nnm.reduction.operators import Operators
from fenics_nnm.reduction.reduction import Reduction


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

    def second(self, a: Array, b: Array) -> Array:
        """f''[a, b] at rest."""
        return np.einsum("ijk,j,k->i", self.f2, a, b)

    def third(self, a: Array, b: Array, c: Array) -> Array:
        """f'''[a, b, c]."""
        return np.einsum("ijkl,j,k,l->i", self.f3, a, b, c)

    def reduction(self, modes: int, masters: Indices) -> Reduction:
        """The reduction with second-order kinematics, all gaps 1."""
        operators = dense_operators(np.diag(self.omega**2), np.eye(len(self.omega)), self.B)
        shapes, static = np.eye(len(self.omega))[:, :modes], (self.B / self.omega**2).T
        Phi = self.B[:, :modes]
        residual = static - (shapes / self.omega[:modes] ** 2) @ Phi.T
        model = ReducedModel(self.omega[:modes], Phi, self.B @ residual, np.ones(len(self.B)))
        linear = Reduction(model, shapes, residual, None)
        return with_second_order(
            linear, masters, operators, flat(self.second, self.third, operators)
        )


def flat(
    second: Callable[[Array, Array], Array], third: Callable[..., Array], operators: Operators
) -> Deflection:
    """Derivatives of a force, with obstacles that are not curved."""
    return Deflection(
        partial(pairwise, second),
        partial(by_triples, third, operators.inner),
        lambda shapes: np.zeros((1, *2 * shapes.shape[1:])),
    )


def dense_operators(K: Array, M: Array, B: Array) -> Operators:
    """Products with dense matrices."""
    return Operators(
        stiffness=lambda columns: K @ columns,
        mass=lambda columns: M @ columns,
        static=lambda columns: np.linalg.solve(K, columns),
        contact=lambda columns: B @ columns,
        inner=lambda left, right: left.T @ right,
    )
