"""Floquet multipliers against differences, closed forms and growth in time."""

from functools import cache

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.shooting import OrbitGuess, ShotMotion, shoot
from fenics_nnm.time_domain.stability import COMPLEX, DOUBLING, damping_needed, stability

MODEL = ReducedModel(
    omega=[1.0, 2.62, 6.31],
    Phi=[[1.0, -0.6, 0.5], [0.7, 0.4, -0.8]],
    R=[[0.06, 0.02], [0.02, 0.05]],
    gap=[1.0, 0.9],
)

#: gamma_ratio of motions that are stable, and unstable in two ways.
STABLE, KREIN, DOUBLED = 1.6, 1.8, 2.4


@cache
def shots() -> dict[float, ShotMotion]:
    balance, flow = HarmonicBalance(10, 256), Flow(MODEL)
    found = follow(MODEL, EnergyContinuation(0.8, 2.4, 0.2), balance, mode=0)
    guesses = {p.gamma_ratio: OrbitGuess.of(balance.series, p.motion) for p in found.points}
    return {round(ratio, 6): shoot(flow, guess) for ratio, guess in guesses.items()}


def by_differences(shot: ShotMotion, step: float = 1e-6) -> Array:
    """Derivative of the state after a period by that at the start."""
    flow, start = Flow(MODEL), np.concatenate([shot.q, shot.velocity])
    columns = []
    for change in step * np.eye(6):
        ends = [
            flow.run(*np.split(start + sign * change, 2), shot.period)  # type: ignore[misc]
            for sign in (1, -1)
        ]
        ahead, behind = (np.concatenate([end.q, end.velocity]) for end in ends)
        columns.append((ahead - behind) / (2 * step))
    return np.array(columns).T


@pytest.mark.parametrize("ratio", [STABLE, KREIN, DOUBLED])
def test_multipliers_are_those_of_the_differentiated_period_map(ratio: float) -> None:
    shot = shots()[ratio]
    found = stability(Flow(MODEL), shot)
    reference = np.linalg.eigvals(by_differences(shot))
    for multiplier in found.multipliers:
        assert np.abs(reference - multiplier).min() < 1e-6
    # the two left over are the ones at 1, which differences split by the root of their error
    assert np.count_nonzero(np.abs(reference - 1) < 1e-2) == 2
    assert len(found.multipliers) == 4


@pytest.mark.parametrize("ratio", [STABLE, KREIN, DOUBLED])
def test_multipliers_come_in_pairs(ratio: float) -> None:
    found = stability(Flow(MODEL), shots()[ratio])
    assert found.pair_error < 1e-11
    assert found.symplectic_error < 1e-13
    assert found.trivial_error < 1e-10
    assert found.error < 1e-9
    assert np.prod(found.multipliers) == pytest.approx(1, abs=1e-10)


@pytest.mark.parametrize("ratio", [STABLE, KREIN, DOUBLED])
def test_half_a_period_of_a_reversible_motion_is_enough(ratio: float) -> None:
    flow, shot = Flow(MODEL), shots()[ratio]
    whole, half = stability(flow, shot), stability(flow, shot, reversible=True)
    assert half.kinds == whole.kinds
    assert half.symplectic_error < 1e-13
    assert half.trivial_error < 1e-10
    for found, directions in zip(half.multipliers, half.directions.T, strict=True):
        nearest = int(np.argmin(np.abs(whole.multipliers - found)))
        assert whole.multipliers[nearest] == pytest.approx(found, abs=1e-9)
        along = np.abs(np.vdot(directions, whole.directions[:, nearest]))
        assert along == pytest.approx(1, abs=1e-8)
    assert np.prod(half.multipliers) == pytest.approx(1, abs=1e-12)


def test_multipliers_on_the_circle_are_there_to_round_off() -> None:
    flow = Flow(MODEL)
    found = stability(flow, shots()[STABLE], reversible=True)
    assert np.abs(np.abs(found.multipliers) - 1).max() < 1e-15


def test_kinds() -> None:
    flow = Flow(MODEL)
    stable, krein, doubled = (stability(flow, shots()[r]) for r in (STABLE, KREIN, DOUBLED))
    assert stable.stable
    assert stable.largest == pytest.approx(1, abs=1e-10)
    assert not krein.stable
    assert krein.kind == COMPLEX
    assert krein.largest == pytest.approx(1.217, abs=2e-3)
    assert doubled.kind == DOUBLING
    assert doubled.largest == pytest.approx(1.5225, abs=2e-3)


@pytest.mark.parametrize("ratio", [KREIN, DOUBLED])
def test_a_small_disturbance_grows_by_the_largest_multiplier(ratio: float) -> None:
    flow, shot = Flow(MODEL), shots()[ratio]
    away = np.random.default_rng(1).normal(size=6)
    growth = []
    for _ in range(240):
        away *= 1e-6 / np.linalg.norm(away)
        after = flow.run(shot.q + away[:3], shot.velocity + away[3:], shot.period)
        away = np.concatenate([after.q - shot.q, after.velocity - shot.velocity])
        growth.append(np.log(np.linalg.norm(away) / 1e-6))
    rate = np.exp(np.mean(growth[-200:]))
    assert rate == pytest.approx(stability(flow, shot).largest, rel=0.01)


def test_linear_motion_has_the_multipliers_of_its_modes() -> None:
    shot = shots()[0.8]
    found = stability(Flow(MODEL), shot)
    phase = MODEL.omega[1:] * shot.period
    exact = np.exp(1j * np.concatenate([phase, -phase]))
    assert shot.changes == 0
    for multiplier in exact:
        assert np.abs(found.multipliers - multiplier).min() < 1e-13
    assert found.stable


def test_one_mode_alone_is_stable_and_a_failed_motion_has_no_verdict() -> None:
    model, balance = ReducedModel([1.0], [[1.0]], [[0.1]], [1.0]), HarmonicBalance(8, 128)
    found = follow(model, EnergyContinuation(0.9, 2.0, 0.2), balance, mode=0)
    flow = Flow(model)
    guess = OrbitGuess.of(balance.series, found.points[-1].motion)
    alone = stability(flow, shoot(flow, guess))
    assert alone.stable
    assert alone.multipliers.size == 0
    assert alone.largest == 1
    failed = shoot(Flow(model, most_changes=1), guess)
    verdict = stability(flow, failed)
    assert not verdict.stable
    assert verdict.failure == failed.failure
    assert np.isnan(verdict.largest)


def test_damping_that_is_needed_is_what_holds_the_motion() -> None:
    """Meissner's equation x'' + 2 zeta omega x' + k(t) x = 0, k of two values, in closed form."""
    omega = 1.0

    def largest(zeta: float) -> float:
        period = 2 * np.pi / omega
        whole = np.eye(2)
        for stiffness in (0.35, 0.15):  # omega is twice the mean natural frequency
            held = np.sqrt(stiffness - (zeta * omega) ** 2)
            c, s = np.cos(held * period / 2), np.sin(held * period / 2) / held
            d = zeta * omega
            half = np.array([[c + d * s, s], [-stiffness * s, c - d * s]])
            whole = np.exp(-d * period / 2) * half @ whole
        return float(np.abs(np.linalg.eigvals(whole)).max())

    grows = largest(0.0)
    needed = damping_needed(grows)
    assert grows > 1.1
    assert needed == pytest.approx(np.log(grows) / (2 * np.pi))
    assert largest(needed) == pytest.approx(1, abs=2 * needed**2)
    assert largest(0.9 * needed) > 1 + needed / 3
    assert damping_needed(1.0) == damping_needed(0.5) == 0
    assert np.isnan(damping_needed(float("nan")))
