"""A posteriori error of a reduction: how far a motion is from solving the full-order equations.

The motion of a reduced model, put into the harmonic equations of the full model, leaves a residual.
Its size, and the change of frequency that one linearised step from there gives, need only
products with what the reduction left out, which were made once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.linear_step import linear_step
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.reduction.truncation import LeftOut, ReducedMotion, Truncation


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


def reduction_error(
    truncation: Truncation, equations: HarmonicEquations, solution: Solution
) -> ReductionError:
    """Error of a solution of reduced equations; all arguments dimensionless alike.

    Args:
        truncation: What the reduced model leaves out.
        equations: Equations of the reduced model.
        solution: A converged solution.
    """
    left_out = truncation.left_out(_reduced_motion(equations, solution))
    return ReductionError(
        residual=float(np.sqrt(max(left_out.square, 0.0) / solution.energies.stiffness)),
        frequency=-_frequency_step(equations, solution, left_out) / solution.omega,
    )


def _reduced_motion(equations: HarmonicEquations, solution: Solution) -> ReducedMotion:
    series, forces = equations.series, solution.forces

    def pushed(displacement: Array) -> Array:
        change = forces.change(series.synthesis @ displacement)
        return np.asarray(series.analysis @ change @ equations.model.Phi)

    return ReducedMotion(
        omega=solution.omega,
        order=series.order,
        mean_square=series.mean_square,
        q=solution.q,
        ell=series.analysis @ forces.force,
        gamma_weight=equations.energy.weight,
        pushed=pushed,
    )


def _frequency_step(equations: HarmonicEquations, solution: Solution, left_out: LeftOut) -> float:
    """Change of omega in one linearised step to the full-order equations at the same gamma."""
    step = linear_step(
        equations, solution.at, solution.forces, left_out.equations, gamma_left_out=left_out.gamma
    )
    return float("nan") if step is None else step.omega
