"""Factors of a matrix with the sign of its determinant."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.continuation.signed_factor import SignedFactor


@pytest.mark.parametrize("seed", range(6))
def test_solutions_and_signs_of_random_matrices(seed: int) -> None:
    """Both signs occur among them."""
    rng = np.random.default_rng(seed)
    matrix, right = rng.standard_normal((7, 7)), rng.standard_normal(7)
    factor = SignedFactor.of(matrix)
    assert factor.sign == np.sign(np.linalg.det(matrix))
    assert np.abs(matrix @ factor.solution(right) - right).max() < 1e-12


def test_a_singular_matrix_has_no_sign() -> None:
    assert SignedFactor.of(np.diag([1.0, 0.0, -2.0])).sign == 0
    assert SignedFactor.of(np.diag([1.0, 3.0, -2.0])).sign == -1
