"""Craig-Bampton reduction in modal form: the contact points keep their mass, R = 0."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ModelError, TooManyModesError
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.rest import towards_obstacle
from fenics_nnm.reduction.operators import Operators
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.reduction.truncation import galerkin_truncation

#: Basis vectors depend on each other if a direction has less than this part of their mass.
_DEPENDENT = 1e-12


def craig_bampton_reduction(basis: Array, gap: Array, operators: Operators) -> Reduction:
    """Bring the pencil of a Craig-Bampton basis to modal form.

    The basis is constraint modes and fixed-interface modes together; the eigenvectors of the
    reduced pencil are mass-normalised coordinates, so the same harmonic equations hold as for free
    modes, with R = 0 (Laxalde and Legrand 2011, section 3.4).

    Args:
        basis: Displacements that span the model, shape (n, b).
        gap: Gaps in m, shape (n_c,).
        operators: Products with the matrices of the structure.

    Raises:
        ModelError: if the basis vectors depend on each other, or one of them moves no mass.
    """
    K = operators.gram(basis, operators.stiffness(basis))
    M = operators.gram(basis, operators.mass(basis))
    if np.diag(M).min() <= 0:
        raise ModelError("Craig-Bampton: a contact point moves no mass: use the massless method")
    scale = 1 / np.sqrt(np.diag(M))
    mass = scale[:, None] * M * scale
    if np.linalg.eigvalsh(mass)[0] < _DEPENDENT:
        raise TooManyModesError(
            "Craig-Bampton: the basis vectors depend on each other: use fewer modes",
            code=Code.TOO_MANY_MODES,
        )
    squared, vectors = eigh(scale[:, None] * K * scale, mass)
    combination = scale[:, None] * vectors
    Phi = operators.contact(basis) @ combination
    sign = towards_obstacle(Phi)
    points = len(gap)
    omega, shapes = np.sqrt(squared), basis @ (combination * sign)
    return Reduction(
        model=ReducedModel(
            omega=omega,
            Phi=Phi * sign,
            R=np.zeros((points, points)),
            gap=gap,
            contact=MASSIVE,
        ),
        shapes=shapes,
        residual_shapes=np.zeros((len(basis), points)),
        truncation=galerkin_truncation(shapes, omega, operators),
    )
