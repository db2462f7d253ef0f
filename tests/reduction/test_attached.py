"""Shapes that are added for forces at points: statics are exact, and little is lost in dynamics."""

import numpy as np
import pytest
from scipy.linalg import eigh

from fenics_nnm.errors import ModelError
from fenics_nnm.reduction.attached import enriched
from fenics_nnm.reduction.massless import massless_reduction
from fenics_nnm.reduction.operators import Operators

N = 30


def chain() -> tuple[np.ndarray, np.ndarray, Operators]:
    """A chain of equal masses and springs, held at its first end; contact at the other."""
    K = 2 * np.eye(N) - np.eye(N, k=1) - np.eye(N, k=-1)
    K[-1, -1] = 1.0
    M = np.eye(N)
    return (
        K,
        M,
        Operators(
            stiffness=lambda u: K @ u,
            mass=lambda u: M @ u,
            static=lambda f: np.linalg.solve(K, f),
            contact=lambda u: u[-1:],
            inner=lambda a, b: a.T @ b,
        ),
    )


def test_static_displacement_under_a_force_at_the_point_is_exact() -> None:
    K, M, operators = chain()
    squared, shapes = eigh(K, M)
    row = np.eye(N)[:, [11]]
    found = enriched(np.sqrt(squared[:4]), shapes[:, :4], row, operators)
    assert found.free == 4 and len(found.omega) == 5 and np.all(np.diff(found.omega) > 0)
    np.testing.assert_allclose(found.shapes.T @ M @ found.shapes, np.eye(5), atol=1e-10)
    np.testing.assert_allclose(
        found.shapes.T @ K @ found.shapes, np.diag(found.omega**2), atol=1e-10
    )
    static = found.shapes @ ((found.shapes.T @ row) / found.omega[:, None] ** 2)
    np.testing.assert_allclose(static, np.linalg.solve(K, row), atol=1e-10)
    # contact points keep their static flexibility, and forces at the point move them as they should
    attachments = np.linalg.solve(K, np.eye(N)[:, [-1]])
    reduction = massless_reduction(
        found.omega, found.shapes, attachments, np.array([1.0]), operators
    )
    assert reduction.model.static_flexibility[0] == pytest.approx(attachments[-1, 0], rel=1e-12)


def test_nothing_is_added_to_all_modes_or_without_points() -> None:
    K, M, operators = chain()
    squared, shapes = eigh(K, M)
    whole = enriched(np.sqrt(squared), shapes, np.eye(N)[:, [3]], operators)
    assert len(whole.omega) == N == whole.free
    assert (
        len(enriched(np.sqrt(squared[:3]), shapes[:, :3], np.zeros((N, 0)), operators).omega) == 3
    )


def test_point_without_mass_is_refused() -> None:
    K = np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.0, 1.0]])
    M = np.diag([1.0, 1.0, 0.0])
    operators = Operators(
        lambda u: K @ u,
        lambda u: M @ u,
        lambda f: np.linalg.solve(K, f),
        lambda u: u[:1],
        lambda a, b: a.T @ b,
    )
    squared, shapes = eigh(K[:2, :2])
    with pytest.raises(ModelError, match="moves no mass"):
        enriched(np.sqrt(squared), np.vstack([shapes, [[0, 0]]]), np.eye(3)[:, [2]], operators)


def test_two_points_at_one_place_add_one_shape() -> None:
    """A spring and an excitation at one unknown, of opposite sign, and one between two others."""
    K, M, operators = chain()
    squared, shapes = eigh(K, M)
    one, other = np.eye(N)[:, [11]], np.eye(N)[:, [20]]
    rows = np.hstack([one, -2 * one, other, one + 3 * other])
    found = enriched(np.sqrt(squared[:4]), shapes[:, :4], rows, operators)
    assert len(found.omega) == 6
    static = found.shapes @ ((found.shapes.T @ rows) / found.omega[:, None] ** 2)
    np.testing.assert_allclose(static, np.linalg.solve(K, rows), atol=1e-9)
