"""What light damping takes from an undamped motion: closed forms, and phase resonance."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.light_damping import LightDamping
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.judge import Unjudged
from fenics_nnm.response.phase_resonance import damped_backbone
from fenics_nnm.response.structure import Drive, DrivenStructure


def test_linear_mode_at_any_phase() -> None:
    """q = a cos(w t + 0.7) of the first of two modes; the force has half of it, 60 degrees off."""
    series, omega, ratio = FourierSeries(3, 16), 5.0, 0.03
    q = np.zeros((7, 2))
    q[series.order == 1, 0] = 0.2 * np.cos(0.7), -0.2 * np.sin(0.7)
    rate = np.diag([2 * ratio * omega, 1.0])
    push = 2.0 * np.array([0.5, 0.1]) * np.exp(1j * np.pi / 3)
    found = LightDamping(rate, np.zeros((2, 2)), push, 2.0).of(series, q, omega)
    assert found.ratio == pytest.approx(ratio, rel=1e-12)
    assert found.force == pytest.approx(2 * ratio * omega**2 * 0.2 / 0.5, rel=1e-12)


def test_force_across_the_motion_keeps_nothing_up() -> None:
    series = FourierSeries(1, 8)
    q = np.zeros((3, 2))
    q[series.order == 1] = [[0.1, 0.3], [0.2, 0.6]]
    across = np.array([3.0, -1.0]) * (1 + 1e-15) + 0j
    assert np.isnan(LightDamping(np.eye(2), np.zeros((2, 2)), across, 1.0).of(series, q, 2.0).force)


def test_loss_factor_is_twice_the_ratio_of_each_harmonic_over_its_number() -> None:
    """H = eta omega^2 takes pi H |q_n|^2 of energy in each turn of a harmonic."""
    series, omega = FourierSeries(2, 16), 3.0
    q = np.zeros((5, 1))
    q[series.order == 1, 0] = 0.4, 0.0
    q[series.order == 2, 0] = 0.0, 0.1
    loss = np.array([[0.02 * omega**2]])
    found = LightDamping(np.zeros((1, 1)), loss, np.zeros(1, dtype=complex), 1.0)
    per_period = np.pi * 0.02 * omega**2 * (0.4**2 + 2 * 0.1**2)
    kinetic = omega**2 * (0.4**2 + (2 * 0.1) ** 2) / 4
    expected = per_period * omega / (2 * np.pi) / (4 * omega * kinetic)
    assert found.of(series, q, omega).ratio == pytest.approx(expected, rel=1e-12)
    assert np.isnan(found.of(series, q, omega).force)


def test_force_and_ratio_of_a_motion_in_contact_are_those_of_phase_resonance() -> None:
    """0.5 % damping of two modes, a force that moves both; phase resonance has all orders."""
    omega, rate = np.array([1.0, 2.7]), np.diag([0.01, 0.027])
    model = ReducedModel(omega, np.array([[1.0, -0.7]]), np.array([[0.25]]), np.array([1.0]))
    shape = np.array([[1.0, 0.8]])
    structure = DrivenStructure.of(
        model, RatedPart(omega, rate), Drive.simple(shape, np.array([0.025j]))
    )
    span = np.array([0.98, 1.2]) / (2 * np.pi)
    curve = damped_backbone(structure, FourierSeries(6, 48), span, (0.9,), judge=Unjudged())
    balance = HarmonicBalance(6, 48)
    branch = follow(model, EnergyContinuation(1.05, 1.3, 0.05), balance, mode=0)
    damping = LightDamping(rate, np.zeros((2, 2)), 0.025j * shape[0], 0.025)
    points = branch.kept_up(damping, balance.series).points
    driven = np.array([abs(point.motion.q[1] @ shape[0]) for point in points])
    touching = [each for each in curve.points if driven[0] < each.point.amplitude[0] < driven[-1]]
    assert len(touching) > 3
    for each in touching:
        amplitude = each.point.amplitude[0]
        for own, other in (
            ([point.sustained.force for point in points if point.sustained], each.force),
            ([point.sustained.ratio for point in points if point.sustained], each.damping_ratio),
            ([point.motion.frequency for point in points], each.point.frequency),
        ):
            fit = np.polynomial.Polynomial.fit(driven, own, 4)
            assert fit(amplitude) == pytest.approx(other, rel=2e-3)
