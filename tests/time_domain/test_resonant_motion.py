"""Motions in phase resonance by shooting: derivatives, closed forms, an exact forced response."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.resonant_map import ResonantMap
from fenics_nnm.time_domain.resonant_motion import (
    ResonantMotion,
    driven_by_push,
    resonant_motion,
)
from fenics_nnm.time_domain.stretch_means import (
    _by_quadrature,
    _gradients_by_quadrature,
    gradients_of,
    integrals,
)
from fenics_nnm.time_domain.virial import virial_error

OSCILLATOR = ReducedModel(np.ones(1), np.ones((1, 1)), np.array([[0.25]]), np.ones(1))
TWO = ReducedModel(
    np.array([1.0, 2.7]), np.array([[1.0, -0.7]]), np.array([[0.25]]), np.array([1.0])
)


@pytest.mark.parametrize("rate", [np.diag([0.02, 0.16]), np.array([[2.0, 0.3], [0.3, 5.4]])])
def test_jacobian_against_differences(rate: np.ndarray) -> None:
    """Beside a motion in contact; the second C, near critical damping, couples the modes."""
    push = np.array([1.0, 0.8])
    equations = ResonantMap(driven_by_push(TWO, rate, push), push, 0.35, 1.05, 0.03)
    at = equations.unknowns(np.array([1.2, 0.05]), np.array([0.1, -0.2]), 1.08, 0.04)
    found, step = equations.linearised(at), 1e-6
    assert found.course.changes > 0
    for column, unit in enumerate(np.eye(len(at))):
        ahead, behind = (equations.missed(at + sign * step * unit).values for sign in (1, -1))
        slope = (ahead - behind) / (2 * step)
        scale = max(1.0, float(np.abs(slope).max()))
        assert np.abs(found.jacobian[:, column] - slope).max() < 2e-6 * scale


def test_linear_motion_of_two_modes_is_the_closed_form() -> None:
    """A force that moves both, below contact: p . (Lambda - w^2 + i w C)^-1 p is imaginary."""
    omega, rate, push = TWO.omega, np.diag([0.02, 0.16]), np.array([1.0, 0.8])

    def motion(w: float) -> np.ndarray:
        return push / (omega**2 - w**2 + 1j * w * np.diagonal(rate))

    w = brentq(lambda w: float((push @ motion(w)).real), 1.0, 1.05, xtol=1e-15)
    unit = motion(w)
    level = 0.4 / abs(unit[0])
    gamma = float(np.sum(np.abs(level * unit) ** 2)) / 4
    guess = ResonantMotion(np.array([0.4, 0.0]), np.zeros(2), 1.0, 0.01)
    found = resonant_motion(driven_by_push(TWO, rate, push), push, gamma, guess)
    assert not found.failure and found.changes == 0
    assert found.omega == pytest.approx(w, rel=1e-11)
    assert found.level == pytest.approx(level, rel=1e-10)
    lost = np.sum(np.diagonal(rate) * np.abs(unit) ** 2)
    assert found.damping_ratio == pytest.approx(lost / (2 * w * np.sum(np.abs(unit) ** 2)))
    decay = np.exp(-np.pi * np.diagonal(rate) / w).max()
    assert abs(found.multipliers[0]) == pytest.approx(decay, rel=1e-9)


def test_oscillator_with_a_stop_is_where_the_exact_response_has_its_peak() -> None:
    """That of tests/reference/b_bilinear_forced_frf.csv: 1.779182 at 1.199978 under 0.05."""
    push, rate = np.ones(1), np.array([[0.02]])
    flow = driven_by_push(OSCILLATOR, rate, push)
    first = ResonantMotion(np.array([1.4]), np.zeros(1), 1.2, 0.05)

    def at(gamma: float) -> ResonantMotion:
        return resonant_motion(flow, push, gamma, first)

    found = at(brentq(lambda gamma: at(gamma).level - 0.05, 0.9, 1.3, xtol=1e-12))
    assert not found.failure and found.omega == pytest.approx(1.199978, rel=1e-4)
    assert found.damping_ratio == pytest.approx(0.01 / found.omega, rel=1e-9)
    driven = flow.driven_by(
        replace(flow.drive.at(found.omega), amplitude=0.05 * flow.drive.amplitude)
    )
    times = np.linspace(0.0, 2 * np.pi / found.omega, 4001)
    course = driven.run(found.q, found.velocity, times[-1], times=times)
    assert course.q_at.max() == pytest.approx(1.779182, rel=5e-5)
    assert virial_error(driven, found.q, found.velocity) < 1e-11


def test_slope_is_that_of_the_family() -> None:
    push, rate = np.array([1.0, 0.8]), np.diag([0.02, 0.16])
    flow, near = (
        driven_by_push(TWO, rate, push),
        ResonantMotion(np.array([1.1, 0.02]), np.zeros(2), 1.05, 0.03),
    )
    low, here, high = (resonant_motion(flow, push, 0.4 * part, near) for part in (0.999, 1, 1.001))
    assert here.changes > 0 and not (low.failure or here.failure or high.failure)
    change = np.log(high.omega / low.omega) / np.log(1.001 / 0.999)
    assert here.slope == pytest.approx(change, rel=1e-4)


@pytest.mark.parametrize("clock", [0.0, 0.7])
def test_integrals_in_closed_form_are_those_of_quadrature(clock: float) -> None:
    push, rate = np.array([1.0, 0.8]), np.array([[0.05, 0.02], [0.02, 0.3]])
    flow = driven_by_push(TWO, rate, push).at(1.1)
    touching = 0
    for stretch in flow.stretches(np.array([1.2, 0.05]), np.array([0.1, -0.2]), 5.7):
        each = replace(stretch, clock=stretch.clock + clock)
        touching += each.motion.contact
        for closed, open_ in (
            (integrals, _by_quadrature),
            (gradients_of, _gradients_by_quadrature),
        ):
            expected = open_(each, 1.1, push)
            assert closed(each, 1.1, push) == pytest.approx(expected, rel=1e-9, abs=1e-10)
    assert touching > 0
