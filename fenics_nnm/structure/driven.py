"""From a study to a driven structure, and the frequencies that it asks for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from mpi4py import MPI

from fenics_nnm.errors import StudyError
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.moving_gap import GapMotion
from fenics_nnm.reduction.driven import DrivenBasis
from fenics_nnm.response.instead import Instead, instead
from fenics_nnm.response.isolas import with_isolas
from fenics_nnm.response.levels import Response, response
from fenics_nnm.response.phase_resonance import DampedBackbone, damped_backbone
from fenics_nnm.response.structure import (
    NO_FLEXIBILITY,
    Drive,
    DrivenStructure,
    numbered,
)
from fenics_nnm.response.watched import Place, Watched
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import structure_of
from fenics_nnm.structure.damped_part import damped_part
from fenics_nnm.structure.driven_frequencies import (
    drive_harmonics,
    driving_orders,
    response_frequencies,
    speed_per_hertz,
    wanted_frequencies,
)
from fenics_nnm.structure.driven_linear import DrivenLinear
from fenics_nnm.study import Study
from fenics_nnm.study.driven import base_order

#: Sections that a response needs, besides damping of some kind and those of every study.
_NEEDED = ("excitation", "response")


def driven_structure(
    study: Study, comm: MPI.Comm, stages: Stages | None = None, command: str = "response"
) -> DrivenStructure:
    """The driven structure of a study, as `driven_linear` and `structure_from` find it."""
    return structure_from(study, driven_linear(study, comm, stages, command).basis)


def driven_linear(
    study: Study, comm: MPI.Comm, stages: Stages | None = None, command: str = "response"
) -> DrivenLinear:
    """All that is linear of the driven structure of a study; to be called on all ranks.

    Args:
        study: Study.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        command: Command that asks for it.

    Raises:
        StudyError: if a section is missing, or the study cannot be driven as it is.
        MeshError, ModelError, ConvergenceError: as `Structure.driven`.
    """
    assert_drivable(study, command)
    if study.automatic:
        raise StudyError(f'{study.automatic[0]} = "auto": fenics-nnm {command} needs a number')
    _harmonics(study)
    return structure_of(study).driven(comm, stages or Stages())


def structure_from(study: Study, basis: DrivenBasis) -> DrivenStructure:
    """The driven structure of a study from what it is reduced to.

    Raises:
        StudyError: if contact points with mass touch, or two places have one name.
    """
    model, harmonics, excited = basis.model, _harmonics(study), len(basis.excited)
    turns = np.array([each.turn for each in study.excitation])
    structure = DrivenStructure(
        model=model,
        linear=damped_part(study, model.omega, basis.rate, basis.modes),
        drive=Drive(basis.excited, basis.sizes * turns, harmonics, basis.bent[:excited]),
        watched=_watched(study, basis),
        forces=(*model.kinematics.forces, *basis.forces),
        objection="" if model.massless else NO_FLEXIBILITY,
        gap_motion=_gap_motion(study, basis),
    )
    _assert_moved(study, structure)
    return structure


def _assert_moved(study: Study, structure: DrivenStructure) -> None:
    """Refuse a structure that is pressed and cannot yield, or that nothing moves.

    Raises:
        StudyError: if it is one.
    """
    assert study.response is not None  # refused by `driven_linear`
    gap = structure.smallest_gap
    if gap <= 0 and structure.objection:
        raise StudyError(f"contact.gap = {gap:g}: must be positive: {structure.objection}")
    level = max(study.response.levels)
    left = structure.at_level(level).smallest_gap
    if left > 0 and structure.drive.cancels:
        raise StudyError(
            "excitation: the forces cancel each other: nothing moves the structure: must differ in "
            "place, direction, force, phase_deg or harmonic"
        )
    if not study.excitation and left > 0:
        raise StudyError(
            f"contact: gaps that move leave {left:.3g} m at level {level:g}: nothing moves the "
            "structure: must reach it, or [excitation] must drive it"
        )


def _gap_motion(study: Study, basis: DrivenBasis) -> GapMotion:
    """How gaps move, in harmonics of the frequency of the response.

    Raises:
        StudyError: if the series lacks a harmonic.
    """
    motion = basis.gap_motion
    if not motion.moves:
        return motion
    base = base_order(driving_orders(study))
    found = replace(motion, harmonics=tuple(n // base for n in motion.harmonics))
    if found.highest > study.resolution.harmonics:
        raise StudyError(
            f"mode.harmonics = {study.resolution.harmonics}: must be {found.highest} or more, the "
            "highest harmonic of the gaps that move"
        )
    return found


def driven_motions(
    study: Study,
    structure: DrivenStructure,
    stages: Stages | None = None,
    *,
    known: Response | None = None,
    on_level: Callable[[int, Response], None] = lambda number, found: None,
) -> Response:
    """The motions of its driven structure that a study asks for.

    Args:
        study: Study.
        structure: Its driven structure.
        stages: Timings and progress.
        known: Levels, and a damped backbone, that were found before.
        on_level: Called with the number of each level, from 0, and its response.
    """
    assert study.response is not None  # refused by `driven_structure`
    stages = stages or Stages()
    series = FourierSeries(study.resolution.harmonics, study.resolution.samples)
    with stages.stage("response"):
        found = response(
            structure,
            series,
            response_frequencies(study),
            study.response.levels,
            known=known,
            on_level=on_level,
            on_progress=stages.report,
        )
    if study.response.backbone and known and _has_backbone_of(known, found):
        backbone = known.backbone
    else:
        backbone = _backbone(study, structure, series, stages)
    with stages.stage("other pieces"):
        found = with_isolas(
            structure,
            series,
            response_frequencies(study),
            replace(found, backbone=backbone),
            on_progress=stages.report,
        )
    with stages.stage("in time"):
        found = replace(found, instead=tuple(_instead(structure, found, stages)))
    return _at_speeds(found, speed_per_hertz(study))


def _has_backbone_of(known: Response, found: Response) -> bool:
    """Whether the damped backbone that was found before is that of all levels."""
    return bool(known.backbone.points) and set(known.levels) == set(found.levels)


def _instead(structure: DrivenStructure, found: Response, stages: Stages) -> Iterator[Instead]:
    """What the structure does where no stable motion is known, level by level."""
    for number, level in enumerate(found.levels, start=1):
        yield from instead(structure, level, found.at_level(level))
        stages.report(number / len(found.levels))


def _at_speeds(found: Response, per_hertz: float) -> Response:
    """A response with the speeds of rotation, in rad/s per Hz, that go with its frequencies."""
    points = tuple(replace(each, speed=per_hertz * each.frequency) for each in found.points)
    return replace(found, points=points, backbone=found.backbone.at_speeds(per_hertz))


def _backbone(
    study: Study, structure: DrivenStructure, series: FourierSeries, stages: Stages
) -> DampedBackbone:
    """The motions in phase resonance, if a study asks for them."""
    assert study.response is not None  # refused by `driven_structure`
    if not study.response.backbone:
        return DampedBackbone()
    with stages.stage("damped backbone"):
        return damped_backbone(
            structure,
            series,
            wanted_frequencies(study),
            study.response.levels,
            on_progress=stages.report,
        )


def _harmonics(study: Study) -> tuple[int, ...]:
    """The same, all of which the series has.

    Raises:
        StudyError: as `drive_harmonics`, or if it lacks one.
    """
    found = drive_harmonics(study)
    if max(found, default=0) > study.resolution.harmonics:
        raise StudyError(
            f"mode.harmonics = {study.resolution.harmonics}: must be {max(found)} or more, the "
            "highest harmonic of the excitation"
        )
    return found


def _watched(study: Study, basis: DrivenBasis) -> Watched:
    """Places that are watched, by their names.

    Raises:
        StudyError: if two have one name.
    """
    names = (
        *numbered("excitation", len(basis.excited)),
        *(each.name for each in study.monitor),
    )
    shapes = np.vstack([basis.excited, basis.monitored])
    places = {
        name: Place(shapes[n], basis.residual[n], basis.bent[n]) for n, name in enumerate(names)
    }
    found = Watched.of(basis.model, places)
    for name in names:
        if names.count(name) > 1 or found.names.count(name) > 1 or name.startswith("contact "):
            raise StudyError(f'monitor.name = "{name}": must differ from those of other places')
    return found


def assert_drivable(study: Study, command: str) -> None:
    """Refuse a study that cannot be driven.

    Raises:
        StudyError: if a section is missing, or its reduction is another one.
    """
    given = study.driven_sections
    missing = [name for name in _NEEDED if name not in given]
    if study.contact.passing_orders and study.automatic:
        raise StudyError(
            f'{study.automatic[0]} = "auto": does not go with gaps that move: must be a number'
        )
    if study.contact.passing_orders and "excitation" in missing:
        missing.remove("excitation")
    missing = missing if {"damping", "dashpot"} & set(given) else ["damping", *missing]
    if missing:
        verb = "is" if len(missing) == 1 else "are"
        raise StudyError(
            f"{', '.join(missing)}: {verb} missing: fenics-nnm {command} needs the sections "
            "[damping] or [[dashpot]], [excitation] and [response]"
        )
    if study.reduction.method != "massless":
        raise StudyError(
            f'reduction.method = "{study.reduction.method}": fenics-nnm {command} needs "massless"'
        )
