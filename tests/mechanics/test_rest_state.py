"""Gaps of any sign: states of rest, motions about them, against closed forms and integration."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROD, Ended
from independent_motion import after_a_period, exact_motion
from scipy.linalg import eigh

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.follow import (
    ArcContinuation,
    EnergyContinuation,
    FrequencyContinuation,
    Wanted,
    follow,
)
from fenics_nnm.backbone.levels import HarmonicBalance, levels
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.massless import massless_model
from fenics_nnm.results import branch_file

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: The oscillator m x'' + k x + K (x - e)_+ = 0 with m = 1, as in demos/bilinear.
SPRING, STOP = 10.0, 50.0


def oscillator(gap: float, **reference: float) -> ReducedModel:
    return ReducedModel([np.sqrt(SPRING)], [[1.0]], [[1 / STOP]], [gap], **reference)


def exact_frequency(energy: float, gap: float) -> float:
    """Closed form at an energy from the state of rest, beyond the first event."""
    k, K = SPRING, STOP
    if gap < 0:
        energy += k * K * gap**2 / (k + K) / 2  # of rest, over that without stress
    free = 2 / np.sqrt(k) * np.arccos(-gap * np.sqrt(k / (2 * energy)))
    wave = np.sqrt(2 * energy * (K + k) - K * k * gap**2)
    return float(1 / (free + 2 / np.sqrt(K + k) * np.arccos(gap * k / wave)))


def chain(gap: list[float], modes: int = 3, **reference: float) -> ReducedModel:
    """Eight masses; contact at the free end, and in the middle from the other side."""
    K = 2 * np.eye(8) - np.diag(np.ones(7), 1) - np.diag(np.ones(7), -1)
    K[-1, -1] = 1
    squares, shapes = eigh(K, np.diag(np.linspace(1, 1.7, 8)))
    B = np.zeros((2, 8))
    B[0, 7], B[1, 3] = 1, -1
    model = massless_model(
        np.sqrt(squares[:modes]), B @ shapes[:, :modes], B @ np.linalg.solve(K, B.T), np.array(gap)
    )
    return replace(model, **reference)


def branch(model: ReducedModel, wanted: Wanted, N: int = 9, m: int = 256, **other: Any) -> Branch:
    found = follow(model, wanted, HarmonicBalance(N, m, **other), mode=0)
    assert found.complete, found.reason
    return found


@pytest.mark.parametrize("gap", [[-0.1, 0.3], [0.2, -0.05], [-0.1, -0.1], [-0.1, 0.0], [0.0, 0.3]])
def test_state_of_rest_solves_signorinis_conditions(gap: list[float]) -> None:
    model = chain(gap)
    rest = model.at_rest()
    np.testing.assert_allclose(model.omega**2 * rest.q, -rest.force @ model.Phi, atol=1e-14)
    clearance = model.gap - model.Phi @ rest.q + model.R @ rest.force
    np.testing.assert_allclose(rest.clearance, clearance, atol=1e-14)
    assert rest.force.min() >= 0 and rest.clearance.min() >= 0
    assert np.all(rest.closed == (rest.force > 0))
    assert np.all(rest.touching == ((rest.force == 0) & (clearance < 1e-12)))
    # of all sets of closed points this is the only one that does
    S = model.R + (model.Phi / model.omega**2) @ model.Phi.T
    fits = []
    for closed in itertools.product([False, True], repeat=2):
        at, force = np.array(closed), np.zeros(2)
        if at.any():
            force[at] = np.linalg.solve(S[np.ix_(at, at)], -model.gap[at])
        if np.all(force >= 0) and np.all(S @ force + model.gap >= -1e-14):
            fits.append(force)
    for force in fits:
        np.testing.assert_allclose(rest.force, force, atol=1e-13)


def test_first_event_ends_the_linear_motion() -> None:
    model = chain([-0.1, 0.3])
    rest = model.at_rest()
    q = rest.q + model.grazing_amplitude() * np.outer([-1.0, 1.0], rest.shapes[:, 0])
    # closed points held by K_A at w = gap; here one of the two sides comes to its event
    force = np.linalg.solve(model.R[:1, :1], (q @ model.Phi.T - model.gap)[:, :1].T)[0]
    open_by = model.gap[1] - q @ model.Phi[1] + model.R[1, 0] * force
    assert min(force.min() / rest.force[0], open_by.min() / rest.clearance[1]) == pytest.approx(
        0.0, abs=1e-10
    )
    assert force.min() > -1e-12 and open_by.min() > -1e-12


def test_levels_keep_rest_and_frequency() -> None:
    model, _ = chain([-0.1, 0.3], modes=4).dimensionless(0)
    rest, S = model.at_rest(), None
    for level in levels(model, HarmonicBalance(6, 64), mode=0):
        part = level.equations.model
        own = part.at_rest()
        np.testing.assert_allclose(own.force, rest.force, rtol=1e-10)
        np.testing.assert_allclose(own.omega, rest.omega[level.modes], rtol=1e-9)
        static = part.R + (part.Phi / part.omega**2) @ part.Phi.T
        np.testing.assert_allclose(static, static if S is None else S, rtol=1e-10)
        S = static
        q = np.zeros((7, 4))
        q[0] = rest.q
        q[1] = rest.shapes[:, level.modes].sum(axis=1)
        np.testing.assert_allclose(level.extended(level.restricted(q))[:2], q[:2], atol=1e-9)


@pytest.mark.parametrize(
    "wanted",
    [
        EnergyContinuation(0.5, 30, 3.0, report_at=(1.05, 1.2, 1.5)),
        FrequencyContinuation(0.75, 0.98, 0.05, report_at=(2.0,)),
        ArcContinuation(0.5, 6, 2.0),
    ],
    ids=["energy", "frequency", "arc-length"],
)
def test_preloaded_oscillator_softens_as_the_closed_form(wanted: Wanted) -> None:
    gap = -0.01
    points = branch(oscillator(gap), wanted, 9, 512).points
    closed = np.sqrt(SPRING + STOP) / (2 * np.pi)
    assert len([point for point in points if point.gamma_ratio > 1]) >= 5
    for point in points:
        exact = closed if point.gamma_ratio <= 1 else exact_frequency(point.motion.energy, gap)
        assert point.motion.frequency == pytest.approx(exact, rel=1e-5)
        assert point.frequency_ratio == pytest.approx(point.motion.frequency / closed)
        assert point.balance.virial_error < 1e-9 and point.status == "verified"
    falling = [
        p.motion.frequency for p in sorted(points, key=lambda p: p.gamma_ratio) if p.gamma_ratio > 1
    ]
    assert np.all(np.diff(falling) < 0)


def test_general_series_gives_the_same_preloaded_motions() -> None:
    wanted = EnergyContinuation(0.8, 4.0, 0.8)
    one, other = (branch(oscillator(-0.01), wanted, general=g).points for g in (False, True))
    for point, general in zip(one, other, strict=True):
        assert point.motion.frequency == pytest.approx(general.motion.frequency, rel=1e-8)
        assert point.motion.energy == pytest.approx(general.motion.energy, rel=1e-7)


def test_energy_of_lift_off() -> None:
    """The mass has the energy K x_s / (k + K) of the stop's force, in closed form."""
    gap = -0.01
    (_, last) = branch(oscillator(gap), EnergyContinuation(0.25, 1.0, 0.75)).points
    way = SPRING * abs(gap) / (SPRING + STOP)  # from rest to where the stop is without force
    assert last.motion.energy == pytest.approx((SPRING + STOP) * way**2 / 2, rel=1e-9)


