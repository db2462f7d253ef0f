"""What linear kinematics put in doubt of driven motions."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.errors import TooManyModesError
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.contact_sites import ContactSites
from fenics_nnm.fem.deflection import BodyForces
from fenics_nnm.fem.linear import LinearAnalysis, massless_reduced
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.stages import Stages
from fenics_nnm.structure.kinematics import asked_of_study, bending_of, chosen_kind
from fenics_nnm.structure.point_choice import Choices
from fenics_nnm.study import MeshStudy


@dataclass(frozen=True, slots=True)
class _Straight(LinearAnalysis):
    """A body with linear kinematics in its modes alone.

    Attributes:
        sites: Vertices of the contact patches.
        choices: Which of them are contact points.
        forces: Derivatives of the internal force of the body.
    """

    sites: ContactSites
    choices: Choices
    forces: BodyForces


def doubt_of_driven(
    study: MeshStudy,
    solid: Solid,
    contact: tuple[ContactSites, Choices, ContactInterface],
    modes: LinearModes,
    solver: ModalSolver,
    stages: Stages,
) -> str:
    """Why no driven motion in contact can be verified, or nothing; to be called on all ranks.

    As for a branch of the mode of the study with linear kinematics, see
    `mechanics.second_order_effect`.

    Args:
        study: Study.
        solid: Assembled body.
        contact: Vertices of its contact patches, which of them are contact points, and these.
        modes: Its modes.
        solver: Solver of its stiffness.
        stages: Timings and progress.
    """
    sites, choices, interface = contact
    if study.mode.number > len(modes.omega):
        return ""
    try:
        reduction = massless_reduced(solid, interface, modes, solver)
    except TooManyModesError:
        return ""  # contact points that move with the modes alone touch nothing
    straight = _Straight(solid, interface, modes, reduction, sites, choices, BodyForces(solid))
    body = study.body.model_copy(update={"kinematics": "linear"})
    linear = study.model_copy(update={"body": body})
    bending = bending_of(linear, straight, solver, stages)
    return chosen_kind(linear, bending, straight, asked_of_study).doubt
