"""Steps in time against the exact flow, the exact Duffing oscillator, and differences."""

import numpy as np
import pytest
from scipy.special import ellipk

from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.force import CubicSprings
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.stepped import Stepped

MODEL = ReducedModel(
    omega=[1.0, 2.62, 6.31],
    Phi=[[1.0, -0.6, 0.5], [0.7, 0.4, -0.8]],
    R=[[0.06, 0.02], [0.02, 0.05]],
    gap=[1.0, 0.9],
)


def test_same_motion_as_the_exact_flow() -> None:
    q, v = np.array([1.4, 0.1, -0.05]), np.array([0.2, -0.1, 0.3])
    times, along = np.linspace(0.0, 12.0, 7), np.eye(6)
    flow, stepped = Flow(MODEL), Stepped(Mechanics.of(MODEL))
    exact = flow.run(q, v, 12.0, times=times, along=along, speeds=True)
    found = stepped.run(q, v, 12.0, times=times, along=along, speeds=True)
    assert not found.failure and exact.changes > 4
    np.testing.assert_allclose(found.q_at, exact.q_at, atol=1e-8)
    np.testing.assert_allclose(found.velocity_at, exact.velocity_at, atol=1e-8)
    assert found.transition is not None
    np.testing.assert_allclose(found.transition, exact.transition, atol=1e-5)
    assert found.speed_integral == pytest.approx(exact.speed_integral, rel=1e-9)
    assert found.contact_time == pytest.approx(exact.contact_time, rel=0.1)
    assert stepped.energy(q, v) == pytest.approx(flow.energy(q, v), rel=1e-14)
    assert stepped.energy(found.q, found.velocity) == pytest.approx(flow.energy(q, v), rel=1e-9)
    gradients = stepped.energy_gradient(q, v), flow.energy_gradient(q, v)
    np.testing.assert_allclose(*gradients, atol=1e-12)
    assert stepped.run(q, v, 1.0).transition is None


def test_duffing_oscillator_comes_back_after_its_exact_period() -> None:
    model = ReducedModel([1.0], [[1.0]], [[0.1]], [10.0])
    stepped = Stepped(Mechanics.of(model, (CubicSprings(np.array([[1.0]]), np.array([0.7])),)))
    a = 1.3
    stiff = 1 + 0.7 * a**2
    period = 4 * ellipk(0.7 * a**2 / (2 * stiff)) / np.sqrt(stiff)
    after = stepped.run(np.array([a]), np.zeros(1), period)
    assert after.q[0] == pytest.approx(a, rel=1e-10)
    assert abs(after.velocity[0]) < 1e-9
    assert stepped.energy(np.array([a]), np.zeros(1)) == pytest.approx(a**2 / 2 + 0.7 * a**4 / 4)


def test_derivative_along_changes_of_the_start_against_differences() -> None:
    springs = CubicSprings(np.array([[0.5, 0.2, -0.4]]), np.array([0.9]))
    stepped = Stepped(Mechanics.of(MODEL, (springs,)))
    state = np.array([1.3, 0.2, -0.1, 0.1, 0.3, -0.2])
    found = stepped.run(state[:3], state[3:], 5.0, along=np.eye(6)).transition
    assert found is not None

    def slope(d: np.ndarray) -> np.ndarray:
        one, other = (stepped.run((state + s * d)[:3], (state + s * d)[3:], 5.0) for s in (1, -1))
        return np.concatenate([one.q - other.q, one.velocity - other.velocity]) / (2 * d.max())

    for column, d in enumerate(np.eye(6)):
        # of three: a step over a change of contact has an error of 4e-8 in one of 250 runs
        slopes = [slope(step * d) for step in (7e-6, 1e-5, 1.4e-5)]
        error = np.abs(found[:, column] - np.median(slopes, axis=0)).max()
        assert error < 1e-5 * np.abs(found).max()


def test_what_steps_cannot_follow_is_refused() -> None:
    with pytest.raises(ModelError, match="positive gaps"):
        Stepped(Mechanics.of(ReducedModel([1.0], [[1.0]], [[0.1]], [-0.1])))
    few = Stepped(Mechanics.of(MODEL), most_steps=5)
    assert "more than 5 steps" in few.run(np.ones(3), np.zeros(3), 100.0).failure
