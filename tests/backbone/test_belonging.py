"""Which motion is meant: thresholds about a state of rest, and the best of several motions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fenics_nnm.backbone.belonging import Belonging
from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.levels import HarmonicBalance, levels
from fenics_nnm.backbone.selection import Selection
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.solution import Solution, evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns

OPEN = ReducedModel(omega=[1.0, 3.4], Phi=[[1.0, 1.0]], R=[[0.1]], gap=[1.0])
CLOSED = replace(OPEN, gap=np.array([-0.5]))


def selection(model: ReducedModel) -> Selection:
    level = levels(model, HarmonicBalance(4, 32), mode=0)[-1]
    return Selection(Belonging.about(level.equations.rest, 0), level, 0)


def motion(select: Selection, omega: float, share: float) -> Solution:
    """A motion with a share of its kinetic energy in the first mode, the rest in the second."""
    equations = select.finest.equations
    shapes = equations.rest.shapes
    q = np.zeros(equations.shape)
    q[0] = equations.rest.q
    q[1] = 0.1 * (np.sqrt(share) * shapes[:, 0] + np.sqrt(1 - share) * shapes[:, 1])
    return evaluated(equations, Unknowns.of(q, omega))


def found(select: Selection, omega: float, share: float) -> CascadeSolution:
    solution = motion(select, omega, share)
    return CascadeSolution(2.0, 2.0, (solution,), select.share(solution))


def test_thresholds_follow_from_the_state_of_rest() -> None:
    free = Belonging.about(OPEN.at_rest(), 0)
    assert (free.smallest_contact, free.smallest_share) == (0.3, 0.5)
    assert free.linear_until == 1 and not free.lifts_off
    pressed = Belonging.about(CLOSED.at_rest(), 0)
    assert (pressed.smallest_contact, pressed.smallest_share) == (0.05, 0.1)
    assert pressed.linear_until == 1 and pressed.lifts_off
    touching = Belonging.about(replace(OPEN, gap=np.array([0.0]), reference=1.0).at_rest(), 0)
    assert (touching.smallest_contact, touching.smallest_share) == (0.05, 0.1)
    assert touching.linear_until == 0 and not touching.lifts_off


@pytest.mark.parametrize(
    ("contact", "share", "words"),
    [
        (0.29, 0.9, "a motion with 0.29 of the contact that the followed mode alone has"),
        (0.29, 0.1, "a motion with 0.29 of the contact"),
        (0.31, 0.49, "only 49% of its kinetic energy in the first harmonic"),
        (0.31, 0.51, ""),
    ],
)
def test_a_motion_that_is_refused_comes_with_the_reason(
    contact: float, share: float, words: str
) -> None:
    refusal = Belonging(linear_until=1.0, lifts_off=False).refusal(contact, share)
    assert words in refusal and bool(words) == bool(refusal)


@pytest.mark.parametrize("share", [0.2, 0.75, 1.0])
def test_share_of_the_followed_mode(share: float) -> None:
    select = selection(OPEN)
    assert select.share(motion(select, 1.2, share)) == pytest.approx(share, rel=1e-12)


def test_with_open_points_the_larger_share_of_the_followed_mode_is_kept() -> None:
    select = selection(OPEN)
    near, pure = found(select, 1.2, 0.7), found(select, 1.4, 0.9)
    nothing = CascadeSolution(2.0, 2.0, (None,))
    assert select.best([near, pure, nothing], found(select, 1.2, 0.7)) == pure


def test_with_closed_points_the_nearer_frequency_is_kept() -> None:
    select = selection(CLOSED)
    near, pure, beside = found(select, 1.2, 0.7), found(select, 1.4, 0.9), found(select, 1.21, 0.7)
    assert select.best([near, pure], beside) == near
    assert select.best([near, pure]) == pure


def test_a_motion_is_doubted_that_is_missing_or_has_lost_share() -> None:
    select = selection(OPEN)
    good, worse = found(select, 1.2, 0.9), found(select, 1.2, 0.87)
    assert not select.doubtful(good, None) and not select.doubtful(worse, None)
    assert select.doubtful(worse, good) and not select.doubtful(good, worse)
    assert select.doubtful(CascadeSolution(2.0, 2.0, (None,)), None)
    assert select.doubtful(replace(good, slope_ratio=0.01), None)


def test_a_jump_of_frequency_is_doubted_where_closed_points_lift_off() -> None:
    for model, doubted in ((OPEN, False), (CLOSED, True)):
        select = selection(model)
        at, beside = found(select, 1.2, 0.9), found(select, 1.23, 0.9)
        assert select.doubtful(at, beside) is doubted
        assert not select.doubtful(at, found(select, 1.21, 0.9))
