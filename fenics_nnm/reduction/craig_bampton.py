"""Craig-Bampton reduction in modal form: the contact points keep their mass, R = 0."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.reduction.model import ReducedModel, towards_obstacle

#: A direction of the basis whose mass is below this part of the largest one is left out.
_DEPENDENT = 1e-12


@dataclass(frozen=True, slots=True)
class CraigBampton:
    """A reduced model and the way back to the full field.

    Attributes:
        model: Reduced model, R = 0.
        shapes: Coordinates of the basis per modal coordinate, shape (basis, J): a full shape is
            basis @ shapes.
    """

    model: ReducedModel
    shapes: Array


def craig_bampton(K: Array, M: Array, B: Array, gap: Array) -> CraigBampton:
    """Bring the pencil of a Craig-Bampton basis to modal form.

    The basis is constraint modes and fixed-interface modes together; the eigenvectors of the
    reduced pencil are mass-normalised coordinates, so the same harmonic equations hold as for free
    modes, with R = 0 (Laxalde and Legrand 2011, section 3.4).

    Args:
        K: Stiffness on the basis, shape (b, b).
        M: Mass on the basis, shape (b, b).
        B: Displacement of the contact points in the contact direction per basis vector, (n_c, b).
        gap: Gaps in m, shape (n_c,).

    Raises:
        ModelError: if the basis vectors depend on each other.
    """
    scale = 1 / np.sqrt(np.diag(M))
    mass = scale[:, None] * M * scale
    if np.linalg.eigvalsh(mass)[0] < _DEPENDENT:
        raise ModelError(
            "Craig-Bampton: the basis vectors depend on each other: use fewer reduction.modes"
        )
    squared, vectors = eigh(scale[:, None] * K * scale, mass)
    shapes = scale[:, None] * vectors
    Phi = B @ shapes
    sign = towards_obstacle(Phi)
    model = ReducedModel(
        omega=np.sqrt(squared), Phi=Phi * sign, R=np.zeros((len(gap), len(gap))), gap=gap
    )
    return CraigBampton(model, shapes * sign)
