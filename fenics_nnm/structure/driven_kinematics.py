"""Which kinematics a driven body has: those that its study asks for, or that it needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from fenics_nnm.errors import StudyError, TooManyModesError
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.contact_sites import ContactSites
from fenics_nnm.fem.deflection import BodyForces
from fenics_nnm.fem.linear import LinearAnalysis, massless_reduced
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.solid import Solid
from fenics_nnm.mechanics.second_order_effect import UNASKED, KinematicsChoice
from fenics_nnm.reduction.driven import NEEDS_FLEXIBILITY, BentModes, DrivenBasis, DrivenPlaces
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.operators import Operators
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.stages import Stages
from fenics_nnm.structure.bending import Bendable
from fenics_nnm.structure.driven_reach import ByContact, ModalForces, Motions
from fenics_nnm.structure.kinematics import bending_of, chosen_kind, in_choice
from fenics_nnm.structure.point_choice import Choices
from fenics_nnm.study import MeshStudy

#: Kinematics that a study asks for whatever they change.
_ASKED = "second-order"


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


def bent_modes(
    study: MeshStudy,
    solid: Solid,
    contact: tuple[ContactSites, Choices, ContactInterface],
    modes: LinearModes,
    motions: Motions,
    solver: ModalSolver,
    stages: Stages,
) -> BentModes:
    """The modes of a driven body with the kinematics that it needs; to be called on all ranks.

    What "auto" takes, and what linear kinematics put in doubt, is decided as for a branch of the
    mode that moves most, up to the energy that the levels reach in it, see
    `mechanics.second_order_effect`.

    Args:
        study: Study.
        solid: Assembled body.
        contact: Vertices of its contact patches, which of them are contact points, and these.
        modes: Its modes.
        motions: How far its response moves it.
        solver: Solver of its stiffness.
        stages: Timings and progress.

    Raises:
        StudyError: if second order is asked for, and the followed mode is none of the modes.
        ModelError: if it is asked for, and the structure cannot have it.
    """
    sites, choices, interface = contact
    if study.mode.number > len(modes.omega):
        return _without(study, modes, f"mode {study.mode.number} is none of its modes")
    try:
        reduction = massless_reduced(solid, interface, modes, solver)
    except TooManyModesError:
        return _without(study, modes, NEEDS_FLEXIBILITY)
    straight = _Straight(solid, interface, modes, reduction, sites, choices, BodyForces(solid))
    sprung = reduction.model.modes > len(modes.omega)
    found = _chosen(_linear(study) if sprung else study, straight, motions, solver, stages)
    if sprung:
        return _without(study, modes, "it has springs that are not linear", found.choice)
    if not found.choice.second_order:
        return BentModes.straight(modes, found.choice)
    return BentModes.of(modes, found)


def modal_motions(
    study: MeshStudy, modes: LinearModes, places: DrivenPlaces, operators: Operators
) -> Motions:
    """How far its response moves a body; to be called on all ranks."""
    if not len(places.sizes):
        return ByContact()
    excited = operators.inner(places.excited, modes.shapes)
    rate = operators.inner(modes.shapes, places.damping(modes.shapes))
    return ModalForces.of(study, modes.omega, excited, places.sizes, rate)


def with_kinematics(
    study: MeshStudy, own: BentModes, reduced: Callable[[BentModes], DrivenBasis]
) -> DrivenBasis:
    """The driven basis of modes, with linear kinematics where forces act at contact points.

    Args:
        study: Study.
        own: Modes with their kinematics.
        reduced: Makes the basis.

    Raises:
        StudyError: if second order is asked for, and contact points have no flexibility.
    """
    try:
        return reduced(own)
    except TooManyModesError:
        return reduced(_without(study, own.modes, NEEDS_FLEXIBILITY))


def _chosen(
    study: MeshStudy, straight: _Straight, motions: Motions, solver: ModalSolver, stages: Stages
) -> Reduction:
    """The reduction with the kinematics that a study asks for, or that it needs."""
    reach = motions.reach(study, straight)
    study = _about_mode(study, reach.mode)

    def reached(study: MeshStudy, linear: Bendable) -> float:
        return reach.ratio

    bending = bending_of(study, straight, solver, stages)
    choice = chosen_kind(study, bending, straight, reached)
    if study.body.kinematics != _ASKED and len(bending.masters):
        choice = replace(choice, reason=f"{reach.reason}: {choice.reason}")
    return in_choice(study, bending, choice, straight, reached, solver, stages)


def _about_mode(study: MeshStudy, mode: int) -> MeshStudy:
    """The same study about a mode, by its index."""
    followed = study.mode.model_copy(update={"number": mode + 1})
    return study.model_copy(update={"mode": followed})


def _linear(study: MeshStudy) -> MeshStudy:
    """The same study with linear kinematics."""
    body = study.body.model_copy(update={"kinematics": "linear"})
    return study.model_copy(update={"body": body})


def _without(
    study: MeshStudy, modes: LinearModes, reason: str, choice: KinematicsChoice = UNASKED
) -> BentModes:
    """Linear kinematics, as a body cannot have others.

    Raises:
        StudyError: if others are asked for.
    """
    if study.body.kinematics == _ASKED:
        raise StudyError(f'body.kinematics = "{_ASKED}": a driven body cannot have it: {reason}')
    return BentModes.straight(modes, choice)
