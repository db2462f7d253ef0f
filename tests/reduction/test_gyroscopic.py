"""Frequencies under gyroscopic forces, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.errors import ModelError
from fenics_nnm.reduction.gyroscopic import gyroscopic_frequencies


@pytest.mark.parametrize(
    ("speed", "expected"), [(0.3, (0.7821230, 1.4171392)), (0.6, (0.4862332, 1.7098472))]
)
def test_two_axis_oscillator(speed: float, expected: tuple[float, float]) -> None:
    """x'' - 2 Om y' + (k1 - Om^2) x = 0, y'' + 2 Om x' + (k2 - Om^2) y = 0; k1 = 1, k2 = 1.44."""
    k1, k2 = 1.0, 1.44
    omega = np.sqrt(np.array([k1, k2]) - speed**2)
    G = 2 * speed * np.array([[0.0, -1.0], [1.0, 0.0]])
    middle, last = k1 + k2 + 2 * speed**2, (k1 - speed**2) * (k2 - speed**2)
    squares = np.sort(np.roots([1.0, -middle, last]))
    found = gyroscopic_frequencies(omega, G)
    assert found == pytest.approx(np.sqrt(squares), rel=1e-10)
    assert found == pytest.approx(expected, abs=6e-8)


def test_no_coupling_leaves_frequencies_alone() -> None:
    omega = np.array([1.0, 2.0, 2.0])
    assert gyroscopic_frequencies(omega, np.zeros((3, 3))) == pytest.approx(omega, rel=1e-14)


def test_a_matrix_that_is_not_skew_is_refused() -> None:
    with pytest.raises(ModelError, match="must be skew"):
        gyroscopic_frequencies(np.array([1.0, 2.0]), np.eye(2))
