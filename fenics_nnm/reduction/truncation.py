"""What a reduced model leaves out, as far as an error estimate needs it."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import Scales
from fenics_nnm.reduction.operators import Operators


@dataclass(frozen=True, slots=True)
class MasslessTruncation:
    r"""Inertia of the static residual shapes X, which a massless-boundary model neglects.

    In the full-order equations the field U_n = phi q_n - X lambda_n leaves the residual
    -(n omega)^2 M X lambda_n.

    Attributes:
        slope: X^T M X in kg m^2/N^2, shape (n_c, n_c).
        curvature: X^T M K^-1 M X in kg^2 m^3/N^3, shape (n_c, n_c).
    """

    slope: Array
    curvature: Array

    def dimensionless(self, scales: Scales) -> MasslessTruncation:
        """The same in the units of a dimensionless model."""
        unit = scales.force / scales.length * scales.omega**2
        return MasslessTruncation(self.slope * unit, self.curvature * (unit * scales.omega**2))

    def without(self, omega: Array, Phi: Array) -> MasslessTruncation:
        """The same of a model that lacks some more modes.

        Args:
            omega: Circular frequencies of these modes, shape (d,).
            Phi: Their motion at the contact points, shape (n_c, d).
        """
        return MasslessTruncation(
            slope=self.slope + (Phi / omega**4) @ Phi.T,
            curvature=self.curvature + (Phi / omega**6) @ Phi.T,
        )


@dataclass(frozen=True, slots=True)
class GalerkinTruncation:
    r"""What the basis Psi of a Craig-Bampton model cannot follow.

    In the full-order equations the field U_n = Psi q_n leaves the residual -(n omega)^2 K T q_n
    with T = K^-1 M Psi - Psi diag(1 / omega_j^2).

    Attributes:
        curvature: T^T K T in s^4, shape (J, J).
    """

    curvature: Array

    def dimensionless(self, scales: Scales) -> GalerkinTruncation:
        """The same in the units of a dimensionless model."""
        return GalerkinTruncation(self.curvature * scales.omega**2)


Truncation = MasslessTruncation | GalerkinTruncation
"""What a reduced model leaves out."""


def massless_truncation(residual_shapes: Array, operators: Operators) -> MasslessTruncation:
    """What a massless-boundary model leaves out.

    Args:
        residual_shapes: X, shape (n, n_c).
        operators: Products with the matrices of the structure.
    """
    mass = operators.mass(residual_shapes)
    return MasslessTruncation(
        slope=operators.gram(residual_shapes, mass),
        curvature=operators.gram(mass, operators.static(mass)),
    )


def galerkin_truncation(shapes: Array, omega: Array, operators: Operators) -> GalerkinTruncation:
    """What a Craig-Bampton model leaves out.

    Args:
        shapes: Psi, mass-normalised, shape (n, J).
        omega: Circular frequencies in rad/s, shape (J,).
        operators: Products with the matrices of the structure.
    """
    static, mass = shapes / omega**2, operators.mass(shapes)
    missed = operators.static(mass) - static
    return GalerkinTruncation(operators.gram(missed, mass - operators.stiffness(static)))
