"""The verdict of a point: wrong motions are never verified."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.periodicity import followed
from fenics_nnm.backbone.point import GAMMA_RATIO, BranchPoint
from fenics_nnm.backbone.verdict import WITH_MASS, Judge, contradicted
from fenics_nnm.backbone.wanted import Followed
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.reduction_error import ReductionError
from fenics_nnm.nonlinear.series_error import SeriesError
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.shooting import OrbitGuess, shoot
from fenics_nnm.time_domain.stability import stability
from fenics_nnm.time_domain.stepped import integrator_of

MODEL = ReducedModel(
    omega=[1.0, 2.62, 6.31],
    Phi=[[1.0, -0.6, 0.5], [0.7, 0.4, -0.8]],
    R=[[0.06, 0.02], [0.02, 0.05]],
    gap=[1.0, 0.9],
)
BALANCE = HarmonicBalance(20, 512)


@cache
def branch(*, shooting: bool = True) -> tuple[BranchPoint, ...]:
    energies = EnergyContinuation(0.8, 2.0, 0.2)
    return follow(MODEL, energies, BALANCE, mode=0, shooting=shooting).points


def verdict(
    point: BranchPoint,
    *,
    shooting: bool = True,
    model: ReducedModel = MODEL,
    flow: Integrator | None = None,
) -> BranchPoint:
    flow = flow or integrator_of(Mechanics.of(model))
    judge = Judge(model, BALANCE.series, flow, mode=0, harmonic=1, shooting=shooting)
    (found,) = judge.judgement(judge.judged(Followed((point,), (), ""))).points
    return found


def with_motion(point: BranchPoint, **changes: Any) -> BranchPoint:
    return replace(point, motion=replace(point.motion, **changes))


def guess_from(point: BranchPoint) -> OrbitGuess:
    return OrbitGuess.of(BALANCE.series, point.motion)


def with_balance(point: BranchPoint, **changes: Any) -> BranchPoint:
    return replace(point, balance=replace(point.balance, **changes))


def with_reduction_error(point: BranchPoint, error: float) -> BranchPoint:
    expected = replace(point.expected, reduction=ReductionError(0.0, error))
    return replace(point, expected=expected)


def test_points_keep_their_multipliers() -> None:
    """Without contact those of the linear modes; beyond it those of the period map."""
    first, *_, last = branch()
    turns = np.exp(1j * np.outer([1, -1], MODEL.omega[1:] / first.motion.frequency)).ravel()
    assert np.abs(np.subtract.outer(first.stability.multipliers, turns)).min(axis=0).max() < 1e-12
    assert first.stability.multipliers.shape == last.stability.multipliers.shape == (4,)
    assert np.prod(last.stability.multipliers) == pytest.approx(1, abs=1e-9)
    assert np.abs(last.stability.multipliers).max() == pytest.approx(
        last.stability.largest_multiplier, abs=1e-12
    )
    flow = Flow(MODEL)
    found = stability(flow, shoot(flow, guess_from(last)), reversible=True)
    np.testing.assert_allclose(last.stability.multipliers, found.multipliers, atol=1e-9)
    assert branch(shooting=False)[-1].stability is None


@pytest.mark.parametrize("shooting", [True, False])
def test_good_points_are_verified(shooting: bool) -> None:
    points = branch(shooting=shooting)
    for point in (*points[:2], *points[3:]):
        assert (point.status, point.reason) == ("verified", "")
    assert points[2].reason.startswith("mode 3 in harmonic 6 draws energy from the motion")
    assert points[2].status == "inside resonance"
    exact = [point.orbit.frequency / point.motion.frequency - 1 for point in branch()]
    assert np.abs(exact).max() < 1e-5  # so what is verified without shooting is right
    assert branch(shooting=False)[-1].orbit is None


@pytest.mark.parametrize("shooting", [True, False])
@pytest.mark.parametrize("change", [2e-3, -2e-3, 5e-3, 1.2e-2, -1.2e-2])
def test_a_wrong_frequency_is_not_verified(change: float, shooting: bool) -> None:
    point = branch()[-1]
    found = verdict(
        with_motion(point, frequency=point.motion.frequency * (1 + change)), shooting=shooting
    )
    assert found.status == ("failed" if shooting and abs(change) > 1e-2 else "converged")
    if shooting and abs(change) != 5e-3:  # that far off, a return error of 8 % says it first
        assert "the exact motion of its energy is" in found.reason
    if not shooting:
        assert "after ten periods the motion misses its start" in found.reason


@pytest.mark.parametrize("shooting", [True, False])
def test_a_wrong_state_is_not_verified(shooting: bool) -> None:
    point = branch()[-1]
    scaled = verdict(with_motion(point, q=1.01 * point.motion.q), shooting=shooting)
    assert scaled.status == "converged"
    assert "the energy of its initial state is +4." in scaled.reason or not shooting
    for size, expected in ((0.01, "converged"), (0.03, "converged"), (0.1, "failed")):
        q = point.motion.q.copy()
        q[3, 1] += size * np.abs(point.motion.q).max()
        assert verdict(with_motion(point, q=q), shooting=shooting).status == expected


def test_equations_and_reduction_count() -> None:
    point = branch()[-1]
    assert verdict(with_balance(point, virial_error=1e-4)).status == "failed"
    assert verdict(with_balance(point, complementarity=1e-4)).status == "failed"
    coarse = verdict(with_reduction_error(point, -2e-3))
    assert coarse.status == "converged"
    assert coarse.reason == "the reduction is expected to put its frequency off by -0.20%"
    assert verdict(with_reduction_error(point, 5e-4)).status == "verified"


def test_no_point_is_trusted_that_is_expected_to_be_far_off() -> None:
    """Unless integration in time confirms it; it says nothing of what the reduction leaves out."""
    point = branch()[-1]
    off = replace(point.expected, series=SeriesError(1.36, 0.0, 100.0))
    late = with_motion(point, frequency=point.motion.frequency * 1.002)
    found = verdict(replace(late, expected=off), shooting=False)
    assert (found.status, found.confirmed) == ("failed", False)
    assert found.reason.endswith("expected to put its frequency off by 136.0%")
    assert verdict(replace(point, expected=off)).status == "verified"
    assert not contradicted(found)
    assert contradicted(verdict(with_balance(replace(late, expected=off), virial_error=1e-4)))
    for error, remainder, status in (
        (0.009, 0.1, "converged"),
        (0.011, 0.1, "failed"),
        (0.09, 0.6, "converged"),  # no more than an order of magnitude
        (0.11, 0.6, "failed"),
    ):
        series = SeriesError(error - 0.005, -0.005, remainder)
        near = replace(late, expected=replace(point.expected, series=series))
        assert verdict(near, shooting=False).status == status
    for shooting in (True, False):
        found = verdict(with_reduction_error(point, 0.021), shooting=shooting)
        assert (found.status, found.confirmed) == ("failed", False)
        found = verdict(with_reduction_error(point, 0.019), shooting=shooting)
        assert (found.status, found.confirmed) == ("converged", False)


def test_integration_that_gives_up_is_a_failure() -> None:
    found = verdict(branch()[-1], flow=Flow(MODEL, most_changes=1))
    assert found.status == "failed"
    assert found.reason.startswith("integration in time gave up: more than 1 changes of contact")
    assert found.returned is None


def test_contact_points_with_mass_are_converged_and_linear_motions_verified() -> None:
    massive = replace(MODEL, R=np.zeros((2, 2)), contact=MASSIVE)
    found = verdict(branch()[-1], model=massive)
    assert (found.status, found.reason) == ("converged", WITH_MASS)
    linear = verdict(branch()[0], model=massive)
    assert (linear.status, linear.stability.largest_multiplier) == ("verified", 1)
    below = verdict(replace(branch()[-1], at={**branch()[-1].at, GAMMA_RATIO: 0.9}), model=massive)
    assert below.status == "converged"  # not linear: its frequency is another one


def test_return_after_ten_periods_is_a_product_of_ten_maps() -> None:
    flow, point = Flow(MODEL), branch()[-1]
    found = followed(flow, BALANCE.series, point.motion).returned
    q = point.motion.q.sum(axis=0)
    after = flow.run(q, np.zeros(3), 10 / point.motion.frequency)
    missed = np.hypot(MODEL.omega * (after.q - q), after.velocity)
    whole = float(np.linalg.norm(missed) / np.sqrt(2 * point.motion.energy))
    assert found.after_ten == pytest.approx(whole, rel=1e-6)
    assert found.after_one == pytest.approx(point.returned.after_one, rel=1e-9)
    assert found.energy_drift < 1e-12
    late = replace(point.motion, frequency=point.motion.frequency * 1.002)
    shifted = followed(flow, BALANCE.series, late).returned
    # the phase is late by 20 pi 0.002; the rate of the first mode alone is the least of it
    assert shifted.after_ten > 0.8 * 20 * np.pi * 0.002 * MODEL.omega[0]


class _Dear(Flow):
    """A flow for which ten periods are as dear as the exact motion."""

    __slots__ = ()

    @property
    def cheap(self) -> bool:
        return False


def test_dear_motions_are_followed_for_ten_periods_where_no_exact_one_is_known() -> None:
    """Verdicts are the same; what ten periods say is told where it counts."""
    flow, point = _Dear(MODEL), branch()[-1]
    found = verdict(point, flow=flow)
    assert np.isnan(found.returned.after_ten) and np.isfinite(found.returned.energy_drift)
    assert found.returned.after_one == pytest.approx(point.returned.after_one, rel=1e-9)
    assert (found.verdict, found.orbit) == (point.verdict, point.orbit)
    other = with_motion(point, energy=1.5 * point.motion.energy)
    unlike = verdict(other, flow=flow)
    assert unlike.orbit is None and unlike.returned.after_ten > 0
    assert unlike.verdict == verdict(other, flow=Flow(MODEL)).verdict
    alone = verdict(point, flow=flow, shooting=False)
    assert alone.returned.after_ten == pytest.approx(point.returned.after_ten, rel=1e-9)


def test_shot_motion_of_a_point() -> None:
    point = branch()[-1]
    shot = shoot(Flow(MODEL), guess_from(point))
    assert point.orbit.return_error < 1e-11
    assert point.orbit.distance == pytest.approx(shot.distance, rel=1e-6)


def test_energy_varies_less_the_more_harmonics_there_are() -> None:
    variations = []
    for harmonics in (5, 10, 20):
        balance = HarmonicBalance(harmonics, 512)
        point = follow(MODEL, EnergyContinuation(0.8, 2.0, 0.2), balance, mode=0).points[-1]
        flow, series = Flow(MODEL), balance.series
        q = series.synthesis @ point.motion.q
        rate = 2 * np.pi * point.motion.frequency * series.rate_at(series.phase) @ point.motion.q
        energies = [flow.energy(*state) for state in zip(q, rate, strict=True)]
        assert series.weight @ energies == pytest.approx(point.motion.energy, rel=1e-9)
        expected = np.ptp(energies) / point.motion.energy
        assert point.balance.energy_variation == pytest.approx(expected, rel=1e-6)
        variations.append(expected)
    assert variations[2] < variations[1] / 3 < variations[0] / 9
    assert branch()[0].balance.energy_variation < 1e-12


def test_tension_is_the_force_across_an_open_gap() -> None:
    """One point against its definition, at times between the samples; it falls with them."""
    model = ReducedModel([1.0, 3.3], [[1.0, 0.8]], [[0.05]], [1.0])
    tensions = []
    for samples in (32, 512):
        balance = HarmonicBalance(6, samples)
        point = follow(model, EnergyContinuation(0.9, 1.8, 0.1), balance, mode=0).points[-1]
        phase = 2 * np.pi * np.arange(8 * samples) / (8 * samples)
        half = np.minimum(phase, 2 * np.pi - phase)
        force = np.interp(half, balance.series.phase, point.motion.force[:, 0])
        w = np.cos(np.outer(phase, np.arange(7))) @ point.motion.q @ model.Phi[0] - 0.05 * force
        flexibility = 1.0 + 0.64 / 3.3**2 + 0.05
        expected = np.max(np.minimum(1 - w, flexibility * force))
        assert point.balance.tension == pytest.approx(expected, rel=1e-6)
        tensions.append(expected)
    assert tensions[1] < tensions[0] / 2
