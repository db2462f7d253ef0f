"""All that is linear of an analysis, in one record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.craig_bampton import craig_bampton_reduction
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.massless import massless_reduction
from fenics_nnm.reduction.model import ReducedModel, Reduction


@dataclass(frozen=True, slots=True)
class LinearAnalysis:
    """All that is linear: the body, its modes, its contact points and the reduced model.

    Attributes:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes.
        reduction: Reduced model, and the way back at the owned degrees of freedom.
    """

    solid: Solid
    interface: ContactInterface
    modes: LinearModes
    reduction: Reduction

    @property
    def model(self) -> ReducedModel:
        """Reduced model."""
        return self.reduction.model


def massless_reduced(
    solid: Solid, interface: ContactInterface, modes: LinearModes, attachments: Array
) -> LinearAnalysis:
    """Massless-boundary model of a body, with signed mode shapes.

    Args:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes.
        attachments: Static displacements under unit contact forces, shape (n_owned, n_c).

    Raises:
        ModelError: if the body cannot be reduced with so many modes or points.
    """
    reduction = massless_reduction(
        modes.omega, modes.shapes, attachments, interface.gap, interface.displacement
    )
    return LinearAnalysis(solid, interface, modes, reduction)


def craig_bampton_reduced(
    solid: Solid,
    interface: ContactInterface,
    modes: LinearModes,
    attachments: Array,
    fixed_modes: Array,
) -> LinearAnalysis:
    """Craig-Bampton model of a body, in modal form.

    The attachment solutions span the same space as the constraint modes, which are these
    solutions combined to unit displacements of one interface coordinate at a time.

    Args:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes, for comparison; the model does not use them.
        attachments: Static displacements under unit forces of the interface, (n_owned, i).
        fixed_modes: Modes with the interface held, shape (n_owned, k).

    Raises:
        ModelError: if the basis vectors depend on each other.
    """
    basis = np.hstack([attachments, fixed_modes])
    reduction = craig_bampton_reduction(
        basis,
        projected(solid.stiffness, basis),
        projected(solid.mass, basis),
        interface.displacement(basis),
        interface.gap,
    )
    return LinearAnalysis(solid, interface, modes, reduction)


def projected(matrix: PETSc.Mat, basis: Array) -> Array:
    """basis^T matrix basis, the same on all ranks.

    Args:
        matrix: Symmetric matrix.
        basis: Columns at the owned rows, shape (n_owned, b).
    """
    right, left = matrix.createVecs()
    product = np.empty_like(basis)
    for column in range(basis.shape[1]):
        right.array[:] = basis[:, column]
        matrix.mult(right, left)
        product[:, column] = left.array_r
    right.destroy()
    left.destroy()
    whole = matrix.comm.tompi4py().allreduce(basis.T @ product)
    return np.asarray((whole + whole.T) / 2)
