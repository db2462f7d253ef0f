"""Contact forces of few points from a table of sets, against the general search."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics import few_points
from fenics_nnm.mechanics.complementary import complementary
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.few_points import FewPoints
from fenics_nnm.mechanics.near_contact import NearContact
from fenics_nnm.mechanics.set_flexibility import SetFlexibility


def flexibility(points: int, condition: float = 1e3) -> Array:
    Q, _ = np.linalg.qr(np.random.default_rng(points).normal(size=(points, points)))
    R = (Q * np.geomspace(1.0, 1 / condition, points)) @ Q.T
    return np.asarray((R + R.T) / 2)


@pytest.mark.parametrize("condition", [10.0, 1e7])
@pytest.mark.parametrize("points", [1, 3, 8])
@pytest.mark.parametrize("rounds", [1, 4])
def test_forces_are_those_of_the_search(
    points: int, condition: float, rounds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(few_points, "_ROUNDS", rounds)
    R = flexibility(points, condition)
    excess = np.random.default_rng(1).normal(size=(200, points))
    force, _ = FewPoints.of(R).forces(excess)
    expected, _ = complementary(SetFlexibility(R), excess)
    assert 0 < np.count_nonzero(expected) < expected.size
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-14 * condition * force.max())
    opening, scale = force @ R - excess, np.abs(excess).max() + np.diag(R).max() * force.sum()
    assert force.min() >= 0
    assert opening.min() > -4e-15 * scale
    assert np.abs(np.where(force > 0, opening, 0.0)).max() < 4e-15 * scale


def test_a_guess_of_the_points_in_contact_changes_nothing() -> None:
    R, rng = flexibility(5), np.random.default_rng(2)
    excess, table = rng.normal(size=(100, 5)), FewPoints.of(R)
    force, _ = table.forces(excess)
    again, _ = table.forces(excess, rng.random((100, 5)) < 0.5)
    np.testing.assert_allclose(again, force, rtol=0, atol=1e-11 * force.max())


def test_a_law_of_few_points_has_a_table_unless_its_flexibility_is_nearly_singular() -> None:
    assert isinstance(Complementarity(flexibility(8), np.zeros(8)).flexibility, FewPoints)
    for R in (flexibility(8, 1e9), flexibility(11)):
        assert isinstance(Complementarity(R, np.zeros(len(R))).flexibility, NearContact)


def test_stiffness_of_sets_is_that_of_each_set() -> None:
    R, rng = flexibility(4), np.random.default_rng(3)
    sets, shapes = rng.random((30, 4)) < 0.5, rng.normal(size=(4, 3))
    found = FewPoints.of(R).stiffness(sets, shapes)
    for chosen, stiffness in zip(sets, found, strict=True):
        own = shapes[chosen]
        expected = own.T @ np.linalg.solve(R[np.ix_(chosen, chosen)], own)
        np.testing.assert_allclose(stiffness, expected, rtol=0, atol=1e-12 * np.abs(found).max())
