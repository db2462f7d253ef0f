"""Pseudo-arclength continuation: geometry against differences, curves against other constraints."""

import numpy as np
import pytest

from fenics_nnm.backbone.continuity import Continuity
from fenics_nnm.backbone.mode_trace import GAMMA_DOWN, GAMMA_UP, OMEGA_UP, mode_trace
from fenics_nnm.continuation.arc_length import (
    FixedArc,
    Metric,
    Problem,
    curve_point,
    scaled_jacobian,
)
from fenics_nnm.continuation.heading import Rising, Uphill
from fenics_nnm.continuation.trace import End, NoRules, Trace
from fenics_nnm.continuation.trace_options import ArcLength, Predictor, Range
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.conditions import FREQUENCY, GAMMA, FixedEnergy
from fenics_nnm.nonlinear.equations import HarmonicEquations, harmonic_equations
from fenics_nnm.nonlinear.newton import solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

GRAZING = 0.25

MODEL = ReducedModel(
    omega=[1.0, 2.62, 6.31],
    Phi=[[1.0, -0.6, 0.5], [0.7, 0.4, -0.8]],
    R=[[0.06, 0.02], [0.02, 0.05]],
    gap=[1.0, 0.9],
).dimensionless()[0]


def equations(series: Series, model: ReducedModel = MODEL) -> HarmonicEquations:
    return harmonic_equations(model, series, Complementarity(model.R, model.gap))


def at_energy(of: HarmonicEquations, ratio: float) -> Solution:
    """The motion of the first mode at an energy, from the linear mode."""
    q = np.zeros(of.shape)
    q[1, 0] = np.sqrt(ratio)
    return solve(of, FixedEnergy(ratio * GRAZING), Unknowns.of(q, 1.0))


def problem(of: HarmonicEquations) -> Problem:
    return Problem.of(of, ArcLength().newton)


@pytest.mark.parametrize("series", [CosineSeries(6, 48), FourierSeries(6, 48)])
def test_jacobian_of_the_constraint_and_the_tangent(series: Series) -> None:
    of = equations(series)
    here = at_energy(of, 1.5)
    metric = Metric.about(of, here.at)
    rng = np.random.default_rng(1)
    direction = rng.normal(size=here.q.size + 1)
    direction /= np.linalg.norm(direction)
    arc = FixedArc(metric, here.at, direction, 0.3)
    way = Unknowns.of(0.1 * rng.normal(size=here.q.shape), 0.2)
    by = arc.gradient(of, here.at)
    ahead, behind = (here.at.moved(way, sign * 1e-3) for sign in (1, -1))
    difference = arc.value(of, ahead) - arc.value(of, behind)
    assert difference / 2e-3 == pytest.approx(np.sum(by.q * way.q) + by.omega * way.omega)
    # motions a small step to both sides, by the energy: their chord is the tangent
    near = [solve(of, FixedEnergy(g * GRAZING), here.at) for g in (1.4999, 1.5001)]
    chord = metric.between(near[0].at, near[1].at)
    tangent = curve_point(of, here, chord).tangent
    np.testing.assert_allclose(tangent, chord / np.linalg.norm(chord), atol=2e-4)
    matrix = scaled_jacobian(of, metric, here, tangent)
    image = matrix[:, : len(tangent)] @ tangent
    np.testing.assert_allclose(np.delete(image, here.q.size), 0.0, atol=1e-12)


def traced(series: Series, predictor: Predictor) -> Trace:
    of = equations(series)
    return mode_trace(
        problem(of),
        at_energy(of, 0.9),
        GAMMA_UP,
        options=ArcLength(predictor=predictor),
        gamma=Range(high=2.4 * GRAZING, targets=(1.2 * GRAZING, 1.7 * GRAZING)),
        omega=Range(targets=(1.02, 1.04)),
    )


