"""A mass on a cubic spring, with and without a stop, against its exact period.

m x'' + k x + k3 x^3 + (x - g)_+ / R = 0. Without the stop the frequency is a complete elliptic
integral; with it the period is a quadrature of the potential.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Ended
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipk

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.order import ReducedOrder
from fenics_nnm.backbone.point import VERIFIED, BranchPoint
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.force import CubicSprings
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.results import branch_file

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

MASS, SPRING, CUBIC, STOP, GAP = 2.0, 800.0, 4e6, 5000.0, 0.02


def elliptic_frequency(energy: float) -> float:
    """Circular frequency without the stop, of the energy k a^2 / 2 + k3 a^4 / 4."""
    square = (np.sqrt(SPRING**2 + 4 * CUBIC * energy) - SPRING) / CUBIC  # a^2
    stiff = SPRING + CUBIC * square
    return float(np.pi / 2 * np.sqrt(stiff / MASS) / ellipk(CUBIC * square / (2 * stiff)))


def potential(x: float, stop: float) -> float:
    over = max(x - GAP, 0.0)
    return SPRING * x**2 / 2 + CUBIC * x**4 / 4 + stop * over**2 / 2


def frequency(energy: float, stop: float) -> float:
    """Circular frequency from the period 2 int dx / v, split where contact begins."""
    ends = [brentq(lambda x: potential(x, stop) - energy, *b) for b in ((-1.0, 0.0), (0.0, 1.0))]
    middle = min(GAP, ends[1])

    def part(turn: float, to: float) -> float:
        def slowness(s: float) -> float:  # x = turn + (to - turn) s^2: no singular end
            x = turn + (to - turn) * s**2
            left = max(energy - potential(x, stop), 1e-300)
            return float(2 * s * abs(to - turn) / np.sqrt(2 * left / MASS))

        return float(quad(slowness, 0, 1, epsabs=0, epsrel=1e-11, limit=200)[0])

    half = part(ends[0], 0.0) + part(ends[1], 0.0 if middle == ends[1] else middle)
    if middle < ends[1]:
        half += quad(
            lambda x: 1 / np.sqrt(2 * (energy - potential(x, stop)) / MASS), 0, middle, epsrel=1e-11
        )[0]
    return float(np.pi / half)


def branch(
    gap: float, ratios: list[float], harmonics: int, samples: int
) -> tuple[BranchPoint, ...]:
    model = ReducedModel([np.sqrt(SPRING / MASS)], [[MASS**-0.5]], [[1 / STOP]], [gap])
    springs = CubicSprings(np.array([[MASS**-0.5]]), np.array([CUBIC]))
    found = follow(
        model,
        EnergyContinuation(ratios[0], ratios[-1], 10.0, report_at=tuple(ratios)),
        HarmonicBalance(harmonics, samples),
        mode=0,
        order=ReducedOrder(forces=(springs,)),
        shooting=True,
    )
    assert found.complete, found.reason
    return found.points


def test_quadrature_is_the_elliptic_integral_without_a_stop() -> None:
    for energy in (0.01, 0.5, 3.0):
        assert frequency(energy, 0.0) == pytest.approx(elliptic_frequency(energy), rel=1e-9)


def test_without_a_stop() -> None:
    """A stop so far away that nothing touches: the spring alone makes the mode nonlinear."""
    points = branch(0.1, [1e-4, 1e-3, 0.01, 0.05, 0.2, 0.5], 11, 64)
    rise = points[-1].motion.frequency / points[0].motion.frequency
    assert rise > 3  # far from linear
    for point in points:
        omega = 2 * np.pi * point.motion.frequency
        assert omega == pytest.approx(elliptic_frequency(point.motion.energy), rel=2e-7)
        assert point.motion.contact_fraction == 0
        assert point.balance.virial_error < 1e-9
        assert point.verdict is not None and point.verdict.status == VERIFIED
        assert point.stability is not None and point.stability.kind == "stable"


def test_with_a_stop() -> None:
    points = branch(GAP, [0.2, 0.7, 1.1, 1.5, 3.0], 40, 512)
    assert [point.motion.contact_fraction > 0 for point in points] == [False] * 2 + [True] * 3
    for point in points:
        omega, energy = 2 * np.pi * point.motion.frequency, point.motion.energy
        assert omega == pytest.approx(frequency(energy, STOP), rel=1e-5)
        assert point.balance.virial_error < 1e-9
        assert point.verdict is not None and point.verdict.status == VERIFIED
        assert point.orbit is not None
        assert 2 * np.pi * point.orbit.frequency == pytest.approx(frequency(energy, STOP), rel=1e-8)


def test_points_at_rest_on_their_obstacles_are_refused() -> None:
    with pytest.raises(ModelError, match="must be positive with springs"):
        branch(-0.01, [0.5, 1.5], 5, 64)


def test_study_of_matrices(tmp_path: Path, study_file: StudyFile, command: Command) -> None:
    """The mass touches through a massless unknown on the spring of the stop."""
    K = np.array([[SPRING + STOP, -STOP], [-STOP, STOP]])
    np.savez(tmp_path / "duffing.npz", K=K, M=np.diag([MASS, 0.0]), B=[[0.0, 1.0]])
    study: dict[str, Any] = {
        "matrices": {"file": "duffing.npz"},
        "spring": [{"unknown": 1, "cubic": CUBIC}],
        "contact": {"gap": GAP},
        "reduction": {"modes": 1},
        "mode": {"number": 1, "harmonics": 30, "samples": 256},
        "continuation": {"energies": {"from": 0.5, "to": 1.5, "step": 0.5}, "report_at": [1.5]},
    }
    path = study_file(base=study)
    ended = command("run", path, "--output", tmp_path / "results")
    assert ended.code == 0, ended.err
    for point in branch_file.read(tmp_path / "results" / "branch.h5")[1]:
        omega = 2 * np.pi * point.motion.frequency
        assert omega == pytest.approx(frequency(point.motion.energy, STOP), rel=2e-5)
