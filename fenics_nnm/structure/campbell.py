"""Frequencies of a body over its speed: the lines of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ConvergenceError, StudyError
from fenics_nnm.fem.block import product
from fenics_nnm.fem.contact_sites import contact_sites
from fenics_nnm.fem.gyroscopic import coriolis_frequencies
from fenics_nnm.fem.linear import operators_of
from fenics_nnm.fem.memory import memory_of_rank
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.static_state import loaded
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.mode_lines import same_modes
from fenics_nnm.stages import Stages
from fenics_nnm.structure.contact_patches import contact_patches
from fenics_nnm.structure.loading import loads_of
from fenics_nnm.structure.mesh_structure import Assembled, MeshStructure
from fenics_nnm.structure.point_choice import evenly_spread
from fenics_nnm.study import MeshStudy, Study

#: Modes computed beyond those that are followed, as lines cross.
_SPARE = 4


@dataclass(frozen=True, slots=True)
class AtSpeed:
    """A body at a speed.

    Attributes:
        speed: Speed in rad/s.
        frequencies: Frequency of each mode that is followed in Hz, shape (k,); none if there is no
            static state.
        gap: Smallest gap of the vertices of the contact patches in m.
        reason: Why there is no static state, empty if there is one.
    """

    speed: float
    frequencies: Array
    gap: float = np.nan
    reason: str = ""


def campbell_lines(
    study: Study, speeds: Sequence[float], modes: int, comm: MPI.Comm, stages: Stages
) -> tuple[AtSpeed, ...]:
    """Frequencies of the lowest modes at the first speed, followed by their shapes over others.

    Args:
        study: Study of a mesh with a section [rotation], whose speed does not matter.
        speeds: Speeds in rad/s, ascending.
        modes: Number of modes to follow.
        comm: Communicator; all ranks call this.
        stages: Timings and progress.

    Raises:
        StudyError: if the study does not rotate.
        NonlinearModeError: as `MeshStructure.assembled`, or if modes cannot be found.
    """
    if not study.rotates:
        raise StudyError("rotation: is missing: fenics-nnm campbell needs its axis, of a mesh")
    body = cast(MeshStudy, study)
    bare = body.model_copy(update={"rotation": None, "load": None})
    plain = MeshStructure(bare).assembled(comm, stages)
    found: list[AtSpeed] = []
    shapes: Array | None = None
    with stages.stage("speeds"):
        for number, speed in enumerate(speeds):
            spun = _spun(body, speed)
            try:
                point, shapes = _at_speed(spun, plain, modes, shapes)
            except ConvergenceError as error:
                point = AtSpeed(speed, np.empty(0), reason=str(error))
            found.append(point)
            stages.report((number + 1) / len(speeds))
    return tuple(found)


def _at_speed(
    study: MeshStudy, plain: Assembled, count: int, before: Array | None
) -> tuple[AtSpeed, Array]:
    """A body at the speed of a study, and the shapes of the modes that are followed."""
    solid = plain.solid
    if study.loaded:
        memory = memory_of_rank(solid.tagged.mesh.comm, study.solver.memory)
        solid = loaded(solid, loads_of(study, solid.tagged.dim), memory)
    sites = contact_sites(solid, contact_patches(study.contact, solid.tagged))
    wanted = min(count + _SPARE, solid.free)
    with DirectModalSolver(solid) as solver:
        modes = solver.modes(wanted)
        omega = modes.omega
        if study.coriolis and study.speed and solid.state is not None:
            rotation = solid.state.loads.rotation
            assert rotation is not None
            assembled = replace(plain, solid=solid, sites=sites)
            operators = operators_of(solid, assembled.interface(evenly_spread(sites)), solver)
            omega = coriolis_frequencies(solid, rotation, modes, operators)
    kept = _followed(solid, modes, before, min(count, wanted))
    frequencies = omega[kept] / (2 * np.pi)
    return AtSpeed(study.speed, frequencies, float(sites.gap.min())), modes.shapes[:, kept]


def _followed(solid: Solid, modes: LinearModes, before: Array | None, count: int) -> Indices:
    """Which modes go on those of a speed before, or the lowest ones."""
    if before is None:
        return np.arange(count)
    comm = solid.tagged.mesh.comm
    return same_modes(comm.allreduce(before.T @ product(solid.mass, modes.shapes)))


def _spun(study: MeshStudy, speed: float) -> MeshStudy:
    """The study at another speed; casings grow with its square."""
    assert study.rotation is not None
    rotation = study.rotation.model_copy(update={"speed": speed, "rpm": None})
    own = study.speed
    contact = _at(study, (speed / own) ** 2 if own else 0.0)
    return study.model_copy(update={"rotation": rotation, "contact": contact})


def _at(study: MeshStudy, factor: float) -> Any:
    """The contact section with the growth of its casings times a factor."""
    contact = study.contact
    if "patch" not in type(contact).model_fields:
        return _grown(contact, factor)
    patches = tuple(_grown(patch, factor) for patch in contact.patches.values())
    return contact.model_copy(update={"patch": patches})


def _grown(patch: Any, factor: float) -> Any:
    growth = getattr(patch.casing, "growth", 0.0)
    if not growth:
        return patch
    casing = patch.casing.model_copy(update={"growth": growth * factor})
    return patch.model_copy(update={"casing": casing})
