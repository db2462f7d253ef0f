"""Rate matrices against those of matrices and the decay of a mode."""

import numpy as np
from scipy.linalg import eigh

from fenics_nnm.mechanics.damping import modal_rate, rayleigh_rate

K = np.array([[3.0, -1.0], [-1.0, 2.0]])
M = np.array([[1.0, 0.1], [0.1, 0.5]])


def test_rayleigh_damping_is_that_of_the_matrices() -> None:
    squared, shapes = eigh(K, M)
    found = rayleigh_rate(np.sqrt(squared), 0.3, 0.02)
    np.testing.assert_allclose(found, shapes.T @ (0.3 * M + 0.02 * K) @ shapes, atol=1e-14)


def test_roots_of_a_mode_have_its_damping_ratio() -> None:
    """s^2 + c s + omega^2 = 0 has Re s = -zeta omega and |s| = omega."""
    omega, ratios = np.array([2.0, 5.0]), np.array([0.05, 0.2])
    rate = modal_rate(omega, ratios)
    assert not (rate - np.diag(np.diag(rate))).any()
    for natural, ratio, each in zip(omega, ratios, np.diag(rate), strict=True):
        root = np.roots([1.0, each, natural**2])[0]
        np.testing.assert_allclose([-root.real, abs(root)], [ratio * natural, natural])