def test_oscillator_without_gap() -> None:
    model = oscillator(0.0, reference=0.01)
    points = branch(model, EnergyContinuation(0.1, 50, 10.0), 21, 1024).points
    exact = 1 / (np.pi / np.sqrt(SPRING) + np.pi / np.sqrt(SPRING + STOP))
    for point in points:
        assert point.motion.frequency == pytest.approx(exact, rel=1e-7)
        assert point.motion.rayleigh_frequency == pytest.approx(point.motion.frequency, rel=1e-9)
    assert np.ptp([point.motion.frequency for point in points]) < 1e-8 * exact
    # gamma ratio 1 is that of the free spring with the reference displacement
    unit = points[-1]
    gamma = np.sum(np.arange(22) ** 2 * unit.motion.q[:, 0] ** 2) / 4
    assert gamma / unit.gamma_ratio == pytest.approx(0.01**2 / 4, rel=1e-9)


def test_zero_gap_is_the_limit_of_large_energies() -> None:
    """A positive and a negative gap come to it from below and above."""
    limit = exact_frequency(1.0, 0.0)
    far = [
        branch(oscillator(gap), EnergyContinuation(1000.0, 1100.0, 100.0))
        .points[0]
        .motion.frequency
        for gap in (0.01, -0.01)
    ]
    assert far[0] < limit < far[1]
    assert far == pytest.approx([limit, limit], rel=0.05)


def test_arc_length_follows_motions_that_touch() -> None:
    model = oscillator(0.0, reference=0.01)
    points = branch(model, ArcContinuation(0.5, 2.0, 0.5)).points
    assert points[-1].gamma_ratio == pytest.approx(2.0)
    assert np.ptp([p.motion.frequency for p in points]) < 1e-8 * points[0].motion.frequency


@pytest.mark.parametrize(
    ("gap", "reference"), [([0.2, -0.05], None), ([0.0, 0.3], 0.2)], ids=["preload", "touching"]
)
def test_two_stops_against_integration(gap: list[float], reference: float | None) -> None:
    """One stop pressed, or touching, the other open: DOP853 with principal pivoting."""
    model = chain(gap, reference=reference)
    wanted = EnergyContinuation(0.6, 1.5, 0.45)
    points = follow(model, wanted, HarmonicBalance(15, 256), mode=0, shooting=True).points
    checked = 0
    for point in points:
        back = after_a_period(model, point, 15)
        assert back.error == pytest.approx(point.returned.after_one, abs=1e-4)
        if point.status == "verified":
            exact = exact_motion(model, point, 15)
            assert point.motion.frequency == pytest.approx(exact.frequency, rel=1e-3)
            checked += point.motion.contact_fraction < 1
    assert checked >= 2


