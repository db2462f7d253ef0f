"""Forces at many points of which few take part, and in groups of sets: those of all together."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics import factored_parts, set_flexibility
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.factored_parts import FactoredParts
from fenics_nnm.mechanics.near_contact import NearContact

POINTS = 300


def places() -> Array:
    return (np.arange(POINTS) + 0.5) / POINTS


def flexibility(lever: float = 0.0) -> Array:
    """That of a layer; with a lever, a force at one end lifts the other end."""
    s = places()
    tilt = s - 0.5
    return (
        np.exp(-np.abs(s[:, None] - s) / 0.05) + 0.3 * np.eye(POINTS) + lever * tilt[:, None] * tilt
    )


def moving(speed: float) -> Array:
    """Excess of a wave that runs along the points, at 33 samples."""
    phase = np.linspace(0, np.pi, 33)[:, None]
    return np.cos(4 * np.pi * places() + speed * phase) * np.cos(phase) - 0.1


def obey(R: Array, excess: Array, force: Array) -> None:
    opening, scale = force @ R - excess, np.abs(excess).max()
    assert force.min() >= 0 and opening.min() > -1e-12 * scale
    assert np.abs(np.where(force > 0, opening, 0.0)).max() < 1e-12 * scale


def at_an_end(depth: float) -> Array:
    """Excess of an end that dips in, with all other points far from their gaps."""
    return depth * np.linspace(1, 0.2, 9)[:, None] - 4.0 * places()


def test_points_far_from_contact_take_no_part() -> None:
    R, excess = flexibility(), at_an_end(0.5)
    found = Complementarity(R, np.zeros(POINTS))(excess)
    assert isinstance(found.local, NearContact)
    assert np.count_nonzero(excess.max(axis=0) > 0) <= len(found.local.chosen) < 60
    obey(R, excess, found.force)
    shapes = np.random.default_rng(0).normal(size=(POINTS, 3))
    found_stiffness, whole = found.stiffness(shapes), found.light().stiffness(shapes)
    touching = found.force[0] > 0
    expected = shapes[touching].T @ np.linalg.solve(R[np.ix_(touching, touching)], shapes[touching])
    np.testing.assert_allclose(found_stiffness[0], expected, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(whole, found_stiffness, rtol=1e-11, atol=1e-11)


def test_a_point_that_others_push_beyond_its_gap_takes_part_in_the_end() -> None:
    R, excess = flexibility(lever=20.0), at_an_end(1.0)
    excess[:, 250:] = -0.35
    start = NearContact.at(R, excess)
    assert start.chosen.max() < 250
    found = Complementarity(R, np.zeros(POINTS))(excess)
    assert (found.force[:, 250:] > 0).any()
    obey(R, excess, found.force)


@pytest.mark.parametrize("kept", [2**29, 2 * 10**6, 0])
def test_sets_that_are_nested_in_groups_have_the_forces_of_each_alone(
    kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    R, excess = flexibility(), moving(4.0)
    shapes = np.random.default_rng(1).normal(size=(POINTS, 3))
    law = Complementarity(R, np.zeros(POINTS))
    alone = law(excess)
    monkeypatch.setattr(set_flexibility, "_LARGE", 40)
    monkeypatch.setattr(factored_parts, "_KEPT", kept)
    grouped, further = law(excess), law(1.05 * excess, alone)
    parts = grouped.local.among.parts.parts
    assert (len(parts) > 2) == (kept > 0)
    assert sum(part.bytes_ for part in parts) <= kept
    scale = alone.force.max()
    np.testing.assert_allclose(grouped.force, alone.force, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(further.force, law(1.05 * excess).force, atol=1e-12 * scale)
    expected = alone.stiffness(shapes)
    np.testing.assert_allclose(
        grouped.stiffness(shapes), expected, rtol=0, atol=1e-11 * np.abs(expected).max()
    )


def test_factors_of_groups_serve_sets_nearby_and_points_with_other_numbers() -> None:
    R, sets = flexibility(), moving(4.0) > 0.3
    factors = FactoredParts().suited(R, sets)
    assert factors.suited(R, sets) is factors
    gaps = np.random.default_rng(2).normal(size=sets.shape)
    force = factors.on(R, sets).closing(gaps)
    spread = np.zeros((2 * POINTS, 2 * POINTS))
    spread[np.ix_(range(0, 2 * POINTS, 2), range(0, 2 * POINTS, 2))] = R
    wide_sets, wide_gaps = np.zeros((2, len(sets), 2 * POINTS))
    wide_sets[:, ::2], wide_gaps[:, ::2] = sets, gaps
    wide = factors.among(np.arange(0, 2 * POINTS, 2)).on(spread, wide_sets > 0)
    assert wide.chosen.min() >= 0
    np.testing.assert_allclose(wide.closing(wide_gaps)[:, ::2], force, rtol=1e-13, atol=1e-13)
