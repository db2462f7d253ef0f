"""A posteriori error of a reduction: how far a motion is from solving the full-order equations.

The motion of a reduced model, put into the harmonic equations of the full model, leaves a residual.
Its size, and the change of frequency that one linearised step from there gives, need only
products with what the reduction left out, which were made once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.linear_step import linear_step
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.reduction.flexibility import ResidualFlexibility
from fenics_nnm.reduction.truncation import GalerkinTruncation, MasslessTruncation, Truncation


@dataclass(frozen=True, slots=True)
class ReductionError:
    """Error of a motion that comes from the reduction alone.

    Attributes:
        residual: Norm of the residual in K^-1, over the square root of k^.
        frequency: Expected relative error of the frequency, at the same gamma; nan where the
            linearised step to full order is not defined.
    """

    residual: float
    frequency: float


#: Error at full order, and of a model that is all there is to know of a structure.
NO_ERROR = ReductionError(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class _LeftOut:
    """Square of the residual, and what the full order adds to the equations and to gamma."""

    square: float
    equations: Array
    gamma: float


def reduction_error(
    truncation: Truncation, equations: HarmonicEquations, solution: Solution
) -> ReductionError:
    """Error of a solution of reduced equations; all arguments dimensionless alike.

    Args:
        truncation: What the reduced model leaves out.
        equations: Equations of the reduced model.
        solution: A converged solution.
    """
    if isinstance(truncation, MasslessTruncation):
        left_out = _massless(truncation, equations, solution)
    else:
        left_out = _galerkin(truncation, equations, solution)
    return ReductionError(
        residual=float(np.sqrt(max(left_out.square, 0.0) / solution.energies.stiffness)),
        frequency=-_frequency_step(equations, solution, left_out) / solution.omega,
    )


def _massless(
    truncation: MasslessTruncation, equations: HarmonicEquations, solution: Solution
) -> _LeftOut:
    """The flexibility D moves the contact points by -D lambda_n, and its mass adds to gamma."""
    series, forces = equations.series, solution.forces
    flexibility = ResidualFlexibility.static(
        truncation.slope, truncation.curvature, series.harmonics
    )
    D, slope, _ = (part[series.order.astype(int)] for part in flexibility.at(solution.omega))
    ell = series.analysis @ forces.force
    change = forces.change(series.synthesis @ -np.einsum("ncd,nd->nc", D, ell))
    return _LeftOut(
        square=_weighted(series, solution.omega, ell, truncation.curvature),
        equations=series.analysis @ change @ equations.model.Phi,
        gamma=float(
            np.sum(equations.energy.weight * ell * np.einsum("ncd,nd->nc", slope, ell)) / 2
        ),
    )


def _galerkin(
    truncation: GalerkinTruncation, equations: HarmonicEquations, solution: Solution
) -> _LeftOut:
    """The displacements that the basis lacks soften each harmonic by (n omega)^4 T^T K T."""
    series, q = equations.series, solution.q
    fourth = (series.order * solution.omega)[:, None] ** 4
    softer = -fourth * (q @ truncation.curvature)
    return _LeftOut(
        square=_weighted(series, solution.omega, q, truncation.curvature),
        equations=softer,
        gamma=-float(np.sum(series.mean_square[:, None] * q * softer) / solution.omega**2),
    )


def _weighted(series: Series, omega: float, rows: Array, matrix: Array) -> float:
    """Mean over the period of (n omega)^4 x_n^T matrix x_n."""
    fourth = (series.order * omega) ** 4
    return float(np.sum(series.mean_square * fourth * np.sum(rows * (rows @ matrix), axis=1)))


def _frequency_step(equations: HarmonicEquations, solution: Solution, left_out: _LeftOut) -> float:
    """Change of omega in one linearised step to the full-order equations at the same gamma."""
    step = linear_step(
        equations, solution.at, solution.forces, left_out.equations, gamma_left_out=left_out.gamma
    )
    return float("nan") if step is None else step.omega
