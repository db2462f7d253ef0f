"""Second-order kinematics of a body on a mesh, of masters that are given."""

from __future__ import annotations

from dataclasses import replace

from fenics_nnm.arrays import Indices
from fenics_nnm.fem.linear import operators_of
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.reduction.modal_derivatives import ModalDerivatives, modal_derivatives
from fenics_nnm.structure.kinematics import deflection_of
from fenics_nnm.structure.mesh_structure import MeshLinear


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
    operators = operators_of(linear.solid, linear.interface, solver)
    found = modal_derivatives(linear.reduction, masters, operators, deflection_of(linear))
    model = replace(linear.model, kinematics=found.order)
    reduction = replace(linear.reduction, model=model, bent_shapes=found.theta)
    return replace(linear, reduction=reduction), found
