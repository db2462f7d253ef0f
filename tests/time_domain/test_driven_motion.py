"""Exact driven motions, multipliers and folds against a reference curve and closed forms."""

from pathlib import Path

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.driven_fold import fold_between
from fenics_nnm.time_domain.driven_map import DrivenMap
from fenics_nnm.time_domain.driven_motion import DOUBLING, FOLD, TORUS, DrivenOrbit, driven_orbit
from fenics_nnm.time_domain.energy_balance import energy_balance

#: Rows w, x0, v0, x_max, x_min, contact, mu_max along the whole curve of the oscillator below.
CURVE = Path(__file__).parents[1] / "reference" / "b_bilinear_forced_frf.csv"


def pushed(omega: float, force: Array) -> Drive:
    return Drive.of(omega, [Excitation(1, force, np.zeros_like(force))], len(force))


def oscillator() -> DampedFlow:
    """X'' + 0.02 x' + x + 4 (x - 1)_+ = 0.05 cos(w t): the stop is a point with R = 1/4."""
    model = ReducedModel(omega=[1.0], Phi=[[1.0]], R=[[0.25]], gap=[1.0])
    return DampedFlow(model, np.array([[0.02]]), pushed(1.0, np.array([0.05])))


def curve() -> Array:
    with CURVE.open() as file:
        rows = [line.split(",") for line in file if line[0] not in "#w"]
    return np.array(rows, float)


def orbit_at(row: Array, flow: DampedFlow) -> DrivenOrbit:
    return driven_orbit(flow.at(row[0]), row[1:2], row[2:3])


def test_whole_curve_of_a_bilinear_oscillator() -> None:
    """States, extremes, contact and multipliers of every fourth row, stable or not."""
    flow, unstable = oscillator(), 0
    for row in curve()[::4]:
        w, x0, v0, largest, least, contact, mu = row
        orbit = orbit_at(row, flow)
        assert not orbit.failure and orbit.return_error < 1e-11
        period = 2 * np.pi / w
        times = np.linspace(0, period, 1001)
        motion = flow.at(w).run(orbit.q, orbit.velocity, period, times=times).q_at[:, 0]
        found = [orbit.q[0], orbit.velocity[0], motion.max(), motion.min(), orbit.contact_fraction]
        np.testing.assert_allclose(found, [x0, v0, largest, least, contact], atol=3e-5)
        assert orbit.largest_multiplier == pytest.approx(mu, abs=2e-6)
        product = np.prod(orbit.multipliers).real
        assert product == pytest.approx(np.exp(-4 * np.pi * 0.01 / w), abs=1e-9)
        assert orbit.stable == (mu < 1) and (orbit.instability == FOLD) == (mu > 1)
        unstable += not orbit.stable
        assert energy_balance(flow.at(w), orbit.q, orbit.velocity, period).error < 1e-10
    assert unstable == 13


@pytest.mark.parametrize(("turn", "expected"), [(0, 1.200297), (1, 1.02256)])
def test_folds_are_where_the_curve_turns_back(turn: int, expected: float) -> None:
    rows, flow = curve(), oscillator()
    turns = np.flatnonzero(np.diff(np.sign(np.diff(rows[:, 0])))) + 1
    assert len(turns) == 2
    before, after = (orbit_at(rows[turns[turn] + step], flow) for step in (-1, 1))
    fold = fold_between(flow, before, after)
    assert not fold.failure
    assert fold.omega == pytest.approx(expected, abs=1e-5)
    assert fold.largest_multiplier == pytest.approx(1.0, abs=1e-6)
    assert "does not turn back" in fold_between(flow, before, before).failure


def test_near_a_fold_the_nearest_motion_has_another_frequency() -> None:
    """At 1.2004, beyond the fold at 1.200297, there is no motion near."""
    rows, flow = curve(), oscillator()
    near = rows[np.argmax(rows[:, 3])]
    assert near[0] == pytest.approx(1.2, abs=5e-4)
    beyond = flow.at(1.2004)
    fixed = driven_orbit(beyond, near[1:2], near[2:3])
    assert fixed.failure or not fixed.contact_fraction
    found = driven_orbit(beyond, near[1:2], near[2:3], keep_frequency=False)
    assert not found.failure
    assert found.omega == pytest.approx(1.2002, abs=2e-4) and found.contact_fraction > 0.2


def test_multipliers_of_linear_motions_are_exponentials() -> None:
    """Any C, also one that drives: exp(d T) of the eigenvalues d of the first-order form."""
    model = ReducedModel(omega=[1.0, 2.3], Phi=[[1.0, 0.4]], R=[[0.2]], gap=[50.0])
    for rate, kind in (([[0.1, 0.3], [-0.3, 0.2]], ""), ([[0.1, 0.3], [0.1, -0.2]], TORUS)):
        flow = DampedFlow(model, np.array(rate), pushed(1.4, np.array([1.0, 0.5])))
        orbit = driven_orbit(flow, np.zeros(2), np.zeros(2))
        matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.diag(model.omega**2), -flow.rate]])
        exact = np.exp(np.linalg.eigvals(matrix) * 2 * np.pi / 1.4)
        found = np.sort_complex(orbit.multipliers)
        np.testing.assert_allclose(found, np.sort_complex(exact), atol=1e-12)
        x = np.linalg.solve(np.diag(model.omega**2 - 1.4**2) + 1.4j * flow.rate, [1.0, 0.5])
        np.testing.assert_allclose(orbit.q, x.real, atol=1e-11)
        assert orbit.instability == kind and orbit.stable == (not kind)


def test_a_period_doubles_where_a_multiplier_is_below_minus_one() -> None:
    """A mass that rests against a stiff stop by a strong constant and harmonic force."""
    model = ReducedModel(omega=[1.0], Phi=[[1.0]], R=[[0.01]], gap=[-0.2])
    flow = DampedFlow(model, np.array([[0.05]]), pushed(2.3, np.array([1.0])))
    found = []
    for omega in np.linspace(1.6, 4.2, 14):
        orbit = driven_orbit(flow.at(omega), np.array([-0.5]), np.array([0.0]))
        found.append(orbit.instability)
    assert DOUBLING in found and "" in found


def test_derivative_by_the_frequency_and_the_state() -> None:
    row, flow = curve()[60], oscillator()
    equations = DrivenMap.around(flow.at(row[0]), row[1:2], row[2:3])
    at = equations.unknowns(row[1:2], row[2:3], row[0])
    at[:2] += [0.03, -0.02]
    jacobian = equations.jacobian(at, equations.miss(at))
    for column in range(3):
        step = 1e-5 * np.eye(3)[column]
        ends = [equations.miss(at + sign * step).values for sign in (1, -1)]
        np.testing.assert_allclose(jacobian[:, column], (ends[0] - ends[1]) / 2e-5, atol=1e-6)
