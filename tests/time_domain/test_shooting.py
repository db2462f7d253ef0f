"""Shooting against closed forms and harmonic balance."""

import importlib.util
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from fenics_nnm.backbone.follow import Branch, EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.family import Steps, periodic_motion, walk_to_energy
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.period_map import Target, period_map
from fenics_nnm.time_domain.shooting import (
    OrbitGuess,
    Shooting,
    ShotMotion,
    harmonics_of,
    mean_gamma,
    shoot,
)

MODEL = ReducedModel(
    omega=[1.0, 2.62, 6.31],
    Phi=[[1.0, -0.6, 0.5], [0.7, 0.4, -0.8]],
    R=[[0.06, 0.02], [0.02, 0.05]],
    gap=[1.0, 0.9],
)

#: Two points that are mirror images of each other.
TWINS = ReducedModel(
    omega=[1.0, 2.62, 4.1, 6.31],
    Phi=[[1.0, -0.6, 0.7, 0.5], [1.0, -0.6, -0.7, 0.5]],
    R=[[0.06, 0.02], [0.02, 0.06]],
    gap=[1.0, 1.0],
)


@cache
def rod(modes: int) -> ReducedModel:
    """The exact rod, cut off: all its modes are in resonance with the first."""
    rest = np.arange(2 * modes + 1, 4001, 2.0)
    shape = np.sqrt(2) * (-1.0) ** np.arange(modes)
    return ReducedModel(np.arange(1, 2 * modes, 2.0), shape[None], [[np.sum(2 / rest**2)]], [1.0])


@cache
def branch(
    harmonics: int, *, twins: bool = False, general: bool = False, samples: int = 512
) -> Branch:
    balance = HarmonicBalance(harmonics, samples, general=general)
    found = follow(TWINS if twins else MODEL, EnergyContinuation(0.9, 2.0, 0.1), balance, mode=0)
    assert found.complete
    return found


def guess_from(series: Series, point: BranchPoint) -> OrbitGuess:
    return OrbitGuess.of(series, point.motion)


def all_shot(
    harmonics: int, *, twins: bool = False, general: bool = False, samples: int = 512
) -> list[ShotMotion]:
    series = HarmonicBalance(harmonics, samples, general=general).series
    flow = Flow(TWINS if twins else MODEL)
    points = branch(harmonics, twins=twins, general=general, samples=samples).points
    return [shoot(flow, guess_from(series, point)) for point in points]


def test_bilinear_oscillator_has_the_frequency_of_its_closed_form() -> None:
    path = Path(__file__).parents[2] / "demos" / "bilinear" / "bilinear.py"
    spec = importlib.util.spec_from_file_location("bilinear", path)
    assert spec is not None and spec.loader is not None
    demo = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(demo)
    model = ReducedModel([np.sqrt(10.0)], [[1.0]], [[1 / demo.STOP]], [demo.GAP])
    for general in (False, True):
        balance = HarmonicBalance(5, 256, general=general)
        found = follow(model, EnergyContinuation(1.05, 30.0, 1.0), balance, mode=0)
        for point in found.points:
            shot = shoot(Flow(model), guess_from(balance.series, point))
            assert shot.converged
            assert shot.changes == 2
            assert shot.energy == pytest.approx(point.motion.energy, rel=1e-13)
            assert shot.frequency == pytest.approx(
                demo.exact_frequency(point.motion.energy), rel=1e-12
            )
        worst = abs(
            found.points[0].motion.frequency / demo.exact_frequency(found.points[0].motion.energy)
            - 1
        )
        assert worst > 1e-6  # the guesses were not exact


@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize("twins", [False, True])
def test_motions_return_to_round_off(twins: bool, general: bool) -> None:
    shots = all_shot(10, twins=twins, general=general)
    points = branch(10, twins=twins, general=general).points
    for shot, point in zip(shots, points, strict=True):
        assert shot.converged
        assert shot.return_error < 1e-11
        assert shot.energy_change == pytest.approx(0, abs=1e-12)
        assert shot.iterations <= 6
        assert abs(shot.frequency_change) < 1e-3
    assert points[-1].returned.after_one > 1e-3
    assert shots[-1].contact_fraction == pytest.approx(points[-1].motion.contact_fraction, abs=0.02)


def test_harmonic_balance_converges_to_the_shot_frequency_of_its_energy() -> None:
    """At one gamma they differ in energy, so each is compared with the motion shot from it."""
    worst = [
        max(abs(shot.frequency_change) for shot in all_shot(harmonics, samples=2048))
        for harmonics in (5, 10, 20, 40)
    ]
    assert worst[0] > 1e-3
    assert worst[1] < worst[0] / 10
    assert worst[2] < worst[1] / 10
    assert worst[3] < worst[2] / 4 < 1e-6


def test_shot_motion_does_not_depend_on_the_guess_or_the_kind_of_equations() -> None:
    energy = branch(20).points[-1].motion.energy
    shots = []
    for harmonics, general in ((6, False), (20, False), (6, True), (20, True)):
        series = HarmonicBalance(harmonics, 512, general=general).series
        motion = branch(harmonics, general=general).points[-1].motion
        guess = OrbitGuess.of(series, replace(motion, energy=energy))
        shots.append(shoot(Flow(MODEL), guess))
    for shot in shots:
        assert shot.converged
        assert shot.frequency == pytest.approx(shots[0].frequency, rel=1e-12)


