"""Bounds on the eigenvalues of a symmetric matrix by a Cholesky factor, cheaper than by values."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dpotrf

from fenics_nnm.arrays import Array


def surely_above(matrix: Array, bound: float) -> bool:
    """Whether all eigenvalues of a symmetric matrix are above a bound, to round-off.

    Args:
        matrix: Shape (n, n), symmetric.
        bound: Bound.
    """
    shifted = matrix.copy()
    shifted[np.diag_indices_from(shifted)] -= bound
    return factorises(shifted)


def factorises(matrix: Array) -> bool:
    """Whether a symmetric matrix has a Cholesky factor; shape (n, n), overwritten."""
    _, failed = dpotrf(matrix.T, lower=False, overwrite_a=True, clean=False)
    return not failed


def largest_at_most(matrix: Array) -> float:
    """A bound on the largest eigenvalue of a symmetric matrix, by the sums of its rows."""
    return float(np.abs(matrix).sum(axis=1).max())
