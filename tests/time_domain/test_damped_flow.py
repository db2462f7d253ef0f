"""Damped and driven motion in time against closed forms, another integrator, differences."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import CubicSprings
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.moving_gap import GapMotion
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.energy_balance import energy_balance
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.propagators import Dense

#: A mass that touches nothing.
FREE = ReducedModel(omega=[2.0], Phi=[[1.0]], R=[[0.1]], gap=[1e3])


def drive(omega: float, *parts: tuple[int, Array, Array]) -> Drive:
    """Forces by harmonic, cosine and sine."""
    return Drive.of(omega, [Excitation(*part) for part in parts], len(parts[0][1]))


def still(modes: int) -> Drive:
    return Drive.of(1.0, (), modes)


def random_flow(seed: int) -> tuple[DampedFlow, Array, Array]:
    """A model with any C, one that also feeds energy, forces in two harmonics, and a state."""
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(3, 3))
    model = ReducedModel(
        omega=np.sort(rng.uniform(1, 12, 5)),
        Phi=rng.normal(size=(3, 5)),
        R=5e-3 * (factor @ factor.T + np.eye(3)),
        gap=rng.uniform(0.4, 0.8, 3),
    )
    rate = 0.3 * rng.normal(size=(5, 5)) + np.diag(rng.uniform(-0.1, 0.5, 5))
    forces = drive(1.7, (1, *3 * rng.normal(size=(2, 5))), (3, *rng.normal(size=(2, 5))))
    flow = DampedFlow(model, rate, forces)
    return flow, rng.normal(size=5) / model.omega, rng.normal(size=5)


@pytest.mark.parametrize("zeta", [0.02, -0.03, 0.7, 1.0, 1.8])
def test_free_damped_motion_has_its_closed_form(zeta: float) -> None:
    """Also beyond critical damping, at it, and with damping that drives the motion."""
    omega, flow = 2.0, DampedFlow(FREE, np.array([[4.0 * zeta]]), still(1))
    times = np.linspace(0, 6, 13)
    root = np.sqrt(complex(zeta**2 - 1)) * omega
    shape = np.sinh(root * times) / root if root else times
    exact = np.exp(-zeta * omega * times) * (
        0.5 * np.cosh(root * times) + (0.3 + zeta * omega * 0.5) * shape
    )
    found = flow.run(np.array([0.5]), np.array([0.3]), 6.0, times=times)
    np.testing.assert_allclose(found.q_at[:, 0], exact.real, atol=1e-13)
    dense = isinstance(flow.book.at(np.zeros(2)).propagator, Dense)
    assert dense == (zeta == 1.0)


@pytest.mark.parametrize("distance", [0.0, 1e-13, 1e-6, 0.3])
def test_resonance_without_damping_grows_as_it_must(distance: float) -> None:
    """X = f (cos w t - cos 2 t) / (4 - w^2) from rest, f t sin(2 t) / 4 in resonance."""
    omega, times = 2.0 + distance, np.linspace(0, 40, 17)
    flow = DampedFlow(FREE, np.zeros((1, 1)), drive(omega, (1, np.ones(1), np.zeros(1))))
    found = flow.run(np.zeros(1), np.zeros(1), 40.0, times=times, speeds=True)
    middle, half = (omega + 2) / 2 * times, (omega - 2) / 2 * times
    exact = times * np.sin(middle) * np.sinc(half / np.pi) / (omega + 2)
    np.testing.assert_allclose(found.q_at[:, 0], exact, atol=2e-13)


def test_critical_damping_in_forced_motion() -> None:
    """The steady part of a critically damped mass under cos and sin: by the complex amplitude."""
    flow = DampedFlow(FREE, np.array([[4.0]]), drive(1.3, (1, np.array([2.0]), np.array([0.7]))))
    x = (2.0 - 0.7j) / (4 - 1.3**2 + 4j * 1.3)
    start = np.array([x.real]), np.array([(1.3j * x).real])
    found = flow.run(*start, 5.0, times=np.linspace(0, 5, 9))
    exact = (x * np.exp(1.3j * np.linspace(0, 5, 9))).real
    np.testing.assert_allclose(found.q_at[:, 0], exact, atol=1e-13)


@pytest.mark.parametrize(("seed", "moved"), [*((n, 0.0) for n in range(6)), (4, 0.3)])
def test_random_models_agree_with_another_integrator_and_balance_energy(
    seed: int, moved: float
) -> None:
    """Also past gaps that move."""
    flow, q, velocity = random_flow(seed)
    if moved:
        rng = np.random.default_rng(seed)
        parts = moved * (rng.normal(size=(2, 3)) + 1j * rng.normal(size=(2, 3)))
        flow = flow.driven_by(replace(flow.drive, gap=GapMotion((1, 2), parts)))

    def rate(time: float, state: Array) -> Array:
        position, speed = np.split(state, 2)
        pulled = flow.acceleration(position, speed, 0.4 + 1.7 * time)
        return np.concatenate([speed, pulled])

    start = np.concatenate([q, velocity])
    reference = solve_ivp(rate, (0, 3), start, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    found = flow.run(q, velocity, 3.0, phase=0.4)
    assert found.changes >= 4
    ends = np.concatenate([found.q, found.velocity])
    np.testing.assert_allclose(ends, reference, atol=2e-8 * np.abs(reference).max())
    balance = energy_balance(flow, q, velocity, 3.0, phase=0.4)
    assert balance.error < 1e-12
    assert min(abs(balance.work), abs(balance.dissipated), abs(balance.change)) > 1e-3


def test_transition_is_the_derivative_of_the_flow() -> None:
    flow, q, velocity = random_flow(3)
    start, small = np.concatenate([q, velocity]), 1e-6
    whole = flow.run(q, velocity, 3.0, along=np.eye(10))
    for column in range(10):
        ends = []
        for sign in (1, -1):
            moved = start + sign * small * np.eye(10)[column]
            after = flow.run(*np.split(moved, 2), 3.0)
            ends.append(np.concatenate([after.q, after.velocity]))
        difference = (ends[0] - ends[1]) / (2 * small)
        np.testing.assert_allclose(whole.transition[:, column], difference, atol=1e-6)


def test_without_damping_and_force_it_is_the_conservative_flow() -> None:
    flow, q, velocity = random_flow(4)
    alone = DampedFlow(flow.model, np.zeros((5, 5)), still(5))
    times = np.linspace(0, 8, 5)
    found, known = (
        each.run(q, velocity, 8.0, times=times, along=np.eye(10), speeds=True)
        for each in (alone, Flow(flow.model))
    )
    assert found.changes == known.changes > 6
    for name in ("q_at", "velocity_at", "transition", "contact_time", "speed_integral"):
        np.testing.assert_allclose(getattr(found, name), getattr(known, name), atol=1e-10)
    assert alone.energy(q, velocity) == Flow(flow.model).energy(q, velocity)


def test_stages_are_shared_between_frequencies() -> None:
    flow, q, velocity = random_flow(5)
    other = flow.at(2.4)
    assert other.book is flow.book and other.drive.omega == 2.4 and flow.drive.omega == 1.7
    alone = DampedFlow(flow.model, flow.rate, flow.drive.at(2.4))
    np.testing.assert_array_equal(other.run(q, velocity, 2.0).q, alone.run(q, velocity, 2.0).q)


def test_what_it_cannot_follow_is_refused() -> None:
    massive = ReducedModel([1.0], [[1.0]], [[0.0]], [1.0], contact=MASSIVE)
    with pytest.raises(ModelError, match="without mass"):
        DampedFlow(massive, np.zeros((1, 1)), still(1))
    spring = CubicSprings(np.ones((1, 1)), np.ones(1))
    part = RatedPart(FREE.omega, np.zeros((1, 1)))
    with pytest.raises(ModelError, match="not linear"):
        DampedFlow.of(Mechanics(FREE, FREE.at_rest(), part, (spring,)), 1.0)
    flow = DampedFlow(FREE, np.zeros((1, 1)), still(1), most_changes=0)
    assert not flow.run(np.zeros(1), np.ones(1), 1.0).failure
    assert "finite" in flow.run(np.array([np.nan]), np.ones(1), 1.0).failure
    few = DampedFlow(random_flow(3)[0].model, np.eye(5), still(5), most_changes=2)
    assert "more than 2 changes" in few.run(*random_flow(3)[1:], 3.0).failure
