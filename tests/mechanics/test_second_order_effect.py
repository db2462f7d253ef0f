"""What second order changes, before a branch is followed: against exact periods, and the rule."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bent_body import BentBody

from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.mechanics.second_order_effect import (
    Effect,
    chosen_kinematics,
    effect_of,
    frequency_change,
)
from fenics_nnm.time_domain.collocated import Collocated
from fenics_nnm.time_domain.shooting import OrbitGuess, shoot


def exact_change(model: ReducedModel, mode: int, amplitude: float) -> float:
    """The same from the motion in time, without contact."""
    flow = Collocated(Mechanics.of(replace(model, gap=1e3 * model.gap)))
    followed = -model.kinematics.tensors["alpha"][:, 0, 0] * (amplitude / model.omega) ** 2
    q, v = np.where(np.arange(model.modes) == mode, amplitude, followed), np.zeros(model.modes)
    guess = OrbitGuess(q, v, 2 * np.pi / model.omega[mode], flow.energy(q, v), False, True)
    shot = shoot(flow, guess)
    assert shot.converged, shot.failure
    return 2 * np.pi * shot.frequency / model.omega[mode] - 1


@pytest.mark.parametrize(
    "terms", [(0.9, 0.0, 0.0), (0.0, 0.7, 0.0), (0.0, 0.0, 1.1), (0.9, 0.7, 1.1)]
)
def test_frequency_change_of_each_term_to_second_order(terms: tuple[float, float, float]) -> None:
    beta, D, alpha = terms
    record = SecondOrder([0], [[[0.0]]], [[[alpha]]], [[[[beta]]]], [[[[D]]]])
    model = ReducedModel([1.7], [[1.0]], [[0.1]], [1.0], kinematics=record)
    small = frequency_change(model, 0, 0.02)
    assert exact_change(model, 0, 0.02) == pytest.approx(small, rel=1e-2)


def test_frequency_change_of_a_body_whose_other_modes_follow() -> None:
    """They follow all but statically: at 1 : 12 with a dynamic factor of 4 / 144."""
    body = replace(BentBody.random(5, 2, seed=1), omega=np.array([1.0, 12.0, 14.0, 17.0, 21.0]))
    model = body.reduction(3, np.array([0])).model
    small = frequency_change(model, 0, 0.01)
    assert abs(small) > 1e-6
    assert exact_change(model, 0, 0.01) == pytest.approx(small, rel=0.05)


def test_closing_at_grazing_and_at_the_largest_energy() -> None:
    record = SecondOrder([0], [[[-3.0]]], [[[0.0]]], [[[[0.0]]]], [[[[0.0]]]])
    model = ReducedModel([1.0], [[2.0]], [[0.1]], [0.4], kinematics=record)
    found = effect_of(model, 0, 2.5)
    assert found.at_grazing == pytest.approx(-1.5 * 0.2**2 / 0.4)  # linear grazing at 0.2
    assert found.at_largest == pytest.approx(2.5 * found.at_grazing)
    assert effect_of(model, 0, 0.5).gamma_ratio == 1


def test_rule_of_auto_and_doubt_of_linear() -> None:
    def effect(grazing: float, frequency: float) -> Effect:
        return Effect(2.0, grazing, 2 * grazing, frequency)

    for grazing, frequency, expected in (
        (0.0024, 0.9e-4, False),
        (0.0026, 0.0, True),
        (-0.0026, 0.0, True),
        (0.0, -1.1e-4, True),
    ):
        choice = chosen_kinematics("auto", effect(grazing, frequency))
        assert choice.second_order == expected
        assert ("no more than" in choice.reason) == (not expected)
        assert not choice.doubt
    linear = chosen_kinematics("linear", effect(-0.31, 0.0))
    assert not linear.second_order
    assert "-31 % of the gap" in linear.doubt
    assert not chosen_kinematics("linear", effect(0.049, 1.0)).doubt
