"""The motion of a step near a time at which it is known."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.exponential_rule import gauss_nodes
from fenics_nnm.time_domain.near_motion import NearMotion


def test_motion_near_a_known_time_is_exact_and_farther_away_asked_for_anew() -> None:
    nu, asked = np.array([1.0, 50.0]), []

    def derivatives(time: float) -> Array:
        asked.append(time)
        return np.array([nu**n * np.cos(nu * time + n * np.pi / 2) for n in range(6)]).T

    near = NearMotion(derivatives, 50.0)
    for time in (0.3, 0.3 + 0.9e-3 / 50, 0.3 - 0.9e-3 / 50, 0.31, 0.31 + 1e-5):
        exact = np.column_stack([np.cos(nu * time), -nu * np.sin(nu * time)])
        np.testing.assert_allclose(near.at(time), exact, atol=1e-13)
    assert asked == [0.3, 0.31]


def test_derivatives_of_the_polynomial_through_values_at_the_nodes() -> None:
    nodes = gauss_nodes(9)
    found = nodes.derivatives(0.3) @ (nodes.at**5 - 2 * nodes.at**3)
    exact = 0.3**5 - 2 * 0.3**3, 5 * 0.3**4 - 6 * 0.3**2, 20 * 0.3**3 - 12 * 0.3
    np.testing.assert_allclose(found, exact, rtol=1e-12)
