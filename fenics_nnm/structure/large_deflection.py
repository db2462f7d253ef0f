"""Second-order kinematics of a body on a mesh."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from fenics_nnm.arrays import Indices
from fenics_nnm.fem.deflection import BodyDeflection
from fenics_nnm.fem.linear import operators_of
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.obstacle_curvature import obstacle_closing
from fenics_nnm.reduction.modal_derivatives import (
    Deflection,
    ModalDerivatives,
    modal_derivatives,
)
from fenics_nnm.structure.mesh_structure import MeshLinear
from fenics_nnm.structure.point_choice import chosen_of


def with_modal_derivatives(
    linear: MeshLinear, masters: Indices, solver: ModalSolver | None = None
) -> tuple[MeshLinear, ModalDerivatives]:
    """The analysis with second-order kinematics of some masters; called on all ranks.

    Args:
        linear: All that is linear of a body, about its static state if it has one.
        masters: Places of the masters among the modes of its reduced model, ascending.
        solver: Solver of its stiffness; one is made if there is none.

    Raises:
        ModelError: if the reduced model cannot have second-order kinematics.
    """
    if solver is None:
        with DirectModalSolver(linear.solid) as own:
            return with_modal_derivatives(linear, masters, own)
    body, chosen = BodyDeflection(linear.solid), chosen_of(linear.choices)
    found = modal_derivatives(
        linear.reduction,
        masters,
        operators_of(linear.solid, linear.interface, solver),
        Deflection(
            body.second,
            body.third,
            partial(obstacle_closing, linear.interface, linear.sites, chosen),
        ),
    )
    model = replace(linear.model, kinematics=found.order)
    reduction = replace(linear.reduction, model=model)
    return replace(linear, reduction=reduction), found
