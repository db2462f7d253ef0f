"""Signorini's conditions at the samples, against enumeration and differences."""

import itertools

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity, ContactForces


def flexibility(points: int, seed: int) -> Array:
    """A random symmetric positive definite matrix, far from diagonal."""
    factor = np.random.default_rng(seed).normal(size=(points, points))
    return factor @ factor.T + 0.05 * np.eye(points)


def enumerated(R: Array, excess: Array) -> Array:
    """The one solution of the complementarity problem among all 2^n active sets."""
    points = len(excess)
    for size in range(points + 1):
        for chosen in map(list, itertools.combinations(range(points), size)):
            force = np.zeros(points)
            force[chosen] = np.linalg.solve(R[np.ix_(chosen, chosen)], excess[chosen])
            if np.all(force >= -1e-12) and np.all(R @ force - excess >= -1e-10):
                return force
    raise AssertionError("no active set solves the problem")


@pytest.mark.parametrize("seed", range(5))
def test_forces_are_those_of_the_only_admissible_active_set(seed: int) -> None:
    R = flexibility(6, seed)
    gap = np.full(6, 0.1)
    displacement = np.random.default_rng(100 + seed).normal(size=(40, 6))
    force = Complementarity(R, gap)(displacement).force
    for found, excess in zip(force, displacement - gap, strict=True):
        np.testing.assert_allclose(found, enumerated(R, excess), atol=1e-9)


def test_one_point_is_a_unilateral_spring() -> None:
    law = Complementarity(np.array([[0.02]]), np.array([1.0]))
    force = law(np.array([[0.5], [1.0], [1.5]])).force
    np.testing.assert_allclose(force[:, 0], [0.0, 0.0, 25.0])


def test_signorini_holds_to_round_off_with_many_points() -> None:
    R, gap = flexibility(40, 3), np.linspace(0.1, 0.4, 40)
    displacement = np.random.default_rng(4).normal(size=(30, 40))
    force = Complementarity(R, gap)(displacement).force
    opening = gap - (displacement - force @ R)
    assert force.min() >= 0
    assert opening.min() > -1e-10
    assert np.abs(force * opening).max() < 1e-9 * force.max()


def full_slope(forces: ContactForces, points: int) -> Array:
    slope = np.zeros((len(forces.force), points, points))
    for sample, chosen, block in zip(forces.samples, forces.points, forces.slope, strict=True):
        slope[sample][np.ix_(chosen, chosen)] += block
    return slope


def test_slope_against_differences() -> None:
    R, gap = flexibility(5, 7), np.full(5, 0.1)
    law = Complementarity(R, gap)
    displacement = np.random.default_rng(8).normal(size=(12, 5))
    slope = full_slope(law(displacement), 5)
    step = 1e-7
    for point in range(5):
        ahead, behind = displacement.copy(), displacement.copy()
        ahead[:, point] += step
        behind[:, point] -= step
        difference = (law(ahead).force - law(behind).force) / (2 * step)
        scale = np.abs(slope).max()
        np.testing.assert_allclose(slope[:, :, point], difference, atol=1e-6 * scale)


def test_no_contact_gives_no_force_and_no_slope() -> None:
    forces = Complementarity(np.eye(2), np.ones(2))(np.zeros((4, 2)))
    assert not forces.force.any()
    assert forces.samples.size == 0
