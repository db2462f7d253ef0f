"""Which kinematics the model of a body has: those that its study asks for, or that it needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.mechanics.second_order_effect import (
    KinematicsChoice,
    chosen_kinematics,
    effect_of,
)
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.stages import Stages
from fenics_nnm.structure.bending import Bendable, Bending, bent, of_mode_alone
from fenics_nnm.structure.masters import chosen_masters
from fenics_nnm.structure.motions import wanted_motions
from fenics_nnm.structure.motions_at_speed import Quantity, ReachedByTargets, Target
from fenics_nnm.study import MeshStudy

Reached = Callable[[MeshStudy, Bendable], float]
"""Largest energy of a branch over that of grazing with linear kinematics."""


def asked_of_study(study: MeshStudy, linear: Bendable) -> float:
    """Largest gamma ratio that a study asks for; 1 if it asks for frequencies.

    Energies in J and amplitudes count with linear motions of their size.
    """
    by_frequency = study.continuation.stepping == "frequency"
    largest = 1.0 if by_frequency else wanted_motions(study).largest_ratio
    sizes = {each.value for each in Quantity}
    targets = [
        Target(Quantity(each.quantity), each.value)
        for each in study.continuation.sought
        if each.quantity in sizes
    ]
    return max(largest, ReachedByTargets(targets)(study, linear)) if targets else largest


def bending_of(study: MeshStudy, body: Bendable, solver: ModalSolver, stages: Stages) -> Bending:
    """The models of a body that its study can have; to be called on all ranks.

    Args:
        study: Study.
        body: Body with its linear reduced model.
        solver: Solver of its stiffness, whose factors serve the modal derivatives too.
        stages: Timings and progress.

    Raises:
        ModelError: if second order is asked for, and gaps are not positive, or constraints or
            Coriolis forces do not go with it.
    """
    straight, mode = body.reduction, study.mode.number - 1
    if study.body.kinematics == "second-order":
        _assert_bends(study, straight, body)
    elif _why_unknown(study, straight):
        return Bending(straight, straight, mode)
    with stages.stage("second order"):
        if straight.model.massless:
            return Bending(straight, bent(body, straight, _first(study, straight), solver), mode)
        alone = of_mode_alone(straight, mode)
        return Bending(straight, bent(body, alone, np.array([0]), solver), mode)


def can_choose(study: MeshStudy, bending: Bending) -> bool:
    """Whether it is known from the models of another study what this one needs."""
    if study.body.kinematics == "second-order":
        return False
    same = len(bending.masters) > 0 and bending.mode == study.mode.number - 1
    return same or bool(_why_unknown(study, bending.straight))


def chosen_kind(
    study: MeshStudy, bending: Bending, linear: Bendable, reached: Reached
) -> KinematicsChoice:
    """The kinematics that a study asks for, or that it needs; to be called on all ranks.

    Args:
        study: Study.
        bending: Models to choose from.
        linear: Its body with linear kinematics.
        reached: Largest energy of the branch.
    """
    kind = study.body.kinematics
    if kind == "second-order":
        return bending.bent.choice
    unknown = _why_unknown(study, bending.straight)
    if unknown:
        return KinematicsChoice(False, unknown)
    hindrance = _hindrance(study, linear)
    if not bending.straight.model.at_rest().touches(bending.mode):
        return _of_touch_in_second_order(study, bending, hindrance)
    effect = effect_of(bending.bent.model, bending.own, reached(study, linear))
    return chosen_kinematics(kind, effect, hindrance)


def in_choice(
    study: MeshStudy,
    bending: Bending,
    choice: KinematicsChoice,
    linear: Bendable,
    reached: Reached,
    solver: ModalSolver,
    stages: Stages,
) -> Reduction:
    """The model of a choice, with all masters; to be called on all ranks.

    Args:
        study: Study, which may name the masters.
        bending: Models of its body.
        choice: Which kinematics.
        linear: The body with linear kinematics.
        reached: Largest energy of the branch.
        solver: Solver of its stiffness.
        stages: Timings and progress.

    Raises:
        ModelError: if a master is no mode of the model.
    """
    if not choice.second_order:
        return replace(bending.straight, choice=choice)
    with stages.stage("second order"):
        return _with_masters(study, bending, choice, linear, reached(study, linear), solver)


def _with_masters(
    study: MeshStudy,
    bending: Bending,
    choice: KinematicsChoice,
    linear: Bendable,
    largest_ratio: float,
    solver: ModalSolver,
) -> Reduction:
    if study.body.masters is None:
        found = chosen_masters(linear, bending, largest_ratio, solver)
        reason = f"{choice.reason}; {found.reason}"
        return replace(found.reduction, choice=replace(choice, reason=reason))
    masters, given = _masters(study.body.masters, bending.straight), bending.bent
    if not np.array_equal(masters, bending.masters):
        given = bent(linear, bending.straight, masters, solver)
    return replace(given, choice=choice)


def _first(study: MeshStudy, straight: Reduction) -> Indices:
    """Places of the masters that are needed first: all where the study asks for them anyway.

    Raises:
        ModelError: if one is no mode of the model.
    """
    named = study.body.masters
    if named is None or study.body.kinematics != "second-order":
        return np.array([study.mode.number - 1])
    return _masters(named, straight)


def _masters(masters: Sequence[int], straight: Reduction) -> Indices:
    """Places of the masters of a study.

    Raises:
        ModelError: if one is no mode of the model.
    """
    modes = straight.free
    if masters[-1] > modes:
        raise ModelError(
            f"body.masters: {masters[-1]} must not be above the number of modes, {modes}"
        )
    return np.array(masters) - 1


def _assert_bends(study: MeshStudy, straight: Reduction, body: Bendable) -> None:
    """Refuse second order with gaps that are not positive, constraints, and Coriolis forces.

    Nodes that follow a point by a linear rotation move apart in second order: a rigid end of a
    slender beam makes it a hundred times as stiff in fourth order as it is.

    Raises:
        ModelError: if there are some.
    """
    if straight.model.gap.min() <= 0:
        raise ModelError(
            'body.kinematics = "second-order": second order needs gaps that are positive'
        )
    if found := _constrained(body) or _turned(study):
        raise ModelError(f'body.kinematics = "second-order": {found}: must be "auto" or "linear"')


def _constrained(body: Bendable) -> str:
    """Which constraints do not go with second order, or nothing."""
    keys = body.solid.system.keys
    return f"constraints ({keys[0]}) are those of small rotations" if keys else ""


def _turned(study: MeshStudy) -> str:
    """Why Coriolis forces do not go with second order, if there are some."""
    key = study.coriolis
    return f"Coriolis forces ({key}) are those of linear kinematics" if key else ""


def _why_unknown(study: MeshStudy, straight: Reduction) -> str:
    """Why it is not known what second order changes, or nothing."""
    if study.body.theory == "rod":
        return "a rod does not bend"
    if straight.model.gap.min() <= 0:
        return "what second order changes is not known where gaps are not positive"
    return ""


def _hindrance(study: MeshStudy, linear: Bendable) -> str:
    """What second order would need that a study does not have, or nothing."""
    harmonics, samples = study.mode.harmonics, study.mode.samples
    if study.full_order:
        return "full order is linear but for contact"
    if study.carries_mass:
        return 'second order needs reduction.method = "massless"'
    if found := _constrained(linear) or _turned(study):
        return found
    if "auto" not in (harmonics, samples) and int(samples) <= 4 * int(harmonics):
        return f"second order needs mode.samples above 4 mode.harmonics = {4 * int(harmonics)}"
    return ""


def _of_touch_in_second_order(
    study: MeshStudy, bending: Bending, hindrance: str
) -> KinematicsChoice:
    """The kinematics of a mode that moves no contact point in first order."""
    reason = f"mode {study.mode.number} moves no contact point towards its obstacle in first order"
    touches = bending.bent.model.at_rest().touches(bending.own)
    takes = study.body.kinematics == "auto" and touches and not hindrance
    return KinematicsChoice(takes, f"{reason}; {hindrance}" if hindrance else reason)
