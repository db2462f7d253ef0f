"""The factors of a matrix, which give solutions and the sign of its determinant at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices


@dataclass(frozen=True, slots=True)
class SignedFactor:
    """Factors L U of a square matrix with its rows exchanged.

    Attributes:
        both: L below the diagonal and U, shape (n, n).
        exchanged: Row that each row was exchanged with, shape (n,).
        sign: Sign of the determinant; 0 where a pivot is zero.
    """

    both: Array
    exchanged: Indices
    sign: float

    @classmethod
    def of(cls, matrix: Array) -> SignedFactor:
        """Factors of a matrix of shape (n, n)."""
        from scipy.linalg.lapack import dgetrf  # takes 0.1 s, which `check` has no use for

        both, exchanged, _ = dgetrf(matrix)
        exchanges = np.count_nonzero(exchanged != np.arange(len(matrix)))
        negative = np.count_nonzero(np.diagonal(both) < 0)
        regular = np.diagonal(both).all()
        return cls(both, exchanged, (-1.0) ** (exchanges + negative) if regular else 0.0)

    def solution(self, right: Array) -> Array:
        """Solution for a right-hand side of shape (n,)."""
        from scipy.linalg.lapack import dgetrs

        return np.asarray(dgetrs(self.both, self.exchanged, right)[0])