@pytest.mark.parametrize("predictor", list(Predictor))
@pytest.mark.parametrize("series", [CosineSeries(8, 64), FourierSeries(8, 64)])
def test_same_curve_as_at_fixed_energies(series: Series, predictor: Predictor) -> None:
    branch = traced(series, predictor)
    points = list(branch)
    assert branch.end is End.LEFT_RANGE
    assert branch.reason == "gamma leaves its range at 0.6"
    hit = [point.solution for point in points if point.target]
    ratios = [solution.energies.gamma / GRAZING for solution in hit]
    for wanted in (1.2, 1.7, 2.4):
        assert min(abs(ratio / wanted - 1) for ratio in ratios) < 1e-10
    for wanted in (1.02, 1.04):
        assert min(abs(solution.omega / wanted - 1) for solution in hit) < 1e-10
    of = equations(series)
    alone = at_energy(of, 0.9)
    for point in points:
        found = point.solution.energies
        for gamma in np.linspace(alone.energies.gamma, found.gamma, 4)[1:]:  # in small steps
            q = alone.q * np.sqrt(gamma / alone.energies.gamma)
            alone = solve(of, FixedEnergy(gamma), Unknowns.of(q, alone.omega))
        assert alone.converged
        assert point.solution.omega == pytest.approx(alone.omega, rel=1e-8)
        assert found.stiffness == pytest.approx(alone.energies.stiffness, rel=1e-8)
    assert np.all(np.diff([point.length for point in points]) > 0)
    assert np.all(np.diff([point.solution.energies.gamma for point in points]) > 0)


def test_predictors_differ_in_their_points_only() -> None:
    lengths = [
        [point.length for point in traced(CosineSeries(8, 64), predictor) if not point.target]
        for predictor in Predictor
    ]
    assert lengths[0][:1] == lengths[1][:1]
    assert abs(lengths[0][5] - lengths[1][5]) > 1e-4


class Enough(NoRules):
    def end(self, before: Solution, after: Solution) -> str:
        return "enough" * (after.omega > 1.01)


def test_every_end_names_its_reason() -> None:
    of = equations(CosineSeries(8, 64))
    start = at_energy(of, 0.9)
    few = mode_trace(problem(of), start, GAMMA_UP, options=ArcLength(points=3))
    assert len(list(few)) == 3
    assert few.end is End.MOST_POINTS
    assert few.reason == "points = 3 steps were taken: raise it to go on"
    strict = mode_trace(problem(of), start, GAMMA_UP, rules=Continuity(largest_change=1e-9))
    list(strict)
    assert strict.end is End.STUCK
    assert "largest_change" in strict.reason
    assert "smallest_step = 1e-05" in strict.reason
    called = mode_trace(problem(of), start, GAMMA_UP, rules=Enough())
    assert list(called)[-1].solution.omega > 1.01
    assert (called.end, called.reason) == (End.RULE, "enough")
    down = mode_trace(problem(of), start, GAMMA_DOWN, gamma=Range(low=0.1))
    assert list(down)[-1].solution.energies.gamma == pytest.approx(0.1, rel=1e-10)
    assert down.reason == "gamma leaves its range at 0.1"


@pytest.mark.parametrize("series", [CosineSeries(6, 48), FourierSeries(6, 48)])
def test_heading_by_a_gradient_is_that_by_singular_vectors(series: Series) -> None:
    of = equations(series)
    start = at_energy(of, 1.5)
    for quantity in (GAMMA, FREQUENCY):
        for falls in (False, True):
            by_gradient = Uphill(quantity, falls).first(problem(of), start)
            by_vectors = Rising(quantity, falls).first(problem(of), start)
            np.testing.assert_allclose(by_gradient.tangent, by_vectors.tangent, atol=1e-9)
            assert by_gradient.orientation == by_vectors.orientation


def test_heading_that_tells_nothing_is_refused() -> None:
    of = equations(CosineSeries(8, 64))
    for heading in (OMEGA_UP, Uphill(FREQUENCY)):
        with pytest.raises(ModelError, match="level"):
            mode_trace(problem(of), at_energy(of, 0.9), heading)
    with pytest.raises(ModelError, match="smallest_step"):
        ArcLength(step=1e-6)
