"""Lengths of steps follow from their errors."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.time_domain.rungs import Rungs


def test_steps_of_a_smooth_remainder_get_to_the_length_that_is_allowed() -> None:
    """Their errors grow by the step to the power s: a rung is 2^(s/2) in error."""
    rungs, allowed = Rungs(1.0, 16), 0.03
    for _ in range(12):
        error = (rungs.step / allowed) ** 16
        if error <= 1:
            rungs.accepted(error)
        else:
            rungs.refused(error)
    assert allowed / np.sqrt(2) < rungs.step <= allowed
    for _ in range(12):  # three times as long, once the patience is over
        rungs.accepted((rungs.step / (3 * allowed)) ** 16)
    assert 3 * allowed / 2 < rungs.step <= 3 * allowed


def test_a_step_that_is_not_solved_is_halved_and_none_is_longer_than_the_longest() -> None:
    rungs = Rungs(1.0, 16)
    assert rungs.step == pytest.approx(0.5)
    rungs.refused(float("inf"))
    assert rungs.step == pytest.approx(0.25)
    for _ in range(8):
        rungs.accepted(0.0)
    assert rungs.step == 1.0
    rungs.reach(0.3)
    assert rungs.step == pytest.approx(0.25)
