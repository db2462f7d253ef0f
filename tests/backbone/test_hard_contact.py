"""What is not tried again, or given up early, where contact is hard to solve."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from test_branch_memory import tip

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.attempts import Attempt, FailedAttempts
from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.frequency_cascade import FrequencyCascade
from fenics_nnm.backbone.level_solver import Guess
from fenics_nnm.backbone.levels import HarmonicBalance, Level, levels
from fenics_nnm.backbone.selection import Selection
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.solution import Solution


def cascade() -> Cascade:
    model, _ = tip().dimensionless()
    return Cascade(levels(model, HarmonicBalance(3, 32), mode=0), 0, Newton())


def test_a_guess_that_failed_is_not_tried_again_at_the_same_energy() -> None:
    made: list[str] = []

    def failing() -> Attempt:
        made.append("made")
        return Attempt(failure="no convergence")

    known = FailedAttempts()
    guess = Guess(np.ones((2, 1)), 1.0, np.zeros((4, 1)))
    first = known.once(1, 1.2, guess, failing)
    assert known.once(1, 1.2, replace(guess, q=guess.q.copy()), failing) == first and len(made) == 1
    nearly = replace(guess, q=guess.q * (1 + 1e-9), omega=1 - 1e-9)  # from a level solved again
    assert known.once(1, 1.2, nearly, failing) == first and len(made) == 1
    turned = replace(guess, q=np.array([[1.0], [-1.0]]))  # of the same size
    others = (turned, replace(guess, omega=1.1), replace(guess, force=np.ones((4, 1))))
    for other in ((2, 1.2, guess), (1, 1.3, guess), *((1, 1.2, another) for another in others)):
        known.once(*other, failing)
    assert len(made) == 6


def test_frequencies_at_which_no_level_has_a_motion_end_the_search() -> None:
    tried: list[float] = []

    @dataclass(frozen=True, slots=True)
    class Barren(FrequencyCascade):
        def _solved(self, level: Level, omega: float, gamma: float, q: Array) -> Solution | None:
            tried.append(omega)
            return None

    whole = cascade()
    coarse = whole.coarse(1.3)
    assert coarse is not None
    search = Barren(whole.levels, Newton())
    assert search.near(0.25 * 1.3, coarse, 0.1) is None
    assert len(set(tried)) == 3 and len(tried) == 3 * (len(whole.levels) - 1)


def test_a_neighbour_that_was_led_to_leads_on_without_the_levels_that_it_lacks() -> None:
    alone, led = cascade(), cascade()
    neighbour, expected = alone.at(1.2, None), alone.at(1.22, None)
    assert expected.finest is not None and all(expected.solutions)
    lacking = replace(neighbour, solutions=(neighbour.solutions[0], None, neighbour.finest))
    assert len(neighbour.solutions) == 3
    led._stuck[1.2] = True
    found = led.at(1.22, lacking)
    assert found.solutions[1] is None and found.finest is not None
    assert found.finest.omega == pytest.approx(expected.finest.omega, rel=1e-9)
    assert led._stuck[1.22] and not led._alone


def test_a_doubtful_motion_that_a_neighbour_leads_to_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where neither the levels alone nor frequencies lead to a motion it is the only one."""
    whole = cascade()
    neighbour, expected = whole.at(1.2, None), cascade().at(1.22, None)
    whole._stuck[1.2] = True
    monkeypatch.setattr(Cascade, "_led", lambda self, position, neighbour: expected)
    monkeypatch.setattr(Selection, "doubtful", lambda self, found, neighbour: True)
    nothing = replace(expected, solutions=(*expected.solutions[:-1], None), share=0.0)
    monkeypatch.setattr(Cascade, "_level_by_level", lambda self, ratio, neighbour: nothing)
    monkeypatch.setattr(Cascade, "_through_frequency", lambda self, alone: alone)
    assert whole.at(1.22, neighbour).finest is expected.finest
    assert whole._stuck[1.22]