def test_gamma_and_harmonics_of_the_shot_motion() -> None:
    series, point = HarmonicBalance(40, 512).series, branch(40).points[-1]
    flow = Flow(MODEL)
    shot = shoot(flow, guess_from(series, point))
    grazing = MODEL.grazing_amplitude() ** 2 / 4
    assert mean_gamma(flow, shot) / grazing == pytest.approx(point.gamma_ratio, rel=1e-5)
    times = shot.period * np.arange(4096) / 4096
    speeds = flow.run(shot.q, shot.velocity, shot.period, times=times).velocity_at
    mean = np.mean(np.sum(speeds**2, axis=1)) * shot.period**2 / (8 * np.pi**2)
    assert mean_gamma(flow, shot) == pytest.approx(mean, rel=1e-8)
    q = harmonics_of(flow, shot, series)
    assert np.abs(q - point.motion.q).max() < 2e-4 * np.abs(point.motion.q).max()
    assert np.abs(series.basis_at(np.zeros(1))[0] @ q - shot.q).max() < 1e-4


def test_nearest_motion_has_an_energy_of_its_own() -> None:
    series, point, flow = HarmonicBalance(5, 512).series, branch(5).points[-1], Flow(MODEL)
    nearest = shoot(flow, guess_from(series, point), options=Shooting(keep_energy=False))
    same = shoot(flow, guess_from(series, point))
    assert nearest.converged
    assert nearest.return_error < 1e-11
    assert nearest.distance < same.distance
    assert 1e-5 < abs(nearest.energy_change) < 0.1


def rod_point(ratio: float, *, harmonics: int) -> tuple[Flow, HarmonicBalance, Branch]:
    balance = HarmonicBalance(harmonics, 256)
    energies = EnergyContinuation(0.9, ratio, 0.15)
    return Flow(rod(6)), balance, follow(rod(6), energies, balance, mode=0)


def test_walk_along_the_family_finds_what_newton_at_fixed_energy_does_not() -> None:
    flow, balance, found = rod_point(3.0, harmonics=4)
    point = found.points[-1]
    direct = shoot(
        flow,
        guess_from(balance.series, point),
        options=Shooting(Steps(walk=0, farthest=0.5)),
    )
    assert "no step lowers the miss" in direct.failure
    walked = shoot(flow, guess_from(balance.series, point), options=Shooting(Steps(farthest=0.5)))
    assert walked.converged
    assert walked.return_error < 1e-11
    assert abs(walked.energy_change) < 1e-11
    away = shoot(flow, guess_from(balance.series, point))  # by 0.44, and farther on the way
    assert "the family leads away" in away.failure
    nearest = shoot(
        flow,
        guess_from(balance.series, point),
        options=Shooting(Steps(farthest=0.1), keep_energy=False),
    )
    assert "another motion: its state" in nearest.failure


@pytest.mark.parametrize("reversible", [True, False])
def test_walk_and_newton_at_fixed_energy_lead_to_the_same_motion(reversible: bool) -> None:
    point, flow, steps = branch(10).points[-1], Flow(MODEL), Steps(walk_step=0.01)
    q, energy = point.motion.q.sum(axis=0), 1.15 * point.motion.energy
    target = Target(q, np.zeros(3), 1 / point.motion.frequency, energy)
    equations = period_map(flow, target, reversible=reversible)
    nearest = periodic_motion(equations, equations.start, steps, keep_energy=False)
    assert not nearest.failure
    assert nearest.miss.energy_error == pytest.approx(1 / 1.15 - 1, abs=0.01)
    close = replace(steps, stray=0.5 * np.linalg.norm(nearest.unknowns - equations.start))
    strayed = periodic_motion(equations, equations.start, close, keep_energy=False)
    assert "strays" in strayed.failure
    walked = walk_to_energy(equations, nearest, steps)
    direct = periodic_motion(equations, equations.start, steps, keep_energy=True)
    assert not walked.failure
    assert not direct.failure
    assert abs(walked.miss.energy_error) < 1e-12
    np.testing.assert_allclose(walked.unknowns, direct.unknowns, atol=1e-10)


def test_energy_that_the_family_does_not_reach_is_said() -> None:
    flow, balance, found = rod_point(1.95, harmonics=10)
    shot = shoot(flow, guess_from(balance.series, found.points[-1]))
    assert "no motion of this energy was reached from the nearest, which has +" in shot.failure
    assert shot.return_error < 1e-11  # what is given is the nearest motion, of another energy
    assert shot.energy_change > 1e-2


def test_other_motions_are_refused() -> None:
    series, flow = HarmonicBalance(10, 512).series, Flow(MODEL)
    points = branch(10).points
    touching = next(point for point in points if point.motion.contact_fraction > 0)
    grazing = next(
        point for point in points if point.gamma_ratio == pytest.approx(1.0)
    ).motion.energy
    without = shoot(flow, OrbitGuess.of(series, replace(touching.motion, energy=0.9 * grazing)))
    assert "does not touch" in without.failure
    assert without.return_error < 1e-10
    last = guess_from(series, points[-1])
    far = shoot(flow, replace(last, energy=4 * last.energy))
    assert "another motion" in far.failure
    slow = shoot(flow, last, options=Shooting(farthest_period=1e-9, keep_energy=True))
    assert "its frequency is" in slow.failure


def test_failures_of_the_flow_and_too_few_steps_are_reasons() -> None:
    series, point = HarmonicBalance(10, 512).series, branch(10).points[-1]
    assert (
        "changes of contact"
        in shoot(Flow(MODEL, most_changes=1), guess_from(series, point)).failure
    )
    one_step = Shooting(Steps(iterations=1, walk=0))
    assert (
        "after the last step allowed"
        in shoot(Flow(MODEL), guess_from(series, point), options=one_step).failure
    )
