"""Frequencies of a structure over its speed: the lines of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ConvergenceError, NonlinearModeError, StudyError
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analyse
from fenics_nnm.structure.motions_at_speed import MotionAtSpeed
from fenics_nnm.structure.spinning import FollowedModes, Spin, SpinModes
from fenics_nnm.structure.spinning_matrices import SpinningMatrices, matrices_spun
from fenics_nnm.structure.spinning_mesh import SpinningMesh, mesh_spun
from fenics_nnm.study import MatrixStudy, MeshStudy, Study
from fenics_nnm.study.error_keys import one_line

#: Faster speeds, in rad/s, are a misprint.
FASTEST = 1e9

Motions = Callable[[Study, Analyse], tuple[MotionAtSpeed, ...]]
"""Nonlinear motions of a study at its speed, whose `Analyse` finds what is linear of it."""


@dataclass(frozen=True, slots=True)
class AtSpeed:
    """A structure at a speed.

    Attributes:
        speed: Speed in rad/s.
        frequencies: Frequency of each mode that is followed in Hz, shape (k,); none if there is no
            static state.
        gap: Smallest gap of the vertices of the contact patches, or of the contact rows, in m.
        reason: Why there is no static state, empty if there is one.
        mode: Number of the mode at the first speed, from 1, whose motions these are.
        motions: Its nonlinear motions that were asked for.
    """

    speed: float
    frequencies: Array
    gap: float = np.nan
    reason: str = ""
    mode: int = 1
    motions: tuple[MotionAtSpeed, ...] = ()


class Spinning(Protocol):
    """A structure at any speed."""

    def at(self, speed: float, count: int) -> Spin:
        """The structure at a speed; to be called on all ranks.

        Args:
            speed: Speed in rad/s.
            count: Number of modes to follow; a few more are computed.

        Raises:
            ConvergenceError: if it cannot bear this speed.
            MeshError, ModelError: if it is not in order at this speed.
        """

    def inner(self, left: Array, right: Array) -> Array:
        """a^T b over all ranks, of two blocks of columns."""


def campbell_lines(
    study: Study,
    speeds: Sequence[float],
    modes: int,
    comm: MPI.Comm,
    stages: Stages,
    motions: Motions = lambda study, analyse: (),
) -> tuple[AtSpeed, ...]:
    """Frequencies of the lowest modes at the first speed, followed by their shapes over others.

    Args:
        study: Study of a mesh with a section [rotation], or of matrices with a speed; which speed
            does not matter.
        speeds: Speeds in rad/s, ascending.
        modes: Number of modes to follow.
        comm: Communicator; all ranks call this.
        stages: Timings and progress.
        motions: Finds nonlinear motions of the study at each speed, of the mode that has the
            number `mode.number` at the first one; none by default.

    Raises:
        StudyError: if the study has no speed.
        NonlinearModeError: as `Structure.linear`, or if the first modes cannot be found.
    """
    spinning = spinning_of(study, comm, stages)
    followed = FollowedModes(modes, spinning.inner)
    found: list[AtSpeed] = []
    with stages.stage("speeds"):
        for number, speed in enumerate(speeds):
            try:
                spin = spinning.at(speed, modes)
            except NonlinearModeError as error:
                found.append(without_modes(speed, error, followed))
            else:
                kept = followed.at(spin.modes)
                now = with_followed(spin.study, kept)
                moving = motions(now, spin.analyse)
                found.append(at_speed(study, spin.modes, kept, moving))
            stages.report((number + 1) / len(speeds))
    return tuple(found)


def without_modes(speed: float, error: NonlinearModeError, followed: FollowedModes) -> AtSpeed:
    """A speed that the structure cannot bear, or at which it is not in order though it was before.

    Raises:
        NonlinearModeError: the error, if it is one of the structure and not of the speed.
    """
    if not (followed.begun or isinstance(error, ConvergenceError)):
        raise error
    return AtSpeed(speed, np.empty(0), reason=one_line(error))


def with_followed(study: Any, kept: Indices) -> Any:
    """A study at a speed, with the number that its mode, followed from the first speed, has there.

    Args:
        study: The study at this speed.
        kept: Index of each followed mode there, from 0.
    """
    mode = study.mode.number
    number = int(kept[mode - 1]) + 1 if mode <= len(kept) else mode
    return study.model_copy(update={"mode": study.mode.model_copy(update={"number": number})})


def at_speed(
    study: Study, modes: SpinModes, kept: Indices, motions: tuple[MotionAtSpeed, ...]
) -> AtSpeed:
    """What a diagram shows of a speed."""
    hertz = modes.frequencies[kept]
    return AtSpeed(modes.speed, hertz, modes.gap, mode=study.mode.number, motions=motions)


def _of_mesh(study: MeshStudy, comm: MPI.Comm, stages: Stages) -> Spinning:
    if not study.rotates:
        raise StudyError("rotation: is missing: fenics-nnm campbell needs its axis, of a mesh")
    return SpinningMesh.of(study, comm, stages)


def _of_matrices(study: MatrixStudy, comm: MPI.Comm, stages: Stages) -> Spinning:
    if study.matrices.speed is None:
        raise StudyError(
            "matrices.speed: is missing: fenics-nnm campbell needs what the speed changes, "
            "matrices.speed_stiffness or contact.gap_growth"
        )
    return SpinningMatrices(study, comm)


@dataclass(frozen=True, slots=True)
class _Kind:
    """What is done with a kind of study.

    Attributes:
        spinning: Makes its structure at any speed.
        spun: The study at another speed.
    """

    spinning: Callable[[Any, MPI.Comm, Stages], Spinning]
    spun: Callable[[Any, float], Any]


_KINDS: Mapping[type, _Kind] = {
    MeshStudy: _Kind(_of_mesh, mesh_spun),
    MatrixStudy: _Kind(_of_matrices, matrices_spun),
}


def spinning_of(study: Study, comm: MPI.Comm, stages: Stages) -> Spinning:
    """The structure of a study at any speed; to be called on all ranks.

    Raises:
        StudyError: if the study has no speed.
        NonlinearModeError: as `Structure.linear`.
    """
    return _KINDS[type(study)].spinning(study, comm, stages)


def spun(study: Study, speed: float) -> Any:
    """The study at another speed in rad/s."""
    return _KINDS[type(study)].spun(study, speed)
