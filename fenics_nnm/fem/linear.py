"""All that is linear of an analysis, in one record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem.block import gram, product
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.modes import LinearModes
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.craig_bampton import craig_bampton
from fenics_nnm.reduction.massless import massless_model
from fenics_nnm.reduction.model import ReducedModel, towards_obstacle
from fenics_nnm.reduction.truncation import (
    GalerkinTruncation,
    MasslessTruncation,
    Truncation,
)


@dataclass(frozen=True, slots=True)
class LinearAnalysis:
    """All that is linear: the body, its modes, its contact points and the reduced model.

    Attributes:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes.
        shapes: Displacement per modal coordinate of the model, kg^-1/2, shape (n_owned, J), signed
            so that the contact point that moves most moves towards its obstacle.
        residual_shapes: Displacement per unit contact force that these do not bring, m/N,
            shape (n_owned, n_c): u = shapes q - residual_shapes lambda.
        model: Reduced model.
        truncation: What the model leaves out.
    """

    solid: Solid
    interface: ContactInterface
    modes: LinearModes
    shapes: Array
    residual_shapes: Array
    model: ReducedModel
    truncation: Truncation


Solve = Callable[[Array], Array]
"""From forces to static displacements, columns at the owned degrees of freedom."""


def massless_reduced(
    solid: Solid, interface: ContactInterface, modes: LinearModes, solve: Solve
) -> LinearAnalysis:
    """Massless-boundary model of a body, with signed mode shapes.

    Args:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes.
        solve: Static solution.

    Raises:
        ModelError: if the body cannot be reduced with so many modes or points.
    """
    Phi = interface.displacement(modes.shapes)
    sign = towards_obstacle(Phi)
    shapes, Phi = modes.shapes * sign, Phi * sign
    attachments = solve(interface.unit_forces(solid.owned))
    S = interface.displacement(attachments)
    residual_shapes = attachments - (shapes / modes.omega**2) @ Phi.T
    mass = product(solid.mass, residual_shapes)
    comm = solid.tagged.mesh.comm
    return LinearAnalysis(
        solid=solid,
        interface=interface,
        modes=modes,
        shapes=shapes,
        residual_shapes=residual_shapes,
        model=massless_model(modes.omega, Phi, S, interface.gap),
        truncation=MasslessTruncation(
            slope=gram(comm, residual_shapes, mass), curvature=gram(comm, mass, solve(mass))
        ),
    )


def craig_bampton_reduced(
    solid: Solid,
    interface: ContactInterface,
    modes: LinearModes,
    attachments: Array,
    fixed_modes: Array,
    solve: Solve,
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
        solve: Static solution.

    Raises:
        ModelError: if the basis vectors depend on each other.
    """
    basis = np.hstack([attachments, fixed_modes])
    reduction = craig_bampton(
        projected(solid.stiffness, basis),
        projected(solid.mass, basis),
        interface.displacement(basis),
        interface.gap,
    )
    shapes = basis @ reduction.shapes
    return LinearAnalysis(
        solid=solid,
        interface=interface,
        modes=modes,
        shapes=shapes,
        residual_shapes=np.zeros((solid.owned, interface.count)),
        model=reduction.model,
        truncation=_galerkin_truncation(solid, shapes, reduction.model.omega, solve),
    )


def _galerkin_truncation(
    solid: Solid, shapes: Array, omega: Array, solve: Solve
) -> GalerkinTruncation:
    static = shapes / omega**2
    mass = product(solid.mass, shapes)
    missed = solve(mass) - static
    forces = mass - product(solid.stiffness, static)
    return GalerkinTruncation(gram(solid.tagged.mesh.comm, missed, forces))


def projected(matrix: PETSc.Mat, basis: Array) -> Array:
    """basis^T matrix basis, the same on all ranks.

    Args:
        matrix: Symmetric matrix.
        basis: Columns at the owned rows, shape (n_owned, b).
    """
    return gram(matrix.comm.tompi4py(), basis, product(matrix, basis))
