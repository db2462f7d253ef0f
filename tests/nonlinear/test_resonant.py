"""Equations of phase resonance: derivatives, and the work that makes a level."""

import numpy as np
import pytest

from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.newton import bordered_jacobian, solve
from fenics_nnm.nonlinear.resonant import LEVEL, FixedLevel, ResonantEquations
from fenics_nnm.nonlinear.unknowns import Unknowns

#: Two modes that dashpots couple, a contact point, and a force with both parts.
MODEL = ReducedModel(np.array([1.0, 2.7]), np.array([[1.0, -0.7]]), np.array([[0.25]]), np.ones(1))
RATE = np.array([[0.02, 0.01], [0.0, 0.06]])
PUSH = Excitation(1, np.array([0.04, 0.02]), np.array([0.03, 0.015]))


@pytest.fixture
def equations() -> ResonantEquations:
    linear = RatedPart(MODEL.omega, RATE)
    mechanics = Mechanics(MODEL, MODEL.at_rest(), linear, (), (PUSH,))
    return ResonantEquations.of(mechanics, FourierSeries(6, 64))


def start(equations: ResonantEquations) -> Unknowns:
    """The first mode in phase resonance, beyond the gap."""
    q = np.zeros((13, 2))
    q[1, 0], q[7, 0] = -0.78, 1.04  # perpendicular to the force
    q[:, 1] = 0.01
    q -= equations.push * np.sum(equations.push * q) / np.sum(equations.push**2)
    return Unknowns.of(q, 1.05, 0.6)


def test_jacobian_is_that_of_differences(equations: ResonantEquations) -> None:
    at, condition = start(equations), FixedLevel(0.5)
    forces = equations.forces(at)
    assert forces.force.max() > 0 and equations.free_phase
    conditions = (condition, condition)
    matrix = bordered_jacobian(equations, conditions, at, forces)[:-2]
    matrix *= equations.row_scale(at.omega).ravel()[:, None]
    random = np.random.default_rng(3)
    step = Unknowns(random.normal(size=at.q.shape), random.normal(size=2))
    ends = [at.moved(step, part) for part in (1e-6, -1e-6)]
    ahead, behind = (equations.residual(end, equations.forces(end)) for end in ends)
    slope = matrix @ np.concatenate([step.q.ravel(), step.parameters])
    np.testing.assert_allclose(slope, (ahead - behind).ravel() / 2e-6, atol=1e-7)
    changes = [condition.value(equations, end) for end in ends]
    gradient = condition.gradient(equations, at).parameters @ step.parameters
    assert gradient == pytest.approx((changes[0] - changes[1]) / 2e-6, rel=1e-8)


def test_force_does_the_work_of_damping_and_no_other(equations: ResonantEquations) -> None:
    found = solve(equations, FixedLevel(0.6), start(equations))
    assert found.converged and LEVEL.value(found) == pytest.approx(0.6, rel=1e-12)
    assert found.forces.force.max() > 0.01 and found.omega > 1.01
    assert abs(np.sum(equations.push * found.q)) < 1e-14
    assert equations.balanced_level(found.at) == pytest.approx(0.6, rel=1e-9)


def test_damping_ratio_of_a_mode_is_its_own(equations: ResonantEquations) -> None:
    q = np.zeros((13, 2))
    q[1, 0] = 0.3
    assert equations.damping_ratio(Unknowns.of(q, 1.0, 0.0)) == pytest.approx(0.01, rel=1e-12)
