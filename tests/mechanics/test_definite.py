"""Bounds on eigenvalues by a factor, against eigenvalues."""

from __future__ import annotations

import numpy as np

from fenics_nnm.mechanics.closed import highest_frequency
from fenics_nnm.mechanics.definite import factorises, largest_at_most, surely_above
from fenics_nnm.mechanics.model import ReducedModel


def test_bounds_are_told_on_both_sides_of_an_eigenvalue() -> None:
    Q, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(12, 12)))
    matrix = (Q * np.linspace(0.5, 3, 12)) @ Q.T
    matrix = (matrix + matrix.T) / 2
    before = matrix.copy()
    assert surely_above(matrix, 0.5 - 1e-9) and not surely_above(matrix, 0.5 + 1e-9)
    assert factorises(matrix.copy()) and not factorises(-matrix)
    assert 3 <= largest_at_most(matrix) < 12
    np.testing.assert_array_equal(matrix, before)


def test_highest_frequency_is_that_with_all_points_closed() -> None:
    model = ReducedModel([1.0, 2.0], [[1.0, 0.5], [0.2, 1.0]], [[0.5, 0.1], [0.1, 0.4]], [1.0, 1.0])
    held = np.diag([1.0, 4.0]) + model.Phi.T @ np.linalg.solve(model.R, model.Phi)
    assert abs(highest_frequency(model) ** 2 / np.linalg.eigvalsh(held)[-1] - 1) < 1e-14
