"""Modes of equal frequency: one basis, whatever the eigensolver gives."""

import numpy as np
import pytest

from fenics_nnm.reduction.clusters import groups, unique_basis
from fenics_nnm.reduction.linear_modes import LinearModes

OMEGA = np.array([1.0, 3.0, 3.0 + 1e-8, 5.0, 7.0, 7.0, 7.0])


def turned(count: int, seed: int) -> np.ndarray:
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(count, count)))
    return q


def test_groups_of_equal_frequencies() -> None:
    assert [group.tolist() for group in groups(OMEGA)] == [[1, 2], [4, 5, 6]]
    assert list(groups(np.array([1.0, 1.001, 2.0]))) == []


def test_basis_does_not_depend_on_the_one_given() -> None:
    rng = np.random.default_rng(1)
    shapes, B = np.linalg.qr(rng.normal(size=(20, 7)))[0], rng.normal(size=(4, 20))
    found = []
    for seed in (2, 3):
        rotation = np.eye(7)
        rotation[1:3, 1:3], rotation[4:, 4:] = turned(2, seed), turned(3, seed)
        modes = LinearModes(OMEGA, shapes @ rotation, 0.0).unique(lambda u: B @ u)
        np.testing.assert_allclose(modes.shapes.T @ modes.shapes, np.eye(7), atol=1e-12)
        found.append(modes.shapes)
    signs = np.sign(np.sum(found[0] * found[1], axis=0))
    np.testing.assert_allclose(found[0], found[1] * signs, atol=1e-10)
    # the first of a group moves the contact points as much as any combination can
    group = B @ found[0][:, 4:]
    assert np.linalg.norm(group[:, 0]) == pytest.approx(np.linalg.norm(group, 2))
    assert np.all(np.diff(np.linalg.norm(group, axis=0)) < 0)


def test_modes_of_different_frequencies_stay_as_they_are() -> None:
    modes = LinearModes(np.array([1.0, 2.0]), np.eye(2), 0.0)
    assert modes.unique(lambda u: u) is modes
    np.testing.assert_array_equal(unique_basis(modes.omega, np.ones((1, 2))), np.eye(2))