def test_rod_without_gap_bounces_with_its_period() -> None:
    omega = (np.arange(12) + 0.5) * np.pi
    model = massless_model(omega, np.full((1, 12), np.sqrt(2.0)), np.eye(1), np.zeros(1))
    model = replace(model, reference=1.0)
    points = branch(model, EnergyContinuation(0.5, 2.0, 0.5), 8, 512).points
    for point in points:
        assert point.motion.frequency == pytest.approx(1 / 3, rel=2e-5)


def test_pressed_rod_has_the_frequency_of_the_clamped_one() -> None:
    """And far above lift-off that of the square wave with T = 3 - 1 / sqrt(1 + 2 E)."""
    omega = (np.arange(12) + 0.5) * np.pi
    model = massless_model(omega, np.full((1, 12), np.sqrt(2.0)), np.eye(1), -np.ones(1))
    assert model.at_rest().omega[:2] == pytest.approx(np.pi * np.array([1, 2]), rel=2e-4)
    wanted = EnergyContinuation(0.9, 20.0, 20.0, report_at=(14.0, 17.0))
    points = {p.gamma_ratio: p for p in branch(model, wanted, 8).points}
    assert points[0.9].motion.frequency == pytest.approx(0.5, rel=1e-4)
    for ratio in (17.0, 20.0):
        exact = 1 / (3 - 1 / np.sqrt(1 + 2 * points[ratio].motion.energy))
        assert points[ratio].motion.frequency == pytest.approx(exact, rel=5e-4)


@pytest.mark.parametrize(("neighbour", "still"), [(1.003, True), (2.0, False)])
def test_round_off_of_a_shape_is_no_motion_towards_the_obstacle(
    neighbour: float, still: bool
) -> None:
    """Tines in phase, beside a mode out of phase that is 0.3 % higher, or far away."""
    model = ReducedModel([1.0, neighbour], [[1.4e-9, 1.0]], [[0.1]], [1e-4])
    assert model.at_rest().touches(0) is not still
    if still:
        with pytest.raises(ModelError, match="does not move any contact point"):
            model.grazing_amplitude(0)
    assert model.grazing_amplitude(1) == pytest.approx(1e-4)


def test_points_with_mass_need_positive_gaps() -> None:
    model = ReducedModel([1.0], [[1.0]], [[0.0]], [-0.1], contact=MASSIVE)
    with pytest.raises(ModelError, match=r"gap = -0.1: must be positive where contact"):
        branch(model, EnergyContinuation(0.5, 2.0, 0.5))


PRESSED: dict[str, Any] = {
    "contact": {"gap": -1e-3},
    "continuation": {"energies": {"from": 0.5, "to": 1.0, "step": 0.5}, "report_at": [1.0]},
}


def test_a_study_of_a_pressed_rod(study_file: StudyFile, command: Command, tmp_path: Path) -> None:
    study = study_file(**PRESSED)
    checked = command("check", study)
    assert checked.code == 0, checked.err
    assert (
        "at rest          1 points closed" in checked.out and "lift-off         at" in checked.out
    )
    assert command("run", study, "--output", "out").code == 0
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    force = ROD["material"]["young"] * ROD["body"]["area"] * 1e-3 / ROD["mesh"]["length"]
    assert summary["at_rest"]["at_gamma_ratio_1"] == "lift-off"
    assert summary["at_rest"]["contact_force_N"] == pytest.approx(force, rel=1e-9)
    _, points = branch_file.read(tmp_path / "out/branch.h5")
    assert points[-1].status == "verified"
    assert points[-1].motion.frequency == pytest.approx(
        summary["linear_frequencies_Hz"][0], rel=1e-9
    )


@pytest.mark.parametrize(
    ("changes", "named", "right"),
    [
        ({"contact": {"gap": 0.0}}, "contact.reference_displacement: is missing", "gamma ratio 1"),
        (
            {"contact": {"reference_displacement": 1e-3}},
            "contact.reference_displacement = 0.001: has no effect",
            "touches without force",
        ),
        (
            {"contact": {"gap": -1e-3}, "reduction": {"method": "none"}},
            "contact.gap = -0.001: must be positive at full order",
            '"massless"',
        ),
        (
            {"contact": {"gap": -1e-3}, "reduction": {"method": "craig-bampton"}},
            "contact.gap = -0.001: must be positive where contact points carry mass",
            '"massless"',
        ),
    ],
)
def test_what_does_not_go_with_a_gap_is_told(
    changes: dict[str, Any],
    named: str,
    right: str,
    study_file: StudyFile,
    command: Command,
) -> None:
    command("run", study_file(**changes)).assert_one_line(2, named, right)
