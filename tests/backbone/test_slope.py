"""Slope of a branch against differences, and the tongue that it tells where detuning does not."""

import numpy as np
import pytest

from fenics_nnm.backbone.follow import ArcContinuation, EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import FAILED, MAIN_BRANCH, RESONANT
from fenics_nnm.backbone.resonance import STILL, left_behind
from fenics_nnm.backbone.slope import frequency_slope
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.conditions import FixedEnergy
from fenics_nnm.nonlinear.equations import harmonic_equations
from fenics_nnm.nonlinear.newton import solve
from fenics_nnm.nonlinear.unknowns import Unknowns

MODEL = ReducedModel(omega=[1.0, 3.4], Phi=[[1.0, 1.0]], R=[[0.1]], gap=[1.0])


@pytest.mark.parametrize("series", [CosineSeries(5, 60), FourierSeries(5, 60)])
def test_slope_against_differences(series: Series) -> None:
    equations = harmonic_equations(MODEL, series, Complementarity(MODEL.R, MODEL.gap))
    q = np.zeros(equations.shape)
    q[1, 0] = 1.2
    gamma = 0.25 * 1.3
    at = solve(equations, FixedEnergy(gamma), Unknowns.of(q, 1.0))
    ends = [solve(equations, FixedEnergy(gamma * factor), at.at) for factor in (1 - 1e-6, 1 + 1e-6)]
    difference = (ends[1].omega - ends[0].omega) / at.omega / 2e-6
    assert frequency_slope(equations, at) == pytest.approx(difference, rel=1e-5)


def test_slope_of_points_is_that_of_the_branch() -> None:
    """Over that of the followed mode alone, whose branch has the slope of the coarsest level."""
    balance = HarmonicBalance(6, 72)
    near = (1.3, 1.3001)
    both = [
        follow(model, EnergyContinuation(1.2, 1.4, 0.2, report_at=near), balance, mode=0)
        for model in (MODEL, MODEL.with_modes(np.array([0])))
    ]
    slopes = []
    for branch in both:
        at = {point.gamma_ratio: point for point in branch.points}
        slopes.append(
            (at[near[1]].motion.frequency - at[near[0]].motion.frequency) / (near[1] - near[0])
        )
    found = next(point for point in both[0].points if point.gamma_ratio == 1.3)
    # the coarsest level has two harmonics only
    assert found.notes.slope_ratio == pytest.approx(slopes[0] / slopes[1], rel=0.15)


def test_tongue_is_marked_by_its_slope() -> None:
    """In the tongue of mode 2 the frequency stands still, also where it is 5 % from omega_2 / 3.

    In its mouth the energy of mode 2 is as small as one likes.
    """
    branch = follow(MODEL, ArcContinuation(0.8, 10.0), HarmonicBalance(6, 72), mode=0)
    still = [point for point in branch.points if point.notes.slope_ratio < STILL]
    assert len(still) > 10
    lags = [point for point in still if point.family != MAIN_BRANCH]
    assert len(lags) > len(still) / 2 and all(point.resonance for point in lags)
    assert {point.status for point in lags} <= {RESONANT, FAILED}


def test_flat_branch_without_other_modes_is_no_tongue() -> None:
    q = np.zeros((4, 2))
    q[1, 0] = 1.0
    series = CosineSeries(3, 32)
    assert not left_behind(series, q, 0.0, mode=0)
    q[3, 1] = 1e-5
    assert left_behind(series, q, 0.0, mode=0)
    assert not left_behind(series, q, 0.2, mode=0)
    q[3, 1] = 0.1
    assert left_behind(series, q, 0.2, mode=0)
    assert not left_behind(series, q, 0.6, mode=0)
    assert not left_behind(series, q, float("nan"), mode=0)
