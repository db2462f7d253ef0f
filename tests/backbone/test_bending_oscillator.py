"""One mass that bends far, with a stop, against its exact period: a quadrature.

(1 + D q^2) q'' + D q q'^2 + w^2 q + alpha q^2 + beta q^3 + (phi + theta q) (p - g)_+ / R = 0,
p = phi q + theta q^2 / 2, has T = 2 int sqrt((1 + D q^2) / (2 (E - V(q)))) dq.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from fenics_nnm.backbone.follow import (
    ArcContinuation,
    EnergyContinuation,
    FrequencyContinuation,
    follow,
)
from fenics_nnm.backbone.levels import HarmonicBalance, levels
from fenics_nnm.backbone.outlook import outlook
from fenics_nnm.backbone.point import VERIFIED, BranchPoint
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.nonlinear.conditions import FixedEnergy
from fenics_nnm.nonlinear.equations import harmonic_equations
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.solution import evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns

OMEGA, PHI, THETA, ALPHA, BETA, D, R, GAP = 2.0, 1.5, -0.8, -0.3, 0.9, 0.7, 0.05, 0.5
RECORD = SecondOrder([0], [[[THETA]]], [[[ALPHA]]], [[[[BETA]]]], [[[[D]]]])
MODEL = ReducedModel([OMEGA], [[PHI]], [[R]], [GAP], kinematics=RECORD)
BALANCE = HarmonicBalance(20, 256)


def potential(q: float) -> float:
    over = max(PHI * q + THETA * q**2 / 2 - GAP, 0.0)
    return (OMEGA * q) ** 2 / 2 + ALPHA * q**3 / 3 + BETA * q**4 / 4 + over**2 / (2 * R)


def frequency(energy: float) -> float:
    """Frequency in Hz from the quadrature, split where contact begins."""
    left, right = (brentq(lambda q: potential(q) - energy, *b) for b in ((-5.0, 0.0), (0.0, 5.0)))
    kink = (-PHI + np.sqrt(PHI**2 + 2 * THETA * GAP)) / THETA
    inner = [q for q in (0.0, kink) if left < q < right]
    half = 0.0
    for start, end in zip([left, *inner], [*inner, right], strict=True):
        middle = (start + end) / 2
        half += _part(energy, start, middle) + _part(energy, end, middle)
    return 1 / (2 * half)


def _part(energy: float, turn: float, to: float) -> float:
    nodes, weights = np.polynomial.legendre.leggauss(40)
    s = (nodes + 1) / 2
    q = turn + (to - turn) * s**2  # no singular end
    left = energy - np.array([potential(each) for each in q])
    return float(weights @ (s * abs(to - turn) * np.sqrt((1 + D * q**2) / (2 * left))))


def rayleigh(energy: float) -> float:
    """Rayleigh frequency in Hz without contact: <T> is half the action over the period."""
    left, right = (brentq(lambda q: potential(q) - energy, *b) for b in ((-5.0, 0.0), (0.0, 5.0)))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    q = (right + left + (right - left) * np.sin(np.pi * nodes / 2)) / 2  # no singular ends
    speed = np.array([2 * (energy - potential(each)) for each in q])
    slope = np.pi * (right - left) / 4 * np.cos(np.pi * nodes / 2)
    kinetic = weights @ (slope * np.sqrt(speed * (1 + D * q**2))) * frequency(energy)
    return float(frequency(energy) * np.sqrt(energy / kinetic - 1))


def assert_exact(point: BranchPoint, rel: float = 2e-5) -> None:
    exact = frequency(point.motion.energy)
    assert point.motion.frequency == pytest.approx(exact, rel=rel)
    assert point.balance.virial_error < 1e-9
    assert point.verdict is not None and point.verdict.status == VERIFIED, point.verdict
    assert point.orbit is not None
    assert point.orbit.frequency == pytest.approx(exact, rel=1e-8)
    assert point.stability is not None and point.stability.kind == "stable"


def test_branch_over_energy_is_exact_below_and_above_contact() -> None:
    ratios = (0.1, 0.9, 1.2, 3.0)
    wanted = EnergyContinuation(0.1, 3.0, 5.0, report_at=ratios)
    found = follow(MODEL, wanted, BALANCE, mode=0, shooting=True)
    assert found.complete, found.reason
    touched = [point.motion.contact_fraction > 0 for point in found.points]
    assert touched == [False, False, True, True]
    for point in found.points:
        assert_exact(point)
    for point in found.points[:2]:
        exact = rayleigh(point.motion.energy)
        assert point.motion.rayleigh_frequency == pytest.approx(exact, rel=1e-9)
    # without contact it softens: what second order adds, not the stop
    assert found.points[1].frequency_ratio < found.points[0].frequency_ratio < 1
    ahead = outlook(MODEL, wanted, BALANCE, mode=0)
    assert ahead.frequency_ratio[0] == pytest.approx(found.points[1].frequency_ratio, rel=0.01)


def test_rayleigh_frequency_lies_halfway_to_that_of_small_motions() -> None:
    """The virial identity makes its error half of what second order changes, as a^2 -> 0."""
    wanted = EnergyContinuation(1e-3, 1e-2, 9e-3)
    found = follow(MODEL, wanted, HarmonicBalance(4, 32), mode=0)
    linear = OMEGA / (2 * np.pi)
    for point, error in zip(found.points, (5e-4, 5e-3), strict=True):
        changed = point.motion.frequency / linear - 1
        share = (point.motion.rayleigh_frequency / linear - 1) / changed
        assert abs(changed) > 1e-6
        assert share == pytest.approx(0.5, abs=error)


def test_branches_over_frequency_and_by_arc_length_pass_the_same_motions() -> None:
    by_frequency = follow(
        MODEL, FrequencyContinuation(1.05, 1.1, 0.05), BALANCE, mode=0, shooting=True
    )
    assert by_frequency.complete, by_frequency.reason
    by_length = follow(MODEL, ArcContinuation(1.1, 1.6, 0.4), BALANCE, mode=0, shooting=True)
    assert len(by_length.points) > 1, by_length.reason
    for point in (*by_frequency.points, *by_length.points):
        assert_exact(point, rel=5e-5)


def test_newton_looks_beyond_a_kink_before_it_shortens_steps() -> None:
    """From half the harmonics: the same motion in fewer steps than a line search alone takes."""
    model = ReducedModel([OMEGA], [[PHI]], [[R / 10]], [GAP], kinematics=RECORD)
    law = Complementarity(model.R, model.gap)
    coarse, fine = (harmonic_equations(model, CosineSeries(N, 256), law) for N in (10, 20))
    condition = FixedEnergy((OMEGA * 0.46) ** 2 / 4)
    first = np.zeros(coarse.shape)
    first[1] = 0.46
    below = solve(coarse, condition, Unknowns.of(first, OMEGA))
    guess = Unknowns.of(fine.series.fitted(below.q), below.omega)
    alone, found = (solve(fine, condition, guess, options=Newton(leaps=n)) for n in (0, 5))
    assert alone.converged and found.converged
    assert found.omega == pytest.approx(alone.omega, rel=1e-9)
    assert found.iterations < alone.iterations


def test_modes_that_a_level_lacks_follow_to_the_next_one() -> None:
    """q_1 = -alpha q_0^2 / omega_1^2: with q_0 = A cos, half of A^2 each in harmonics 0 and 2."""
    order = SecondOrder([0], [[[0.0]]], [[[0.0]], [[0.4]]], np.zeros((1,) * 4), np.zeros((1,) * 4))
    model = ReducedModel([1.0, 7.0], [[1.0, 0.5]], [[R]], [9.0], kinematics=order)
    lower, upper = levels(model, HarmonicBalance(4, 64), mode=0)[:2]
    q = np.zeros(lower.equations.shape)
    q[1, 0] = 0.3
    found = upper.above(lower, evaluated(lower.equations, Unknowns.of(q, 1.0)))
    wanted = np.zeros(upper.equations.shape)
    wanted[1, 0], wanted[[0, 2], 1] = 0.3, -0.4 * 0.3**2 / 2 / 49
    assert found.q == pytest.approx(wanted, abs=1e-15)
