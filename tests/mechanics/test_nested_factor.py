"""One factor for many sets of points, against a matrix of its own for each."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.mechanics.nested_factor import NestedFactor, NestedOrder
from fenics_nnm.mechanics.set_flexibility import ScatteredSets, SetFlexibility

POINTS, MODES = 40, 5


def flexibility(points: int = POINTS) -> Array:
    s = (np.arange(points) + 0.5) / points
    return 2 * np.exp(-np.abs(s[:, None] - s) / 0.15)


def nested_sets(flips: int, seed: int = 0) -> Mask:
    """Growing patches about the middle, with some points taken at random put in or out."""
    rng = np.random.default_rng(seed)
    reach = np.linspace(0, 0.5, 12)[:, None]
    sets = np.abs((np.arange(POINTS) + 0.5) / POINTS - 0.47) < reach
    for row in sets:
        row[rng.choice(POINTS, flips, replace=False)] ^= True
    return sets


@pytest.mark.parametrize("flips", [0, 1, 4])
def test_forces_and_stiffness_are_those_of_a_matrix_for_each_set(flips: int) -> None:
    R, sets, rng = flexibility(), nested_sets(flips), np.random.default_rng(1)
    factored = NestedFactor.of(R, NestedOrder.of(nested_sets(0))).on(sets)
    assert (factored.points.shape[1] > 0) == (flips > 0)
    if flips:
        assert factored.removed.any() and factored.added.any()
    gaps, shapes = rng.normal(size=sets.shape), rng.normal(size=(POINTS, MODES))
    force, stiffness = factored.closing(gaps), factored.stiffness(shapes)
    for k, chosen in enumerate(sets):
        block = R[np.ix_(chosen, chosen)]
        expected = np.zeros(POINTS)
        expected[chosen] = np.linalg.solve(block, gaps[k, chosen])
        scale = max(np.abs(expected).max(), 1e-9)
        np.testing.assert_allclose(force[k], expected, rtol=0, atol=1e-12 * scale)
        held = shapes[chosen].T @ np.linalg.solve(block, shapes[chosen])
        np.testing.assert_allclose(stiffness[k], held, rtol=0, atol=1e-11 * np.abs(stiffness).max())


def test_gaps_close_to_round_off_however_badly_the_flexibility_is_conditioned() -> None:
    rng = np.random.default_rng(2)
    Q, _ = np.linalg.qr(rng.normal(size=(POINTS, POINTS)))
    R = (Q * np.logspace(0, -8, POINTS)) @ Q.T
    R, sets = (R + R.T) / 2, nested_sets(2)
    gaps = rng.normal(size=sets.shape)
    force = NestedFactor.of(R, NestedOrder.of(sets)).on(sets).closing(gaps)
    left = np.where(sets, force @ R - gaps, 0.0)
    assert np.abs(left).max() < 1e-15 * POINTS * (1 + np.abs(R).max() * np.abs(force).sum(1).max())


def test_a_factor_is_kept_while_sets_are_nearly_nested_and_each_has_its_own_where_not() -> None:
    rng = np.random.default_rng(3)
    R = flexibility(80)
    s = (np.arange(80) + 0.5) / 80
    grown = np.abs(s - 0.5) < np.linspace(0.1, 0.45, 10)[:, None]
    suited = SetFlexibility(R).suited(grown)
    assert suited.factor is not None and suited.factor.order.flips == 0
    moved = np.abs(s - 0.51) < np.linspace(0.1, 0.45, 10)[:, None]
    assert suited.suited(moved) is suited
    elsewhere = np.abs(s - 0.2) < np.linspace(0.1, 0.7, 10)[:, None]
    other = suited.suited(elsewhere)
    assert other.factor is not None and other.factor is not suited.factor
    scattered = rng.random((10, 80)) < 0.6
    assert suited.suited(scattered).factor is None
    assert isinstance(suited.suited(scattered).on(scattered), ScatteredSets)


def test_an_indefinite_flexibility_is_refused() -> None:
    R = flexibility()
    R[7, 7] = -0.1
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        NestedFactor.of(R, NestedOrder.of(nested_sets(0)))
