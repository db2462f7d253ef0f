"""What a driven structure is reduced to, as long as it touches nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.force import Force
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.attached import AttachedPoints, enriched
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.operators import Operators


@dataclass(frozen=True, slots=True)
class DrivenBasis:
    """Free modes, and the shapes that static displacements under forces at points add to them.

    Contact points move with these alone and so carry mass: no residual flexibility is left out
    where nothing presses them, and forces may act at contact points, too.

    Attributes:
        model: Reduced model with R = 0.
        modes: Number of free modes J; the shapes that were added come after them.
        excited: Displacement of the excited points, each along its force, per modal coordinate,
            kg^-1/2, shape (p, J').
        forces: Forces of springs that are not linear.
    """

    model: ReducedModel
    modes: int
    excited: Array
    forces: tuple[Force, ...]


def driven_basis(
    modes: LinearModes, springs: AttachedPoints, excited: Array, gap: Array, operators: Operators
) -> DrivenBasis:
    """Reduce a driven structure.

    Args:
        modes: Free modes.
        springs: Points with springs that are not linear.
        excited: Unit forces at the excited points, shape (n, p).
        gap: Gaps of the contact points in m, shape (n_c,).
        operators: Products with the matrices of the structure.

    Raises:
        ModelError: if an excited point moves no mass.
    """
    points = springs.and_also(excited)
    basis = enriched(modes.omega, modes.shapes, points.rows, operators)
    attached = operators.inner(points.rows, basis.shapes)
    springs_alone = len(attached) - excited.shape[1]
    count = len(gap)
    return DrivenBasis(
        model=ReducedModel(
            omega=basis.omega,
            Phi=operators.contact(basis.shapes),
            R=np.zeros((count, count)),
            gap=gap,
            contact=MASSIVE,
        ),
        modes=basis.free,
        excited=attached[springs_alone:],
        forces=points.forces(attached),
    )
