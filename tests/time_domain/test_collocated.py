"""Motion in time with second-order kinematics, against Runge-Kutta steps, and its derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bent_body import BentBody

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.time_domain.collocated import Collocated
from fenics_nnm.time_domain.exponential_rule import Weights, gauss_nodes
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.margins import Margins
from fenics_nnm.time_domain.shooting import OrbitGuess, shoot
from fenics_nnm.time_domain.smooth_stage import SmoothStage
from fenics_nnm.time_domain.stability import stability
from fenics_nnm.time_domain.stepped import Stepped, integrator_of

BODY = BentBody.random(6, 2, seed=3)
MODEL = replace(BODY.reduction(4, np.array([0, 2])).model, gap=np.array([0.1, 0.12]))
Q, V = np.array([0.2, 0.05, -0.1, 0.02]), np.array([0.1, 0.05, 0.1, -0.1])
SPAN = 9.0
RNG = np.random.default_rng(8)


def test_same_motion_as_runge_kutta_steps_at_their_error() -> None:
    flow, stepped = Collocated(Mechanics.of(MODEL)), Stepped(Mechanics.of(MODEL), tolerance=1e-9)
    times = np.linspace(0.0, SPAN, 5)
    found = flow.run(Q, V, SPAN, times=times, speeds=True)
    other = stepped.run(Q, V, SPAN, times=times, speeds=True)
    assert not found.failure and found.changes > 4 and found.changes == other.changes
    np.testing.assert_allclose(found.q_at, other.q_at, atol=1e-7)
    np.testing.assert_allclose(found.velocity_at, other.velocity_at, atol=1e-6)
    assert found.speed_integral == pytest.approx(other.speed_integral, rel=1e-7)
    assert found.contact_time == pytest.approx(other.contact_time, rel=0.1)
    assert flow.energy(found.q, found.velocity) == pytest.approx(flow.energy(Q, V), rel=1e-12)
    for name in ("acceleration", "energy_gradient"):
        one, two = (getattr(each, name)(Q, V) for each in (flow, stepped))
        np.testing.assert_allclose(one, two, atol=1e-12)


def test_error_is_far_below_what_a_verdict_asks_for() -> None:
    """More nodes and a smaller tolerance, half the step, change the end by 1e-12 of the motion."""
    coarse = Collocated(Mechanics.of(MODEL)).run(Q, V, SPAN)
    fine = Collocated(Mechanics.of(MODEL), nodes=24, tolerance=1e-12).run(Q, V, SPAN)
    np.testing.assert_allclose(coarse.q, fine.q, atol=2e-13)
    np.testing.assert_allclose(coarse.velocity, fine.velocity, atol=2e-12)


def test_rough_motion_is_far_better_than_what_it_is_compared_with() -> None:
    """Returns of 0.02 after ten periods, and of 0.05 after one, are what verdicts ask for."""
    fine, span = Collocated(Mechanics.of(MODEL)), 10 * 2 * np.pi / MODEL.omega[0]
    rough = fine.rough.run(Q, V, span)
    exact = fine.run(Q, V, span)
    size = np.sqrt(2 * fine.energy(Q, V))
    missed = np.hypot(MODEL.omega * (rough.q - exact.q), rough.velocity - exact.velocity)
    assert exact.changes > 20
    assert np.linalg.norm(missed) / size < 1e-7
    assert fine.energy(rough.q, rough.velocity) == pytest.approx(fine.energy(Q, V), rel=1e-7)


def test_derivatives_are_of_the_motion_that_was_followed() -> None:
    """Asked for later, or once more, they are of the same steps."""
    flow = Collocated(Mechanics.of(MODEL))
    first = flow.run(Q, V, 4.0, along=np.eye(8))
    assert flow.run(Q, V, 4.0).transition is None
    again = flow.run(Q, V, 4.0, along=np.eye(8)[:, 2:5])
    assert first.transition is not None and again.transition is not None
    np.testing.assert_allclose(first.transition[:, 2:5], again.transition, atol=1e-12)
    assert flow.course(Q, V, 4.0) is flow.course(Q.copy(), V.copy(), 4.0)


def test_longer_course_goes_on_where_a_shorter_one_was_left() -> None:
    """To the digit as if it was followed at once, and the shorter one after it, too."""
    flow, fresh = Collocated(Mechanics.of(MODEL)), Collocated(Mechanics.of(MODEL))
    shorter, longer = flow.course(Q, V, 4.0), flow.course(Q, V, SPAN)
    at_once, cut = fresh.course(Q, V, SPAN), fresh.course(Q, V, 4.0)
    for one, other in ((shorter, cut), (longer, at_once)):
        np.testing.assert_array_equal(np.array(one.end), np.array(other.end))
        assert one.changes == other.changes
    shared = [one.step is other.step for one, other in zip(shorter.parts, longer.parts)]
    assert all(shared) and len(shared) == len(shorter.parts) < len(longer.parts)
    assert sum(part.passed for part in shorter.parts) == pytest.approx(4.0, rel=1e-14)
    state = longer.states(np.array([4.0]))
    np.testing.assert_allclose(np.array(shorter.end), np.array(state)[:, 0], atol=1e-13)


def test_acceleration_and_margins_by_few_numbers_are_those_of_the_whole() -> None:
    flow = Collocated(Mechanics.of(MODEL))
    for q in (Q, 3 * np.abs(Q), -3 * np.abs(Q)):
        stage = flow.stage_at(q)
        found = stage.acceleration(q[None], V[None])[0]
        np.testing.assert_allclose(flow.acceleration(q, V), found, atol=1e-12)
        motion = np.column_stack([(q - stage.linear.rest) @ stage.linear.V, V @ stage.linear.V])
        margins, rates, _ = stage.course.along(motion)
        for point in range(2):
            expected = margins[point, 0], rates[point, 0]
            assert stage.course.of_point(point, motion) == pytest.approx(expected, abs=1e-13)


def test_shooting_ends_at_the_error_of_the_integrator() -> None:
    """Its bound is above what more nodes and a smaller tolerance change, see above."""
    flow = Collocated(Mechanics.of(MODEL))
    assert flow.error == pytest.approx(1e-11)
    assert Flow(MODEL).error < flow.error < flow.rough.error


def test_derivative_along_changes_of_the_start_against_differences() -> None:
    flow, step = Collocated(Mechanics.of(MODEL)), 1e-5
    state = np.concatenate([Q, V])
    found = flow.run(Q, V, 4.0, along=np.eye(8)).transition
    assert found is not None
    for column, d in enumerate(step * np.eye(8)):
        ends = [flow.run(*np.split(state + sign * d, 2), 4.0) for sign in (1, -1)]
        slope = np.concatenate([ends[0].q - ends[1].q, ends[0].velocity - ends[1].velocity])
        np.testing.assert_allclose(found[:, column], slope / (2 * step), atol=2e-6)


def test_derivatives_of_the_energy_against_differences() -> None:
    flow, touched = Collocated(Mechanics.of(MODEL)), False
    for q in (Q, 3 * np.abs(Q), -3 * np.abs(Q)):
        _compare(flow, q, 1e-6)
        touched |= flow.stage_at(q).active.any()
    assert touched


def _compare(flow: Collocated, q: Array, step: float) -> None:
    gradient = flow.energy_gradient(q, V)
    for j, d in enumerate(step * np.eye(4)):
        assert gradient[j] == pytest.approx(
            (flow.energy(q + d, V) - flow.energy(q - d, V)) / (2 * step), abs=1e-7
        )
        assert gradient[4 + j] == pytest.approx(
            (flow.energy(q, V + d) - flow.energy(q, V - d)) / (2 * step), abs=1e-7
        )


@pytest.mark.parametrize("masters", [[0], [0, 2], [0, 1, 3]])
def test_remainder_is_what_the_acceleration_lacks_of_linear_motion(masters: list[int]) -> None:
    model = replace(BODY.reduction(4, np.array(masters)).model, gap=MODEL.gap)
    for held in ([False, False], [True, False], [True, True]):
        stage = SmoothStage.of(Mechanics.of(model), np.array(held))
        linear, q, v = stage.linear, RNG.normal(size=(3, 4)), RNG.normal(size=(3, 4))
        seen = stage.seen(q, v)
        found = (linear.V @ stage.remainder.directions @ stage.remainder(seen)).T
        pull = ((q - linear.rest) @ linear.V * linear.nu**2) @ linear.V.T
        np.testing.assert_allclose(found, stage.acceleration(q, v) + pull, atol=1e-11)
        changes = 1e-6 * np.eye(stage.remainder.seen)
        moved = (stage.remainder(seen[:, :1] + sign * changes) for sign in (1, -1))
        slopes = stage.remainder.slopes(seen)[0]
        differences = np.subtract(*moved) / 2e-6
        np.testing.assert_allclose(slopes, differences, atol=1e-6 * np.abs(slopes).max())


def test_margins_along_a_stage_are_those_of_its_states() -> None:
    stage = SmoothStage.of(Mechanics.of(MODEL), np.array([True, False]))
    x, rate, step = RNG.normal(size=(3, 4)), RNG.normal(size=(3, 4)), 1e-6
    margins, rates, size = stage.course.along(np.concatenate([x, rate]).T)
    q = stage.linear.rest + x @ stage.linear.V.T
    closed, other = stage.excess(q).T
    np.testing.assert_allclose(margins[0], closed, atol=1e-12)
    given_way = MODEL.R[1, 0] / MODEL.R[0, 0] * closed
    np.testing.assert_allclose(margins[1], given_way - other, atol=1e-12)
    np.testing.assert_allclose(stage.margins(q[0]), margins[:, 0], atol=1e-12)
    np.testing.assert_allclose(size, np.abs(margins).max(axis=1) + MODEL.gap)
    ends = [stage.course.at((x + sign * step * rate).T) for sign in (1, -1)]
    np.testing.assert_allclose(rates, (ends[0] - ends[1]) / (2 * step), atol=1e-7)


def test_flow_is_symplectic_in_coordinates_and_momenta() -> None:
    """Without momenta, by velocities alone, the error would be of the order of D q^2."""
    flow = integrator_of(Mechanics.of(MODEL))
    assert isinstance(flow, Collocated)
    q, v = np.array([0.03, 0.0, 0.0, 0.0]), np.zeros(4)
    guess = OrbitGuess(q, v, 2 * np.pi / MODEL.omega[0], flow.energy(q, v), False, True)
    shot = shoot(flow, guess)
    assert shot.converged, shot.failure
    assert shot.return_error < 1e-11
    found = stability(flow, shot, reversible=True)
    assert found.symplectic_error < 1e-12 and found.trivial_error < 1e-10
    np.testing.assert_allclose(np.abs(found.multipliers), 1.0, atol=1e-8)
    general = stability(flow, shot)
    assert general.symplectic_error < 1e-9  # multipliers count as on the circle within 1e-6
    both = (each.multipliers for each in (found, general))
    in_order = (multipliers[np.argsort(np.angle(multipliers))] for multipliers in both)
    np.testing.assert_allclose(*in_order, atol=1e-7)


def test_without_second_order_it_is_the_exact_flow() -> None:
    model = MODEL.linearised
    found = Collocated(Mechanics.of(model)).run(Q, V, SPAN, along=np.eye(8))
    exact = Flow(model).run(Q, V, SPAN, along=np.eye(8))
    assert exact.changes == found.changes > 4
    np.testing.assert_allclose(found.q, exact.q, atol=1e-13)
    np.testing.assert_allclose(found.transition, exact.transition, atol=1e-8)


def test_oscillator_under_a_polynomial_force_is_exact_however_fast_it_is() -> None:
    nu, step = np.array([0.3, 400.0]), 0.5
    nodes = gauss_nodes(5)
    force = 1 + nodes.at**3
    weights = Weights.of(nodes, nu, step, np.array([step]))
    x, rate = weights.motion(np.zeros(2), np.zeros(2), np.tile(force, (2, 1))).T
    # x'' + nu^2 x = 1 + (t/h)^3 has the particular solution (1 + s^3 - 6 s / (nu h)^2) / nu^2
    bend = 6 / (nu * step) ** 2
    exact = (2 - bend) / nu**2 - np.cos(nu * step) / nu**2 + bend * np.sin(nu * step) / nu**3 / step
    np.testing.assert_allclose(x, exact, rtol=1e-11)
    slope = (
        (3 - bend) / step / nu**2
        + np.sin(nu * step) / nu
        + bend * np.cos(nu * step) / (nu**2 * step)
    )
    np.testing.assert_allclose(rate, slope, rtol=1e-11)


def test_first_change_is_found_also_between_the_times_looked_at() -> None:
    times = np.linspace(0.0, 1.0, 6)

    def exact(point: int, time: float) -> tuple[float, float]:
        return (time - 0.5) ** 2 - 1e-4, 2 * (time - 0.5)

    values = np.array([exact(0, float(time)) for time in times])
    margins = Margins(times, values[:, :1], values[:, 1:], np.array([-1e-15]))
    assert margins.first_negative(exact) == pytest.approx(0.49, abs=1e-12)
    assert values[:, 0].min() > 0


def test_margins_that_stay_well_above_zero_are_not_looked_at_closely() -> None:
    """The first falls through zero, the second turns at 0.6, the third nearly at zero."""
    times, lowest = np.linspace(0.0, 1.0, 9), np.array([-1.0, 0.6, 1e-4])
    asked = set()

    def exact(point: int, time: float) -> tuple[float, float]:
        asked.add(point)
        bend = 4 * (1 - lowest[point])
        return lowest[point] + bend * (time - 0.55) ** 2, 2 * bend * (time - 0.55)

    values = np.array([[exact(point, float(time)) for point in range(3)] for time in times])
    asked.clear()
    margins = Margins(times, values[:, :, 0], values[:, :, 1], np.full(3, -1e-15))
    first = 0.55 - np.sqrt(1 / 8)
    assert margins.first_negative(exact) == pytest.approx(first, abs=1e-12)
    assert asked == {0}
    others = Margins(times, values[:, 1:, 0], values[:, 1:, 1], np.full(2, -1e-15))
    asked.clear()
    assert others.first_negative(lambda point, time: exact(point + 1, time)) == 1.0
    assert asked == {2}
