"""Driven structures in time: settling, sweeps through folds, motions of several periods."""

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.simulation import Simulation, settled, simulation
from fenics_nnm.response.watched import Watched
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.drive import Drive

REST = np.zeros(1), np.zeros(1)


def oscillator(
    *, rate: float = 0.02, force: float = 0.05, flexibility: float = 0.25, gap: float = 1.0
) -> DampedFlow:
    model = ReducedModel(omega=[1.0], Phi=[[1.0]], R=[[flexibility]], gap=[gap])
    push = Excitation(1, np.array([force]), np.zeros(1))
    return DampedFlow(model, np.array([[rate]]), Drive.of(1.0, (push,), 1))


def places(flow: DampedFlow) -> Watched:
    """The mass, and its contact point, which is held while it touches."""
    return Watched(("mass", "contact 1"), np.ones((2, 1)), np.array([[0.0], flow.model.R[0]]))


def swept(flow: DampedFlow, omegas: Array, start: tuple[Array, Array] = REST) -> Simulation:
    return simulation(flow, places(flow), omegas / (2 * np.pi), start)


def test_linear_motion_from_rest_has_its_closed_form() -> None:
    """Steady motion and free decay with the undisturbed complex amplitude."""
    flow, w = oscillator(gap=50.0), 1.1
    found = swept(flow, np.full(40, w))
    x = 0.05 / (1 - w**2 + 0.02j * w)
    turns = np.sqrt(1 - 0.01**2)
    decay = np.linalg.solve([[1, 0], [-0.01, turns]], [-x.real, -(1j * w * x).real])
    times = 2 * np.pi / w * np.arange(40)
    free = np.exp(-0.01 * times) * (
        decay[0] * np.cos(turns * times) + decay[1] * np.sin(turns * times)
    )
    np.testing.assert_allclose(found.of("time"), times, rtol=1e-13)
    np.testing.assert_allclose(found.of("section")[:, 0], x.real + free, atol=1e-12)
    assert not found.of("contact_fraction").any() and not found.failure
    np.testing.assert_allclose(found.of("energy")[0], 0.0, atol=1e-15)


def test_sweeps_up_and_down_jump_at_the_folds() -> None:
    """Folds of the reference curve: 1.200297 upwards from the large motion, 1.02256 downwards."""
    flow = oscillator()
    up = np.repeat(np.linspace(0.93, 1.25, 110), 4)
    found = swept(flow, up)
    heights = found.of("amplitude")[:, 0]
    falls = 2 * np.pi * found.of("frequency")[np.argmin(np.diff(heights))]
    assert 1.195 < falls < 1.23
    down = swept(flow, up[:80:-1], (found.q, found.velocity))
    rises = 2 * np.pi * down.of("frequency")[np.flatnonzero(down.of("largest")[:, 0] > 1.05)[0]]
    assert 0.98 < rises < 1.0226
    mass, contact = found.of("largest").max(axis=0)
    assert contact == pytest.approx(1.0, abs=1e-12) and 1.6 < mass < 1.9


def test_a_motion_from_rest_settles_on_the_stable_motion() -> None:
    """Row w = 0.99769287 of the reference curve: x0 = 0.95325796, multiplier 0.938965."""
    flow, w = oscillator(), 0.99769287
    found = swept(flow, np.full(250, w))
    at = settled(flow, found.q, found.velocity, w / 2 / np.pi)
    assert at.periods == 1 and at.distance < 1e-5
    assert at.orbit.q[0] == pytest.approx(0.95325796, abs=1e-6)
    assert found.of("section")[-1, 0] == pytest.approx(0.95325796, abs=1e-5)
    assert found.of("largest")[-1, 0] == pytest.approx(1.0717555, abs=1e-4)
    assert found.of("least")[-1, 0] == pytest.approx(-1.0795690, abs=1e-4)
    assert found.of("contact_fraction")[-1] == pytest.approx(0.1075, abs=1e-4)
    assert "settled on a stable motion that repeats after a period of" in str(at)
    assert settled(flow, *REST, w / 2 / np.pi).periods == 0


def test_motions_of_several_periods_and_such_that_never_repeat() -> None:
    """A mass at a stiff stop without gap: after 1, 2 and 3 periods of the force, and never."""
    flow = oscillator(rate=0.1, force=1.0, flexibility=0.002, gap=0.0)
    for w, repeats in ((2.4, 1), (3.6, 2), (5.6, 3), (2.8, 0)):
        found = swept(flow, np.full(90, w))
        at = settled(flow, found.q, found.velocity, w / 2 / np.pi)
        assert at.periods == repeats
        section = found.of("section")[:, 0]
        last = section[-repeats:] if repeats else section[-8:]
        assert (np.ptp(last) > 0.1) == (repeats != 1)
        assert repeats == 0 or abs(section[-1] - section[-1 - repeats]) < 0.02
    assert "has not settled on a motion of up to 8 periods" in str(at)


def test_motions_that_are_given_up_keep_what_they_have() -> None:
    flow = oscillator()
    few = DampedFlow(flow.model, flow.rate, flow.drive, most_changes=0)
    found = swept(few, np.full(60, 1.0))
    assert found.failure.startswith("given up in period") and 5 < len(found.of("frequency")) < 60
