"""Engine orders among the frequencies of a curve."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.output.engine_orders import orders_near, turns_a_second


def test_orders_are_multiples_of_the_speed_near_the_frequencies() -> None:
    study = {"rotation": {"axis": "z", "rpm": 6000.0}}
    assert turns_a_second(study) == 100.0
    found = orders_near(study, np.array([290.0, 390.0]))
    assert [(order.number, order.frequency) for order in found] == [(3, 300.0), (4, 400.0)]
    assert found[0].name == "engine order 3"
    assert orders_near(study, np.array([320.0, 380.0])) == ()


def test_speed_may_be_in_radians_and_nothing_turns_without_one() -> None:
    assert turns_a_second({"rotation": {"speed": -20 * np.pi}}) == pytest.approx(10)
    assert orders_near({}, np.array([100.0])) == ()
    slow = {"rotation": {"speed": 2 * np.pi}}
    assert orders_near(slow, np.array([100.0, 200.0])) == ()  # a hundred lines
