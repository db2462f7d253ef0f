"""What a reduced model leaves out, as far as an error estimate needs it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import Scales
from fenics_nnm.reduction.flexibility import ResidualFlexibility
from fenics_nnm.reduction.operators import Operators


@dataclass(frozen=True, slots=True)
class ReducedMotion:
    """A motion of a reduced model in harmonics, as far as its truncation asks for it.

    Attributes:
        omega: Circular frequency.
        order: Harmonic number n of each row, shape (r,).
        mean_square: Mean square over the period of each function of the series, shape (r,).
        q: Modal coordinates, shape (r, J).
        ell: Harmonics of the contact forces, shape (r, n_c).
        gamma_weight: Weight of each row in gamma, shape (r, 1).
        pushed: From a small displacement of the contact points (r, n_c) to what the change of the
            contact forces adds to the equations (r, J).
    """

    omega: float
    order: Array
    mean_square: Array
    q: Array
    ell: Array
    gamma_weight: Array
    pushed: Callable[[Array], Array]

    def weighted(self, rows: Array, matrix: Array) -> float:
        """Mean over the period of (n omega)^4 x_n^T matrix x_n."""
        fourth = (self.order * self.omega) ** 4
        return float(np.sum(self.mean_square * fourth * np.sum(rows * (rows @ matrix), axis=1)))


@dataclass(frozen=True, slots=True)
class LeftOut:
    """What the full order adds to a motion of a reduced model.

    Attributes:
        square: Square of the norm of the residual in K^-1.
        equations: Terms of the reduced equations, shape (r, J).
        gamma: Term of gamma.
    """

    square: float
    equations: Array
    gamma: float


class Truncation(Protocol):
    """What a reduced model leaves out."""

    def dimensionless(self, scales: Scales) -> Truncation:
        """The same in the units of a dimensionless model."""

    def without(self, omega: Array, Phi: Array) -> Truncation:
        """The same of a model that lacks some more modes.

        Args:
            omega: Circular frequencies of these modes, shape (d,).
            Phi: Their motion at the contact points, shape (n_c, d).

        Raises:
            TypeError: if fewer modes span another basis.
        """

    def residual_flexibility(self, harmonics: int) -> ResidualFlexibility:
        """Inertial part of the residual flexibility of N harmonics about the static one.

        Raises:
            TypeError: if the modes of the model are not those of the structure.
        """

    def left_out(self, motion: ReducedMotion) -> LeftOut:
        """What the full order adds to a motion."""


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
        """As `Truncation.without`."""
        return MasslessTruncation(
            slope=self.slope + (Phi / omega**4) @ Phi.T,
            curvature=self.curvature + (Phi / omega**6) @ Phi.T,
        )

    def residual_flexibility(self, harmonics: int) -> ResidualFlexibility:
        """As `Truncation.residual_flexibility`."""
        return ResidualFlexibility.static(self.slope, self.curvature, harmonics)

    def left_out(self, motion: ReducedMotion) -> LeftOut:
        """The flexibility D moves the contact points by -D lambda_n, and its mass adds to gamma."""
        ell, squared = motion.ell, (motion.order * motion.omega)[:, None] ** 2
        slope, curvature = ell @ self.slope, ell @ self.curvature
        inertia = motion.gamma_weight * ell * (slope + 2 * squared * curvature)
        return LeftOut(
            square=motion.weighted(ell, self.curvature),
            equations=motion.pushed(-squared * (slope + squared * curvature)),
            gamma=float(np.sum(inertia) / 2),
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

    def without(self, omega: Array, Phi: Array) -> GalerkinTruncation:
        """Refused: the basis of fewer modes is another one."""
        raise TypeError("the modes of a Craig-Bampton basis are not nested")

    def residual_flexibility(self, harmonics: int) -> ResidualFlexibility:
        """Refused: the modes of the basis are not those of the structure."""
        raise TypeError("a Craig-Bampton basis has no residual flexibility")

    def left_out(self, motion: ReducedMotion) -> LeftOut:
        """The displacements that the basis lacks soften each harmonic by (n omega)^4 T^T K T."""
        fourth = (motion.order * motion.omega)[:, None] ** 4
        softer = -fourth * (motion.q @ self.curvature)
        work = motion.mean_square[:, None] * motion.q * softer
        return LeftOut(
            square=motion.weighted(motion.q, self.curvature),
            equations=softer,
            gamma=-float(np.sum(work) / motion.omega**2),
        )


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
