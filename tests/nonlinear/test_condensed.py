"""Condensed linear systems of Newton's iteration against the full ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.penalty_law import AugmentedLagrangian
from fenics_nnm.nonlinear import equations as module
from fenics_nnm.nonlinear import newton
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.condensed import condensed_solution, pays
from fenics_nnm.nonlinear.conditions import FixedEnergy, FixedFrequency
from fenics_nnm.nonlinear.equations import HarmonicEquations, harmonic_equations
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.unknowns import Unknowns

MODES, POINTS = 12, 6


def blade(seed: int) -> ReducedModel:
    """Modes of which the third has five times the frequency of the first, to the last digit."""
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(POINTS, POINTS))
    omega = np.sort(rng.uniform(2, 30, MODES))
    omega[:3] = 1.0, 2.7, 5.0
    return ReducedModel(
        omega=np.sort(omega),
        Phi=np.hstack([np.ones((POINTS, 1)), 0.5 * rng.normal(size=(POINTS, MODES - 1))]),
        R=1e-2 * (factor @ factor.T + np.eye(POINTS)),
        gap=rng.uniform(0.8, 1.2, POINTS),
    )


def equations_of(series: Series, seed: int, *, spring: bool = False) -> HarmonicEquations:
    model = blade(seed)
    if not spring:
        return harmonic_equations(model, series, Complementarity(model.R, model.gap))
    shape = (len(series.phase), POINTS)
    kappa = np.random.default_rng(seed).uniform(20.0, 60.0, shape)
    return harmonic_equations(model, series, AugmentedLagrangian(model.gap, kappa, 0.01 / kappa))


def motion_of(equations: HarmonicEquations, seed: int, amplitude: float) -> Array:
    rng = np.random.default_rng(100 + seed)
    q = 0.02 * rng.normal(size=equations.shape)
    q[1, 0] = amplitude
    return q


@pytest.mark.parametrize("drift", [0.0, 0.07])
@pytest.mark.parametrize("spring", [False, True])
@pytest.mark.parametrize("omega", [1.0, 1.0 + 1e-9, 1.13])
@pytest.mark.parametrize("seed", range(3))
def test_condensed_solution_is_that_of_the_full_jacobian(
    seed: int, omega: float, spring: bool, drift: float
) -> None:
    rng = np.random.default_rng(seed)
    of_cosines = [] if drift else [CosineSeries(7, 33), CosineSeries(9, 64)]
    for series in (*of_cosines, FourierSeries(7, 33), FourierSeries(6, 40)):
        equations = equations_of(series, seed, spring=spring)
        at = Unknowns.of(motion_of(equations, seed, 1.4), omega, drift)
        forces = equations.forces(at)
        assert 10 < np.count_nonzero(forces.used)
        more = 2 if series.free_phase else 1
        border = Border(
            columns=rng.normal(size=(more, *equations.shape)),
            rows=rng.normal(size=(more, *equations.shape)),
            corner=rng.normal(size=(more, more)),
            right=rng.normal(size=equations.shape),
            below=rng.normal(size=more),
        )
        full = np.block(
            [
                [equations.jacobian(at, forces), border.columns.reshape(more, -1).T],
                [border.rows.reshape(more, -1), border.corner],
            ]
        )
        right = np.concatenate([border.right.ravel(), border.below])
        expected = np.linalg.solve(full, right)
        model = equations.model
        found = condensed_solution(equations.linear(at), series, model.Phi, forces, border)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("series", [CosineSeries(10, 64), FourierSeries(6, 40)])
def test_newton_takes_the_same_way_with_and_without_condensation(
    series: Series, monkeypatch: pytest.MonkeyPatch
) -> None:
    equations = equations_of(series, 1)
    guess = Unknowns.of(motion_of(equations, 1, 1.1), 1.02)
    target = FixedEnergy(0.3)
    assert pays(equations.forces(guess), guess.q.size)
    short = newton.solve(equations, target, guess)
    monkeypatch.setattr(module, "pays", lambda *ignored: False)
    long = newton.solve(equations, target, guess)
    assert short.converged and long.converged and short.iterations == long.iterations > 2
    assert short.omega == pytest.approx(long.omega, rel=1e-12)
    np.testing.assert_allclose(short.q, long.q, atol=1e-10)


def test_a_step_that_no_contact_determines_is_refused() -> None:
    """At rest on a linear mode, harmonic 5 of mode 3 is free too: the Jacobian is singular."""
    equations = equations_of(CosineSeries(7, 33), 0)
    q = np.zeros(equations.shape)
    q[1, 0] = 0.1
    at = Unknowns.of(q, 1.0)
    found = newton.bordered_solution(
        equations,
        [FixedEnergy(equations.energy.gamma(at))],
        at,
        equations.forces(at),
        np.ones_like(q),
        np.zeros(1),
    )
    assert found is None


def test_forces_found_from_those_nearby_are_the_same() -> None:
    model, rng = blade(2), np.random.default_rng(7)
    law = Complementarity(model.R, model.gap)
    displacement = 1.5 * rng.normal(size=(50, POINTS))
    near = law(displacement + 0.3 * rng.normal(size=displacement.shape))
    alone, helped = law(displacement), law(displacement, near)
    assert np.any((near.force > 0) != (alone.force > 0))
    np.testing.assert_allclose(helped.force, alone.force, atol=1e-12 * alone.force.max())
    np.testing.assert_array_equal(helped.samples, alone.samples)
    np.testing.assert_allclose(helped.slope, alone.slope, rtol=1e-9, atol=1e-9)


def test_iterations_that_do_not_converge_tell_so_when_condensed() -> None:
    equations = equations_of(CosineSeries(10, 64), 1)
    guess = Unknowns.of(motion_of(equations, 1, 1.1), 1.02)
    found = newton.solve(equations, FixedEnergy(0.3), guess, options=Newton(iterations=1))
    assert not found.converged
    assert "1 Newton step" in found.failure
    assert replace(found, failure="").converged


def test_a_leap_that_leads_far_astray_ends_an_iteration() -> None:
    """With a bound that none keeps it is as without leaps; with a wide one as without a bound."""
    equations = equations_of(CosineSeries(10, 64), 1)
    guess = Unknowns.of(motion_of(equations, 1, 1.1), 1.1)

    def found(**options: float) -> tuple[int, str]:
        tried = newton.solve(equations, FixedFrequency(1.1), guess, options=Newton(**options))
        return tried.iterations, tried.failure

    assert found(wildest_leap=1e-3) == found(leaps=0) == (7, found(leaps=0)[1])
    assert found(wildest_leap=1e9) == found() and found()[0] > 20


def test_a_line_search_that_crawls_leaps_as_one_that_stalls() -> None:
    equations = equations_of(CosineSeries(10, 64), 1)
    guess = Unknowns.of(motion_of(equations, 1, 1.1), 1.05)

    def residual(**options: float) -> float:
        found = newton.solve(equations, FixedFrequency(1.05), guess, options=Newton(**options))
        return found.residual

    crawling = residual()
    assert residual(leaps=0) == crawling  # it never stalls
    assert residual(crawls=2) != crawling
    for held in ({"leaps": 0}, {"wildest_leap": 1e-3}, {"round_off": 10.0}):
        assert residual(crawls=2, **held) == crawling


def test_patience_ends_an_iteration_that_is_not_near_a_motion() -> None:
    equations = equations_of(CosineSeries(10, 64), 1)
    guess = Unknowns.of(motion_of(equations, 1, 1.1), 1.1)
    options = Newton(patience=12)
    lost = newton.solve(equations, FixedFrequency(1.1), guess, options=options)
    assert lost.iterations == 12 and "no convergence in 12 Newton steps" in lost.failure
    found = newton.solve(equations, FixedEnergy(0.3), Unknowns.of(guess.q, 1.02))
    near = newton.solve(equations, FixedEnergy(0.3), found.at.moved(found.at, 1e-4))
    assert near.iterations > 1
    patient = Newton(patience=1)
    again = newton.solve(
        equations, FixedEnergy(0.3), found.at.moved(found.at, 1e-4), options=patient
    )
    assert again.converged and again.iterations == near.iterations


def test_a_wild_residual_ends_an_iteration_once_it_has_had_its_first_steps() -> None:
    equations = equations_of(CosineSeries(10, 64), 1)
    guess = Unknowns.of(motion_of(equations, 1, 1.1), 1.1)
    free = newton.solve(equations, FixedFrequency(1.1), guess, options=Newton())
    assert free.iterations > 20
    for wild, steps in ((1e-9, 4), (1e9, free.iterations)):
        lost = newton.solve(equations, FixedFrequency(1.1), guess, options=Newton(wild=wild))
        assert lost.iterations == steps
