"""Exact flow against energy, another integrator, reversal, differences."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.flow import Flow

#: Two points that always close together, and one on its own.
TWINS = ReducedModel(
    omega=[1.0, 2.62, 4.1, 6.31],
    Phi=[[1.0, -0.6, 0.7, 0.5], [1.0, -0.6, -0.7, 0.5], [0.4, 0.9, 0.0, -0.3]],
    R=[[0.06, 0.02, 0.01], [0.02, 0.06, 0.01], [0.01, 0.01, 0.05]],
    gap=[1.0, 1.0, 0.8],
)


def random_model(rng: np.random.Generator, modes: int = 12, points: int = 6) -> ReducedModel:
    factor = rng.normal(size=(points, points))
    return ReducedModel(
        omega=np.sort(rng.uniform(1, 30, modes)),
        Phi=rng.normal(size=(points, modes)),
        R=2e-3 * (factor @ factor.T + np.eye(points)),
        gap=rng.uniform(0.5, 1.0, points),
    )


def random_state(rng: np.random.Generator, model: ReducedModel) -> tuple[Array, Array]:
    return 2 * rng.normal(size=model.modes) / model.omega, 2 * rng.normal(size=model.modes)


def by_another_integrator(flow: Flow, q: Array, velocity: Array, span: float) -> Array:
    def rate(time: float, state: Array) -> Array:
        position, speed = np.split(state, 2)
        return np.concatenate([speed, flow.acceleration(position, speed)])

    start = np.concatenate([q, velocity])
    return solve_ivp(rate, (0, span), start, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]


@pytest.mark.parametrize("seed", range(12))
def test_random_models_keep_energy_and_agree_with_another_integrator(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng)
    flow, (q, velocity) = Flow(model), random_state(rng, model)
    period = 2 * np.pi / model.omega[0]
    after = flow.run(q, velocity, 10 * period)
    assert not after.failure
    assert after.changes > 10
    drift = flow.energy(after.q, after.velocity) / flow.energy(q, velocity) - 1
    assert abs(drift) < 1e-12
    short = flow.run(q, velocity, period / 4)
    reference = by_another_integrator(flow, q, velocity, period / 4)
    found = np.concatenate([short.q, short.velocity])
    assert np.abs(found - reference).max() < 1e-8 * np.abs(reference).max()


@pytest.mark.parametrize("seed", [0, 3, 7])
def test_motion_with_reversed_velocities_goes_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng)
    flow, (q, velocity) = Flow(model), random_state(rng, model)
    there = flow.run(q, velocity, 5.0)
    back = flow.run(there.q, -there.velocity, 5.0)
    assert there.changes == back.changes > 5
    np.testing.assert_allclose(back.q, q, atol=1e-10)
    np.testing.assert_allclose(back.velocity, -velocity, atol=1e-9)


def test_transition_is_symplectic_and_the_derivative_of_the_flow() -> None:
    rng = np.random.default_rng(2)
    model = random_model(rng, modes=5, points=3)
    flow, (q, velocity), span = Flow(model), random_state(rng, model), 4.0
    whole = flow.run(q, velocity, span, along=np.eye(2 * len(q)))
    assert whole.transition is not None
    assert whole.changes >= 4
    form = np.block([[np.zeros((5, 5)), np.eye(5)], [-np.eye(5), np.zeros((5, 5))]])
    defect = whole.transition.T @ form @ whole.transition - form
    assert np.abs(defect).max() < 1e-12 * np.abs(whole.transition).max() ** 2
    step = 1e-6
    for column in range(10):
        change = step * (np.arange(10) == column)
        ends = [flow.run(q + s * change[:5], velocity + s * change[5:], span) for s in (1, -1)]
        ahead, behind = (np.concatenate([end.q, end.velocity]) for end in ends)
        difference = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(whole.transition[:, column], difference, rtol=1e-6, atol=1e-6)


def test_wanted_times_lie_on_the_motion() -> None:
    rng = np.random.default_rng(4)
    model = random_model(rng)
    flow, (q, velocity) = Flow(model), random_state(rng, model)
    times = np.array([0.0, 0.3, 1.1, 1.1, 2.0])
    whole = flow.run(q, velocity, 2.0, times=times)
    np.testing.assert_allclose(whole.q_at[0], q, atol=1e-14)
    for time, position, speed in zip(times, whole.q_at, whole.velocity_at, strict=True):
        part = flow.run(q, velocity, time)
        np.testing.assert_allclose(position, part.q, atol=1e-12)
        np.testing.assert_allclose(speed, part.velocity, atol=1e-11)


@pytest.mark.parametrize("antisymmetric", [0.0, 1e-14, 1e-9])
def test_points_that_close_at_one_instant(antisymmetric: float) -> None:
    flow = Flow(TWINS)
    q, velocity = np.array([-1.5, 0.1, antisymmetric, 0.05]), np.zeros(4)
    after = flow.run(q, velocity, 40.0)
    assert not after.failure
    assert 10 < after.changes < 200
    assert flow.energy(after.q, after.velocity) == pytest.approx(
        flow.energy(q, velocity), rel=1e-13
    )
    reference = by_another_integrator(flow, q, velocity, 7.0)
    seven = flow.run(q, velocity, 7.0)
    np.testing.assert_allclose([*seven.q, *seven.velocity], reference, atol=1e-9)


@pytest.mark.parametrize("beyond", [-1e-6, -1e-12, 0.0, 1e-12, 1e-6])
def test_grazing_from_rest_and_in_passing(beyond: float) -> None:
    """The force is beyond / R at most, so the motion is a cosine up to about beyond / R."""
    model = ReducedModel([1.0], [[1.0]], [[0.01]], [1.0])
    flow, amplitude = Flow(model), 1.0 + beyond
    period = 2 * np.pi
    for start in (amplitude, -amplitude):  # begins at the turning point, or passes through it
        after = flow.run(np.array([start]), np.zeros(1), 3 * period)
        assert after.q[0] == pytest.approx(start, abs=max(200 * abs(beyond), 1e-12))
        assert after.changes <= 8
        assert after.contact_time < (0.02 if beyond <= 1e-12 else 3 * period / 50)


def test_a_dip_between_two_samples_of_a_slow_motion_is_found() -> None:
    """A fast mode of small amplitude closes the gap for less than 1e-3 of the period."""
    model = ReducedModel([1.0, 300.0], [[1.0, 1.0]], [[1e-3]], [1.0])
    flow = Flow(model)
    q, velocity = np.array([-1.0 + 1.1e-3, 0.0]), np.array([0.0, 1.2e-3 * 300])
    after = flow.run(q, velocity, 2 * np.pi, times=np.linspace(0, 2 * np.pi, 200_001))
    beyond = (after.q_at @ model.Phi[0] - 1.0) > 0
    assert after.changes == np.count_nonzero(np.diff(beyond.astype(int))) > 0
    assert after.contact_time < 1e-2 * 2 * np.pi


def test_zero_time_and_motion_without_contact() -> None:
    flow = Flow(TWINS)
    q, velocity = np.array([0.1, 0.02, 0.0, 0.01]), np.array([0.0, 0.1, 0.1, 0.0])
    still = flow.run(q, velocity, 0.0)
    np.testing.assert_array_equal(still.q, q)
    after, span = flow.run(q, velocity, 100.0), 100.0
    assert after.changes == 0
    exact = q * np.cos(TWINS.omega * span) + velocity / TWINS.omega * np.sin(TWINS.omega * span)
    np.testing.assert_allclose(after.q, exact, atol=1e-14)


def test_what_cannot_be_followed_has_a_reason() -> None:
    flow = Flow(TWINS, most_changes=3)
    given_up = flow.run(np.array([-1.5, 0.1, 0.3, 0.05]), np.zeros(4), 40.0)
    assert "more than 3 changes of contact" in given_up.failure
    lost = flow.run(np.array([np.nan, 0.0, 0.0, 0.0]), np.zeros(4), 1.0)
    assert "not finite" in lost.failure
    with pytest.raises(ModelError, match="without mass"):
        Flow(ReducedModel([1.0], [[1.0]], [[0.0]], [1.0], contact=MASSIVE))
