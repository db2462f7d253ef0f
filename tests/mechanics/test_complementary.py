"""Contact forces at many points, against SciPy, known solutions and Signorini's conditions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics import complementary
from fenics_nnm.mechanics.complementary import first_guess
from fenics_nnm.mechanics.contact_law import Complementarity, ContactForces
from fenics_nnm.mechanics.penalty_law import AugmentedLagrangian


def along_tip(points: int) -> Array:
    return (np.arange(points) + 0.5) / points


def tip(points: int) -> Array:
    s = along_tip(points)
    return 2 * np.exp(-np.abs(s[:, None] - s) / 0.15)


def smooth(points: int, own: float = 1e-4) -> Array:
    """The flexibility of a layer that spreads forces over three points or so."""
    s = along_tip(points)
    return np.exp(-((s[:, None] - s) ** 2) * points**2 / 18) + own * np.eye(points)


def spreading(points: int, samples: int) -> Array:
    """Excess of a tip that meets a crowned obstacle in its middle and bends."""
    s, phase = along_tip(points), np.linspace(0, np.pi, samples)[:, None]
    bending = 0.1 * np.cos(3 * phase) * np.cos(np.pi * s)
    return 1.3 * np.cos(phase) + bending - 1 - 0.3 * (2 * s - 1) ** 2


def obey(R: Array, excess: Array, force: Array, tolerance: float = 1e-12) -> None:
    opening, scale = force @ R - excess, np.abs(excess).max()
    assert force.min() >= 0
    assert opening.min() > -tolerance * scale
    assert np.abs(np.where(force > 0, opening, 0.0)).max() < tolerance * scale


@pytest.mark.parametrize("flexibility", [tip, smooth])
def test_forces_are_those_of_bounded_least_squares(flexibility: Callable[[int], Array]) -> None:
    R, excess = flexibility(90), spreading(90, 25)
    force = Complementarity(R, np.zeros(90))(excess).force
    obey(R, excess, force)
    root = np.linalg.cholesky(R)
    for sample in (0, 2, 4):
        assert np.count_nonzero(force[sample]) > 10
        right = np.linalg.solve(root, excess[sample])
        found = lsq_linear(root.T, right, (0, np.inf), method="bvls", tol=1e-15).x
        np.testing.assert_allclose(force[sample], found, rtol=0, atol=1e-8 * found.max())


def cycles(R: Array, excess: Array) -> bool:
    """Whether points that change sides all at once, without a line search, come back."""
    active, seen = excess > 0, set()
    while active.tobytes() not in seen:
        seen.add(active.tobytes())
        force = np.zeros_like(excess)
        force[active] = np.linalg.solve(R[np.ix_(active, active)], excess[active])
        active = np.where(active, force > 0, R @ force < excess)
    return bool(np.any(force < 0) or np.any((R @ force - excess)[~active] < -1e-9))


def test_forces_are_found_where_a_plain_active_set_cycles() -> None:
    steps = np.random.default_rng(1).normal(size=(40, 60))
    R, excess = smooth(60), np.cos(0.1 * np.cumsum(steps, axis=1))
    assert sum(cycles(R, row) for row in excess) > 5
    obey(R, excess, Complementarity(R, np.zeros(60))(excess).force)


@pytest.mark.parametrize("flexibility", [tip, smooth])
@pytest.mark.parametrize("points", [7, 60])
def test_forces_are_known_where_points_touch_without_force(
    flexibility: Callable[[int], Array], points: int
) -> None:
    R, rng = flexibility(points), np.random.default_rng(5)
    force = np.maximum(rng.normal(size=(30, points)), 0.0)
    opening = np.where(force > 0, 0.0, np.maximum(rng.normal(size=(30, points)), 0.0))
    assert np.count_nonzero((force == 0) & (opening == 0)) > 20
    found = Complementarity(R, np.zeros(points))(force @ R - opening).force
    error = 1e-15 * points * np.linalg.cond(R) * force.max()
    np.testing.assert_allclose(found, force, rtol=0, atol=error)


@pytest.mark.parametrize("together", [1, 2, 4])
def test_points_that_come_into_contact_one_at_a_time_give_the_same_forces(
    together: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(6)
    Q, _ = np.linalg.qr(rng.normal(size=(20, 20)))
    R = (Q * np.logspace(0, -3, 20)) @ Q.T
    law, excess = Complementarity((R + R.T) / 2, np.zeros(20)), rng.normal(size=(40, 20))
    expected = law(excess).force
    monkeypatch.setattr(complementary, "_TOGETHER", together)
    found = law(excess).force
    obey(R, excess, found, 1e-11)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * expected.max())


def test_forces_are_found_where_the_flexibility_is_nearly_singular() -> None:
    R, rng = smooth(96, 1e-9), np.random.default_rng(0)
    assert np.linalg.cond(R) > 1e9
    excess = spreading(96, 33)
    for size in (0.0, 0.02, 0.02):
        loaded = excess + size * rng.normal(size=96)
        obey(R, loaded, Complementarity(R, np.zeros(96))(loaded).force, 1e-13)


def test_more_points_are_found_from_fewer() -> None:
    R, excess = tip(200), spreading(200, 25)[:6]
    touching = Complementarity(R, np.zeros(200))(excess).force > 0
    assert np.count_nonzero(touching ^ (excess > 0), axis=1).max() > 20
    assert np.count_nonzero(touching ^ first_guess(R, excess), axis=1).max() <= 4


def test_forces_do_not_depend_on_what_is_known_nearby() -> None:
    R, excess = tip(100), spreading(100, 25)
    law = Complementarity(R, np.zeros(100))
    alone = law(excess)
    rng = np.random.default_rng(7)
    for size in (1e-3, 0.3):
        near = law(excess + size * rng.normal(size=excess.shape))
        for known in (near, ContactForces.alone(near.force)):
            helped = law(excess, known)
            np.testing.assert_allclose(helped.force, alone.force, atol=1e-12 * alone.force.max())


@pytest.mark.parametrize("spring", [False, True])
def test_stiffness_is_that_of_the_slopes(spring: bool) -> None:
    excess, shapes = spreading(60, 25), np.random.default_rng(8).normal(size=(60, 4))
    kappa = np.random.default_rng(9).uniform(1, 2, excess.shape)
    of_springs = AugmentedLagrangian(np.zeros(60), kappa, np.zeros_like(kappa))
    forces = (of_springs if spring else Complementarity(tip(60), np.zeros(60)))(excess)
    local = shapes[forces.points]
    expected = np.swapaxes(local, 1, 2) @ (forces.slope @ local)
    found = forces.stiffness(shapes)
    assert found.shape == (len(forces.samples), 4, 4)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
