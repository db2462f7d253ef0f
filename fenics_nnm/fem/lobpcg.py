"""The lowest modes of a body by preconditioned iteration, without a factorisation of K.

Locally optimal block preconditioned conjugate gradients: A. V. Knyazev, SIAM J. Sci. Comput. 23
(2001) 517, with the conjugate directions kept orthogonal to the Ritz vectors as in Hetmaniuk and
Lehoucq, J. Comput. Phys. 218 (2006) 324.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ConvergenceError
from fenics_nnm.fem.block import groups
from fenics_nnm.fem.pencil import Pencil
from fenics_nnm.reduction.operators import Product

logger = logging.getLogger(__name__)

#: Directions whose squared length, of unit vectors, is below this are left out of the basis.
_DEPENDENT = 1e-13

#: A mode is not improved any more once its error is this part of the tolerance.
_LOCKED = 0.01

#: Largest number of iterations.
_ITERATIONS = 200

#: Rows that are combined at once.
_ROWS = 20_000


@dataclass(frozen=True, slots=True)
class _Block:
    """Columns x at the owned degrees of freedom with K x and M x, each of shape (n_owned, k)."""

    x: Array
    K: Array
    M: Array

    @classmethod
    def of(cls, x: Array, pencil: Pencil) -> _Block:
        return cls(x, pencil.stiffness(x), pencil.mass(x))

    @property
    def count(self) -> int:
        return self.x.shape[1]

    def first(self, count: int) -> _Block:
        return _Block(self.x[:, :count], self.K[:, :count], self.M[:, :count])


@dataclass(frozen=True, slots=True)
class _Projected:
    """Gram matrices of a basis, S^T K S and S^T M S."""

    K: Array
    M: Array

    def ritz(self, count: int) -> tuple[Array, Array]:
        """The lowest Ritz values and M-orthonormal coefficients of their vectors."""
        size = 1 / np.sqrt(np.diagonal(self.M))
        length, axes = np.linalg.eigh(self.M * np.outer(size, size))
        kept = length > _DEPENDENT * length[-1]
        basis = size[:, None] * axes[:, kept] / np.sqrt(length[kept])
        values, vectors = eigh(basis.T @ self.K @ basis, subset_by_index=[0, count - 1])
        return values, basis @ vectors

    def directions(self, C: Array, active: Indices) -> Array:
        """Coefficients of the steps to the active Ritz vectors, M-orthonormal, and so to all."""
        steps = C[:, active].copy()
        steps[: C.shape[1]] = 0.0
        for _ in range(2):
            steps -= C @ (C.T @ self.M @ steps)
            length, axes = np.linalg.eigh(steps.T @ self.M @ steps)
            kept = length > _DEPENDENT * max(float(length[-1]), 1e-300)
            steps = steps @ (axes[:, kept] / np.sqrt(length[kept]))
        return steps


def lowest_modes(
    pencil: Pencil,
    precondition: Product,
    start: Array,
    count: int,
    *,
    tolerance: float,
) -> tuple[Array, Array]:
    r"""The `count` lowest eigenpairs of K phi = omega^2 M phi.

    The error of a Ritz vector x with the value theta is estimated by its residual r = K x - theta
    M x in the norm of the preconditioner T, near K^-1:

        e = sqrt(r^T T r / theta).

    It bounds the error of x relative to its strain energy up to the distance of the next Ritz
    value that is not sought, and the relative error of theta by its square.

    Args:
        pencil: Products with K and M, and inner products over all ranks.
        precondition: T, symmetric and positive definite.
        start: First vectors, shape (n_owned, m) with m > count; more make it faster. They are
            overwritten.
        count: Number of modes.
        tolerance: Largest error e of each mode.

    Returns:
        Squared circular frequencies, ascending, shape (count,), and mass-normalised shapes,
        shape (n_owned, count).

    Raises:
        ConvergenceError: if the errors stay above the tolerance.
    """
    X = _Block.of(start, pencil)
    theta, C = _projected([X], pencil).ritz(X.count)
    _combine([X], [C])
    P: list[_Block] = []
    for iteration in range(_ITERATIONS):
        W, error = _preconditioned(X, theta, pencil, precondition)
        logger.debug("LOBPCG %d: error %.2e", iteration, error[:count].max())
        if error[:count].max() <= tolerance:
            return theta[:count], X.x[:, :count]
        active = np.flatnonzero(error > _LOCKED * tolerance)
        W = _orthogonal(_only(W, active), X, pencil)
        basis = [X, _Block.of(W, pencil), *P]
        projected = _projected(basis, pencil)
        theta, C = projected.ritz(X.count)
        steps = projected.directions(C, active)
        _combine(basis, [C, steps])
        P = [basis[1].first(steps.shape[1])]
    raise ConvergenceError(
        f"eigensolver: {int(np.count_nonzero(error[:count] > tolerance))} of {count} modes have "
        f"errors up to {error[:count].max():.1e} after {_ITERATIONS} iterations"
    )


def _preconditioned(
    X: _Block, theta: Array, pencil: Pencil, precondition: Product
) -> tuple[Array, Array]:
    """T r of the residuals r = K x - theta M x, and the errors e, a few at a time."""
    W, squared = np.empty_like(X.x, order="F"), np.empty_like(theta)
    for group in groups(X.count):
        residual = X.K[:, group] - X.M[:, group] * theta[group]
        W[:, group] = precondition(residual)
        squared[group] = pencil.products(residual, W[:, group])
    return W, np.sqrt(np.maximum(squared, 0.0) / theta)


def _only(W: Array, active: Indices) -> Array:
    """The active columns of W, ascending, put first in place."""
    for column, taken in enumerate(active):
        W[:, column] = W[:, taken]
    return W[:, : len(active)]


def _orthogonal(W: Array, X: _Block, pencil: Pencil) -> Array:
    """W, changed in place, without its part in X, in the inner product of M, and of unit length."""
    inner = pencil.inner(X.M, W)
    for rows in _chunks(len(W)):
        W[rows] -= X.x[rows] @ inner
    W /= np.sqrt(pencil.products(W, W))
    return W


def _projected(basis: list[_Block], pencil: Pencil) -> _Projected:
    """Gram matrices of all blocks together."""
    return _Projected(*(_gram(basis, name, pencil) for name in ("K", "M")))


def _gram(basis: list[_Block], name: str, pencil: Pencil) -> Array:
    rows = [
        np.hstack([pencil.inner(left.x, getattr(right, name)) for right in basis]) for left in basis
    ]
    whole = np.vstack(rows)
    return np.asarray((whole + whole.T) / 2)


def _combine(basis: list[_Block], coefficients: list[Array]) -> None:
    """Put the columns S C of a basis S in the place of its first blocks, one C for each.

    Rows are dealt with a few at a time: twice the basis would not be less than its factors.
    """
    for name in ("x", "K", "M"):
        columns = [getattr(block, name) for block in basis]
        for rows in _chunks(len(columns[0])):
            own = np.hstack([each[rows] for each in columns])
            for target, C in zip(columns, coefficients, strict=False):
                target[rows, : C.shape[1]] = own @ C


def _chunks(count: int) -> Iterator[slice]:
    for first in range(0, count, _ROWS):
        yield slice(first, first + _ROWS)
