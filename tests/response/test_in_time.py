"""Driven motions of harmonic balance judged by integration in time."""

from dataclasses import replace

import numpy as np
import pytest

from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.conditions import FixedFrequency
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.response.in_time import InTime, coefficients_of, in_time
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.driven_motion import FOLD
from fenics_nnm.time_domain.energy_balance import energy_balance

#: An oscillator with 1 % damping that meets a stop four times as stiff as its spring.
MODEL = ReducedModel(omega=[1.0], Phi=[[1.0]], R=[[0.25]], gap=[1.0])
MECHANICS = Mechanics(
    MODEL,
    MODEL.at_rest(),
    RatedPart(MODEL.omega, np.array([[0.02]])),
    excitations=(Excitation(1, np.array([0.05]), np.zeros(1)),),
)


def balanced(harmonics: int, omega: float, x0: float, v0: float) -> tuple[FourierSeries, Solution]:
    """The motion of harmonic balance from a state at phase 0."""
    series = FourierSeries(harmonics, 16 * harmonics)
    equations = HarmonicEquations(MECHANICS, series, Complementarity(MODEL.R, MODEL.gap))
    q = np.zeros((2 * harmonics + 1, 1))
    first, second = np.flatnonzero(series.order == 1)
    q[first], q[second] = x0, v0 / omega
    return series, solve(equations, FixedFrequency(omega), Unknowns.of(q, omega))


def judged(harmonics: int, omega: float, x0: float, v0: float) -> InTime:
    series, solution = balanced(harmonics, omega, x0, v0)
    assert not solution.failure
    return in_time(DampedFlow.of(MECHANICS, 1.0), series, solution.q, omega)


def test_good_motions_are_verified_with_their_multipliers() -> None:
    """Rows of the reference curve: rising in contact, and unstable between the folds."""
    rising = judged(20, 0.99854525, 0.93981687, 0.50168683)
    assert rising.status == "verified" and not rising.reason
    assert rising.return_error < 2e-3 and rising.distance < 2e-4
    assert rising.stability == "stable" and rising.orbit.contact_fraction > 0.05
    orbit, flow = rising.orbit, DampedFlow.of(MECHANICS, 1.0).at(rising.orbit.omega)
    balance = energy_balance(flow, orbit.q, orbit.velocity, 2 * np.pi / orbit.omega)
    assert balance.error < 1e-12
    falling = judged(20, 1.02352745, -0.92068355, 0.42698626)
    assert falling.status == "verified" and falling.stability == FOLD
    assert falling.largest_multiplier == pytest.approx(1.335846, abs=1e-4)


def test_few_harmonics_are_converged_alone() -> None:
    rough = judged(1, 1.15, 0.5, 1.7)
    assert rough.status == "converged"
    assert "%" in rough.reason and rough.orbit is not None and rough.distance > 0.01


def test_motions_that_are_none_have_failed() -> None:
    series, solution = balanced(10, 1.1, 0.8, 1.2)
    flow = DampedFlow.of(MECHANICS, 1.0)
    turned = in_time(flow, series, 3 * solution.q, 1.1)
    assert turned.status == "failed" and "misses its start" in turned.reason
    assert turned.stability == "" and np.isnan(turned.largest_multiplier)
    ended = in_time(replace(flow, most_changes=0), series, solution.q, 1.1)
    assert ended.status == "failed" and "gave up" in ended.reason


def test_exact_motions_have_coefficients() -> None:
    series, solution = balanced(30, 1.1, 0.8, 1.2)
    flow = DampedFlow.of(MECHANICS, 1.0)
    found = in_time(flow, series, solution.q, 1.1)
    assert found.orbit is not None
    exact = coefficients_of(flow, found.orbit, series)
    np.testing.assert_allclose(exact[:3], solution.q[:3], atol=2e-4)
