"""All that is linear of a structure given by its matrices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.attached import AttachedPoints
from fenics_nnm.reduction.craig_bampton import craig_bampton_reduction
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.massless import massless_reduction
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.reduction.matrix_modes import MatrixSolver
from fenics_nnm.reduction.operators import Operators
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.stages import Stages


@dataclass(frozen=True, slots=True)
class MatrixAnalysis:
    """Matrices, their modes and the reduced model.

    Attributes:
        matrices: Stiffness, mass, contact rows and gaps.
        modes: Linear modes.
        reduction: Reduced model, and the way back in the order of the unknowns of the matrices.
        coriolis: Circular frequencies of the modes with Coriolis forces in rad/s, shape (J,); empty
            without such forces.
    """

    matrices: Matrices
    modes: LinearModes
    reduction: Reduction
    coriolis: Array = field(default_factory=lambda: np.empty(0))

    @property
    def model(self) -> ReducedModel:
        """Reduced model."""
        return self.reduction.model


Bent = Callable[[Reduction, Operators], Reduction]
"""Adds what bending far adds."""


def unbent(reduction: Reduction, operators: Operators) -> Reduction:
    """Nothing is added."""
    return reduction


def matrix_analysis(
    matrices: Matrices,
    *,
    modes: int,
    method: Literal["massless", "craig-bampton"] = "massless",
    points: AttachedPoints | None = None,
    bent: Bent = unbent,
    stages: Stages | None = None,
) -> MatrixAnalysis:
    """Find modes and attachment solutions, and reduce.

    Args:
        matrices: Structure.
        modes: Number of free modes J, or of modes with the contact points held.
        points: Points besides those of contact at which forces act, of a massless reduction.
        bent: From a reduction and products with the matrices to it with what bending far adds.
        method: "massless", or "craig-bampton" with the contact directions retained.
        stages: Told what is being done.

    Raises:
        ModelError: if the structure is not held, or cannot be reduced as asked.
        ConvergenceError: if the eigensolver fails or misses a mode.
    """
    stages = stages or Stages()
    with stages.stage("modes"):
        solver = MatrixSolver(matrices)
        free = solver.modes(modes).unique(matrices.contact_displacement)
    with stages.stage("attachments"):
        attachments = solver.attachments()
        operators = solver.operators()
        if method == "massless":
            reduction = massless_reduction(
                free.omega, free.shapes, attachments, matrices.gap, operators, points
            )
        else:
            basis = np.hstack([attachments, solver.held_modes(attachments, modes)])
            reduction = craig_bampton_reduction(basis, matrices.gap, operators)
        reduction = bent(reduction, operators)
    return MatrixAnalysis(matrices, free, reduction, solver.coriolis(free))
