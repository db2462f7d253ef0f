"""Second-order kinematics of a body on a mesh: whether a study needs them, and how it gets them."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.contact_sites import ContactSites
from fenics_nnm.fem.deflection import BodyDeflection
from fenics_nnm.fem.linear import operators_of
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.obstacle_curvature import obstacle_closing
from fenics_nnm.fem.solid import Solid
from fenics_nnm.mechanics.second_order_effect import (
    KinematicsChoice,
    chosen_kinematics,
    effect_of,
)
from fenics_nnm.reduction.modal_derivatives import (
    Deflection,
    with_second_order,
)
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.stages import Stages
from fenics_nnm.structure.motions import wanted_motions
from fenics_nnm.structure.point_choice import Choices, chosen_of
from fenics_nnm.study import MeshStudy


class Bendable(Protocol):
    """A body with its contact points and its reduced model."""

    @property
    def solid(self) -> Solid:
        """Assembled body."""

    @property
    def interface(self) -> ContactInterface:
        """Contact points."""

    @property
    def sites(self) -> ContactSites:
        """Vertices of the contact patches."""

    @property
    def choices(self) -> Choices:
        """Which of them are contact points."""

    @property
    def reduction(self) -> Reduction:
        """Reduced model, and the way back to the body."""


def reduction_with_kinematics(
    study: MeshStudy, linear: Bendable, solver: ModalSolver, stages: Stages
) -> Reduction:
    """The reduction with the kinematics that a study asks for, or that it needs; on all ranks.

    Args:
        study: Study.
        linear: All that is linear of its body.
        solver: Solver of its stiffness, whose factors serve the modal derivatives too.
        stages: Timings and progress.

    Raises:
        ModelError: if a master is no mode of the model, or the model cannot bend.
    """
    kind, mode = study.body.kinematics, study.mode.number - 1
    reduction = linear.reduction
    if kind is None:
        return reduction
    model = reduction.model
    if not model.massless or model.gap.min() <= 0:
        return _unbent(reduction, kind)
    with stages.stage("second order"):
        masters = np.array(study.body.masters or (study.mode.number,)) - 1
        if masters[-1] >= model.modes:
            raise ModelError(
                f"body.masters: {masters[-1] + 1} must not be above the number of modes, "
                f"{model.modes}"
            )
        if kind == "second-order":
            return _bent(linear, masters, solver)
        followed = np.array([mode])
        bent = _bent(linear, followed, solver)
        choice = chosen_kinematics(kind, effect_of(bent.model, mode, _largest_ratio(study)))
        if choice.second_order and not np.array_equal(masters, followed):
            bent = _bent(linear, masters, solver)
    return replace(bent if choice.second_order else reduction, choice=choice)


def deflection_of(linear: Bendable) -> Deflection:
    """What large deflection adds to the internal force of a body, and its curved obstacles."""
    body, chosen = BodyDeflection(linear.solid), chosen_of(linear.choices)
    obstacle = partial(obstacle_closing, linear.interface, linear.sites, chosen)
    return Deflection(body.second, body.third, obstacle)


def _bent(linear: Bendable, masters: Indices, solver: ModalSolver) -> Reduction:
    operators = operators_of(linear.solid, linear.interface, solver)
    return with_second_order(linear.reduction, masters, operators, deflection_of(linear))


def _unbent(reduction: Reduction, kind: str) -> Reduction:
    """Linear kinematics of a model that has no others.

    Raises:
        ModelError: if others are asked for.
    """
    reason = "second order needs the massless reduction and gaps that are positive"
    if kind == "second-order":
        raise ModelError(f'body.kinematics = "second-order": {reason}')
    choice = KinematicsChoice(False, f"what second order changes is not known: {reason}")
    return replace(reduction, choice=choice)


def _largest_ratio(study: MeshStudy) -> float:
    """Largest energy that a study asks for, over that of grazing; 1 if it asks for frequencies."""
    by_frequency = study.continuation.stepping == "frequency"
    return 1.0 if by_frequency else wanted_motions(study).largest_ratio
