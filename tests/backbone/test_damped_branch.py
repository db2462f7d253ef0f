"""Branches of damped motions: homotopy, points and their verdicts."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fenics_nnm.backbone.damped_branch import DampedMaker, damped_branch
from fenics_nnm.backbone.damped_joins import damped_joins, exact_motion
from fenics_nnm.backbone.damped_model import HEAVY, DampedModel
from fenics_nnm.backbone.damped_motions import damped_motions
from fenics_nnm.backbone.damped_path import Step, walk
from fenics_nnm.backbone.wanted import Progress
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.judge import Unjudged
from fenics_nnm.response.phase_resonance import damped_backbone
from fenics_nnm.response.structure import Drive, DrivenStructure
from fenics_nnm.time_domain.resonant_motion import ResonantMotion

OMEGA, RATE = np.array([1.0, 2.7]), np.diag([0.02, 0.0162])
MODEL = ReducedModel(OMEGA, np.array([[1.0, -0.7]]), np.array([[0.25]]), np.array([1.0]))
PUSH = np.array([1.0, 0.8])


def maker(harmonics: int = 12) -> DampedMaker:
    series = FourierSeries(harmonics, 8 * harmonics)
    return DampedMaker(DampedModel(MODEL, RATE, 3 * PUSH, 0), 3.0, series)


def test_points_lie_on_the_damped_backbone_of_a_response() -> None:
    """By harmonic balance, which shares nothing with motions in time: 16 harmonics, 2e-4."""
    found = damped_branch(maker(), (0.5, 1.2, 1.4))
    assert found.complete and not found.jumps
    structure = DrivenStructure.of(
        MODEL, RatedPart(OMEGA, RATE), Drive.simple(PUSH[None], np.array([3.0 + 0j]))
    )
    series, span = FourierSeries(16, 128), np.array([0.98, 1.2]) / (2 * np.pi)
    level = max(point.sustained.force for point in found.points if point.sustained) / 3
    curve = damped_backbone(structure, series, span, (1.02 * level,), judge=Unjudged())
    assert len(curve.points) > 5
    free, *touching = found.points
    assert free.status == "verified" and free.motion.contact_fraction == 0
    for point in touching:
        assert point.sustained is not None and point.stability is not None
        assert point.motion.contact_fraction > 0.1 and point.balance.virial_error < 1e-9
        known = np.array(
            [(each.force, each.point.frequency, each.damping_ratio) for each in curve.points[1:]]
        )
        order = np.argsort(known[:, 0])
        frequency, ratio = (
            np.interp(point.sustained.force, known[order, 0], known[order, k]) for k in (1, 2)
        )
        assert point.motion.frequency == pytest.approx(frequency, rel=1e-3)
        assert point.sustained.ratio == pytest.approx(ratio, rel=1e-2)
        assert point.status == "verified" and len(point.stability.multipliers) == 4


def test_frequency_is_that_of_the_model_whatever_the_harmonics() -> None:
    few, many = (damped_branch(maker(harmonics), (1.4,)).points[0] for harmonics in (2, 24))
    assert few.motion.frequency == pytest.approx(many.motion.frequency, rel=1e-12)
    assert many.status == "verified" and few.status == "converged"
    assert few.reason.startswith("its 2 harmonics leave out part")
    assert few.confirmed and few.stability is not None and many.stability is not None
    assert few.stability.multipliers == pytest.approx(many.stability.multipliers)


def test_motions_that_do_not_follow_from_each_other_are_of_two_families() -> None:
    """The tongue of mode 2 at 3 omega ends between gamma ratio 1.35 and 1.4."""
    omega = np.array([1.0, 3.1])
    model = ReducedModel(omega, np.array([[1.0, 1.0]]), np.array([[0.05]]), np.array([1.0]))
    damped = DampedModel(model, np.diag(0.006 * omega), np.array([1.0, 0.0]), 0)
    own = DampedMaker(damped, float("nan"), FourierSeries(12, 96))
    found = damped_branch(own, (1.35, 1.4, 1.45))
    first, second, third = (point.family for point in found.points)
    assert first != second == third
    (jump,) = found.jumps
    assert jump.gamma_ratios == (1.35, 1.4) and jump.change > 0.1
    exact = exact_motion(damped, own.series, found.points[2])
    assert exact.omega / (2 * np.pi) == pytest.approx(found.points[2].motion.frequency, rel=1e-9)
    parted = damped_joins(damped, own.series, found.points, (1, 2, 3))
    assert parted == {1}  # from 1.4 to 1.45, and not over the jump


STIFF = ReducedModel(
    np.array([1.0, 5.97775]), np.array([[1.0, 0.96955]]), np.array([[2.5e-3]]), np.array([1.0])
)


@pytest.mark.parametrize("ratios", [(1.2,), (0.8, 1.0, 1.2), (0.9, 1.001, 1.2)])
def test_the_way_up_leads_over_the_kink_of_a_stiff_stop(ratios: tuple[float, ...]) -> None:
    """The motion does not depend on the ratios before it, and obeys a time integration."""
    rate, push = np.array([[0.0584, 0.05], [0.05, 0.15]]), np.array([0.8373, -0.4655])
    last = list(damped_motions(DampedModel(STIFF, rate, push, 0), ratios))[-1].motion
    assert not last.failure
    assert last.omega == pytest.approx(1.11001, abs=1e-5)
    period = 2 * np.pi / last.omega

    def motion(t: float, y: np.ndarray) -> np.ndarray:
        w = STIFF.Phi[0] @ y[:2]
        contact = STIFF.Phi[0] * max(w - 1.0, 0.0) / 2.5e-3
        force = -last.level * push * np.sin(last.omega * t) - rate @ y[2:]
        return np.concatenate([y[2:], force - STIFF.omega**2 * y[:2] - contact])

    begin = np.concatenate([last.q, last.velocity])
    end = solve_ivp(motion, (0, period), begin, rtol=1e-10, atol=1e-12, max_step=period / 500)
    assert end.y[:, -1] == pytest.approx(begin, abs=1e-6)
    assert np.abs(end.y[:2].T @ STIFF.Phi[0]).max() > 1.0


def test_motions_without_contact_are_of_one_family_whatever_damping_couples() -> None:
    """Their frequency is not that of the linear mode: damping couples modes."""
    rate, push = np.array([[0.0584, 0.05], [0.05, 0.15]]), np.array([0.8373, -0.4655])
    own = DampedMaker(DampedModel(STIFF, rate, push, 0), 1.0, FourierSeries(12, 96))
    points = damped_branch(own, (0.7, 0.8, 0.9, 1.1, 1.2)).points
    assert abs(points[0].frequency_ratio - 1) > 5e-5
    assert [point.is_linear for point in points] == [True, True, True, False, False]
    assert [point.family for point in points] == [1, 1, 1, 1, 1]


def test_known_points_are_taken_over() -> None:
    whole, heard = damped_branch(maker(), (0.5, 1.2)), []
    again = damped_branch(
        maker(), (0.5, 1.2), progress=Progress(whole.points[1:], on_point=heard.append)
    )
    assert [point.gamma_ratio for point in heard] == [0.5]
    assert again.points[1] is not None and len(again.points) == 2


def test_way_down_ends_at_the_real_damping_and_leaves_the_followed_mode() -> None:
    damped = DampedModel(MODEL, np.array([[0.02, 0.01], [0.01, 0.0]]), PUSH, 0)
    assert (damped.rate_at(0.0) == damped.rate).all()
    heavy = damped.rate_at(1.0)
    assert heavy[0, 0] == 0.02 and heavy[0, 1] == 0.01
    assert heavy[1, 1] == pytest.approx(2 * HEAVY * 2.7, rel=1e-2)


def test_walk_tells_where_it_ends() -> None:
    """A family x^2 = 1 - s, which turns back at s = 1."""

    def at(s: float, guess: ResonantMotion) -> ResonantMotion:
        if s > 1:
            return ResonantMotion(guess.q, guess.velocity, 1.0, 1.0, failure="none")
        return ResonantMotion(np.array([np.sqrt(1 - s) + 1]), np.zeros(1), 1.0, 1.0, iterations=3)

    first = at(0.0, ResonantMotion(np.ones(1), np.zeros(1), 1.0, 1.0))
    found = walk(at, np.ones(1), (0.0, first), 2.0, Step(0.1, 1e-3), (0.5,))
    assert found.failure == "none" and 0.99 < found.values[-1] <= 1
    half = found.at(0.5)
    assert half is not None and half.q[0] == pytest.approx(1 + np.sqrt(0.5))
    assert found.at(0.123) is None
