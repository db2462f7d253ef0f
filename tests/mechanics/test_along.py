"""Modes that move along: the bounce of one mode by quadrature, clusters, what masters change."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from fenics_nnm.mechanics.along import Along, Bounce
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder

BOUNCE = Bounce(omega=2.0, spring=30.0, reach=0.5, amplitude=0.9)


def half_period(reach: float) -> float:
    """By quadrature of dq / sqrt(2 (E - V)), without singular ends."""
    a, w, k = BOUNCE.amplitude, BOUNCE.omega, BOUNCE.spring

    def left(q: float) -> float:
        return float((w * a) ** 2 - (w * q) ** 2 - k * max(q - reach, 0.0) ** 2)

    b, c = (w**2 + k) / 2, k * reach
    turn = (c + np.sqrt(c**2 - 2 * b * (k * reach**2 - (w * a) ** 2))) / (2 * b)

    def part(start: float, end: float) -> float:
        return quad(
            lambda s: 2 * s * (end - start) / np.sqrt(left(start + (end - start) * s**2)), 0, 1
        )[0]

    return part(-a, 0.0) + part(turn, reach) * -1 + quad(lambda q: left(q) ** -0.5, 0.0, reach)[0]


def test_bounce_is_that_of_one_mass_and_a_spring() -> None:
    far = BOUNCE.largest
    energy = (2.0 * 0.9) ** 2
    assert (2.0 * far) ** 2 + 30.0 * (far - 0.5) ** 2 == pytest.approx(energy, rel=1e-12)
    short, own, long = (half_period(0.5 * (1 + part)) for part in (-0.1, 0.0, 0.1))
    change = abs(1 / short - 1 / long) * own / 2
    assert BOUNCE.frequency_change(0.1) == pytest.approx(change, rel=1e-6)
    assert change > 0.01
    below = Bounce(omega=2.0, spring=30.0, reach=0.5, amplitude=0.4)
    assert below.largest == 0.4 and below.frequency_change(0.1) == 0


def model(second: float) -> ReducedModel:
    """Two modes at a contact point, the first one the followed master of two."""
    Theta = [[[0.0, 0.5], [0.5, 0.2]]]
    zero = np.zeros((2, 2, 2, 2))
    order = SecondOrder([0, 1], Theta, np.zeros((2, 2, 2)), zero, zero)
    return ReducedModel([1.0, second], [[1.0, 0.6]], [[0.02]], [1.0], kinematics=order)


def test_modes_move_statically_or_farther_near_the_first_three_harmonics() -> None:
    for second, factor in ((8.0, 1.0), (1.01, 10.0), (3.1, 1 / 3 / (1 - (3 / 3.1) ** 2))):
        found = Along.of(model(second), 0, 1.5)
        S = 0.02 + (0.6 / second) ** 2
        force = (found.bounce.largest - 1.0) / S
        assert found.amplitudes[0] == 0
        assert found.amplitudes[1] == pytest.approx(0.6 / second**2 * force * factor)
        x = found.amplitudes[1]
        closing = 0.5 * found.bounce.largest * x + 0.2 * x**2 / 2
        assert found.closing_change(model(second)) == pytest.approx(closing)
    assert not Along.of(model(8.0), 0, 0.9).amplitudes.any()
