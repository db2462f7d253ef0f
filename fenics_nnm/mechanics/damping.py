r"""Damping of the linear part: rate matrices C of q'' + C q' + Lambda q = f in modal coordinates.

Lambda = diag(omega_j^2) in 1/s^2, modes mass-normalised, so that C is in 1/s. Both kinds are
diagonal: they do not couple the modes of the undamped structure.
"""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array


def modal_rate(omega: Array, ratios: Array) -> Array:
    """Rate matrix of modal damping, C = diag(2 zeta_j omega_j).

    Args:
        omega: Natural circular frequencies in rad/s, shape (J,).
        ratios: Damping ratios zeta_j, 1 at critical damping, shape (J,).

    Returns:
        C in 1/s, shape (J, J).
    """
    return np.diag(2 * ratios * omega)


def rayleigh_rate(omega: Array, alpha: float, beta: float) -> Array:
    """Rate matrix of Rayleigh damping, C = alpha I + beta Lambda.

    In the matrices of the structure it is alpha M + beta K; the damping ratios are
    zeta_j = alpha / (2 omega_j) + beta omega_j / 2.

    Args:
        omega: Natural circular frequencies in rad/s, shape (J,).
        alpha: Part of the mass in 1/s.
        beta: Part of the stiffness in s.

    Returns:
        C in 1/s, shape (J, J).
    """
    return np.diag(alpha + beta * omega**2)
