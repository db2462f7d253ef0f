"""Massless-boundary reduction: free modes and residual flexibility of the contact points."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, TooManyModesError
from fenics_nnm.mechanics.definite import factorises, largest_at_most, surely_above
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.rest import towards_obstacle
from fenics_nnm.reduction.attached import AttachedPoints, enriched
from fenics_nnm.reduction.operators import Operators
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.reduction.truncation import massless_truncation

#: Least part of the static flexibility that R must keep for any motion of the contact points.
#: Forces are displacements over R: below this, round-off in displacements shows in the equations
#: above the tolerance of 1e-10 that they are solved to.
_LEAST_PART = 1e-6

#: R with a smaller eigenvalue than this part of the largest one of S is zero to round-off.
_ZERO = 1e-12


def massless_model(omega: Array, Phi: Array, S: Array, gap: Array) -> ReducedModel:
    r"""MacNeal's reduction, with the contact points left without mass.

        R = S - Phi diag(1 / omega^2) Phi^T

    is the static flexibility of the contact points that the J modes do not bring.
    Monjaraz-Tec, Gross, Krack, Comput. Struct. 260 (2022) 106698.

    Args:
        omega: Circular frequencies in rad/s, shape (J,).
        Phi: Mass-normalised modes at the contact points in the contact direction, (n_c, J).
        S: Static flexibility B K^-1 B^T in m/N, shape (n_c, n_c).
        gap: Gaps in m, shape (n_c,).

    Raises:
        TooManyModesError: if R is not positive definite to round-off: points whose motion the
            modes span altogether, or two points at one place; or if it is below 1e-6 of S.
    """
    S = (S + S.T) / 2
    modal = Phi / omega
    R = S - modal @ modal.T
    _assert_flexible(R, S)
    return ReducedModel(omega=omega, Phi=Phi, R=(R + R.T) / 2, gap=gap)


def _assert_flexible(R: Array, S: Array) -> None:
    """Refuse a residual flexibility that is zero to round-off, or all but zero beside S."""
    if surely_above(R, _ZERO * largest_at_most(S)) and factorises(R - _LEAST_PART * S):
        return
    lowest = float(np.linalg.eigvalsh(R)[0])
    if lowest <= _ZERO * float(np.linalg.eigvalsh(S)[-1]):
        raise TooManyModesError(
            f"massless reduction: the residual flexibility has the eigenvalue {lowest:.3g} m/N, "
            "which is zero to round-off: use fewer modes or fewer contact points",
            code=Code.TOO_MANY_MODES,
        )
    part = float(eigh(R, S, eigvals_only=True, subset_by_index=[0, 0])[0])
    if part < _LEAST_PART:
        raise TooManyModesError(
            f"massless reduction: the modes leave contact points {part:.1e} of their static "
            f"flexibility, less than {_LEAST_PART:g}, so that contact would be all but rigid: "
            "use fewer modes",
            code=Code.TOO_MANY_MODES,
        )


def massless_reduction(
    omega: Array,
    shapes: Array,
    attachments: Array,
    gap: Array,
    operators: Operators,
    points: AttachedPoints | None = None,
) -> Reduction:
    """Massless-boundary model of a structure, with signed mode shapes.

    Args:
        omega: Circular frequencies in rad/s, shape (J,).
        shapes: Mass-normalised modes, shape (n, J).
        attachments: Static displacements under unit contact forces, K^-1 B^T, shape (n, n_c).
        gap: Gaps in m, shape (n_c,).
        operators: Products with the matrices of the structure.
        points: Points besides those of contact at which forces act; what the modes lack of static
            displacements under them is added to the modes.

    Raises:
        ModelError: if the structure cannot be reduced with so many modes or points.
    """
    points = points or AttachedPoints.none(len(shapes))
    modes = enriched(omega, shapes, points.rows, operators)
    omega, shapes = modes.omega, modes.shapes
    Phi = operators.contact(shapes)
    sign = towards_obstacle(Phi)
    shapes, Phi = shapes * sign, Phi * sign
    residual_shapes = attachments - (Phi @ (shapes / omega**2).T).T
    attached = operators.inner(points.rows, shapes)
    try:
        model = massless_model(omega, Phi, operators.contact(attachments), gap)
    except TooManyModesError as error:
        if len(omega) == modes.free:
            raise
        raise TooManyModesError(
            "massless reduction: a spring that is not linear, or an excitation, acts at contact "
            "points and takes their flexibility: must act beside them, or use fewer modes",
            code=Code.TOO_MANY_MODES,
        ) from error
    # what the added shapes, which are no modes, leave out is not known
    known = len(omega) == modes.free
    truncation = massless_truncation(residual_shapes, operators) if known else None
    return Reduction(
        model=model,
        shapes=shapes,
        residual_shapes=residual_shapes,
        truncation=truncation,
        added=len(omega) - modes.free,
        forces=points.forces(attached),
        attached=attached,
    )
