"""What a reduction leaves out: each kind says what it can do."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.reduction.truncation import GalerkinTruncation, MasslessTruncation, ReducedMotion

GALERKIN = GalerkinTruncation(np.diag([2.0, 3.0]))


def motion(q: list[list[float]], ell: list[list[float]]) -> ReducedMotion:
    """A static part and one cosine of a motion at omega = 2."""
    return ReducedMotion(
        omega=2.0,
        order=np.array([0.0, 1.0]),
        mean_square=np.array([1.0, 0.5]),
        q=np.array(q),
        ell=np.array(ell),
        gamma_weight=np.array([[1.0], [0.5]]),
        pushed=lambda displacement: 10 * displacement,
    )


def test_modes_with_mass_are_not_nested() -> None:
    with pytest.raises(TypeError, match="not nested"):
        GALERKIN.without(np.array([1.0]), np.array([[1.0]]))
    with pytest.raises(TypeError, match="no residual flexibility"):
        GALERKIN.residual_flexibility(3)


def test_full_order_softens_each_harmonic_of_a_basis() -> None:
    """By (n omega)^4 T^T K T: here 16 times 2 and 3, and nothing of the static part."""
    left_out = GALERKIN.left_out(motion([[5.0, 5.0], [1.0, -1.0]], [[0.0], [0.0]]))
    np.testing.assert_allclose(left_out.equations, [[0.0, 0.0], [-32.0, 48.0]])
    assert left_out.square == pytest.approx(0.5 * 16 * (2 + 3))
    assert left_out.gamma == pytest.approx(0.5 * 16 * (2 + 3) / 4)


def test_inertia_of_the_residual_shapes_moves_the_contact_points() -> None:
    """D = s (X^T M X + s X^T M K^-1 M X) with s = 4, and D' = X^T M X + 2 s X^T M K^-1 M X."""
    truncation = MasslessTruncation(np.array([[0.5]]), np.array([[0.25]]))
    left_out = truncation.left_out(motion([[0.0], [0.0]], [[7.0], [2.0]]))
    D, slope = 4 * (0.5 + 4 * 0.25), 0.5 + 2 * 4 * 0.25
    np.testing.assert_allclose(left_out.equations, [[0.0], [-10 * D * 2]])
    assert left_out.square == pytest.approx(0.5 * 16 * 0.25 * 4)
    assert left_out.gamma == pytest.approx((1.0 * 0.5 * 49 + 0.5 * slope * 4) / 2)
