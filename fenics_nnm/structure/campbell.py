"""Frequencies of a structure over its speed: the lines of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError, StudyError
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analyse
from fenics_nnm.structure.motions_at_speed import MotionAtSpeed
from fenics_nnm.structure.spinning import Spin
from fenics_nnm.structure.spinning_matrices import SpinningMatrices
from fenics_nnm.structure.spinning_mesh import SpinningMesh
from fenics_nnm.study import MatrixStudy, MeshStudy, Study

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


class _Spinning(Protocol):
    """A structure at any speed."""

    def at(self, speed: float, count: int, before: Array | None) -> Spin:
        """The structure at a speed.

        Args:
            speed: Speed in rad/s.
            count: Number of modes to follow.
            before: Shapes of the modes that are followed at the speed before, if there is one.

        Raises:
            ConvergenceError: if it cannot bear this speed.
        """


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
        NonlinearModeError: as `Structure.linear`, or if modes cannot be found.
    """
    spinning = _spinning(study, comm, stages)
    found: list[AtSpeed] = []
    shapes: Array | None = None
    with stages.stage("speeds"):
        for number, speed in enumerate(speeds):
            try:
                spin = spinning.at(speed, modes, shapes)
            except ConvergenceError as error:
                found.append(AtSpeed(speed, np.empty(0), reason=str(error)))
            else:
                shapes = spin.shapes
                found.append(_with_motions(spin, study.mode.number, motions))
            stages.report((number + 1) / len(speeds))
    return tuple(found)


def _with_motions(spin: Spin, mode: int, motions: Motions) -> AtSpeed:
    """A speed with the nonlinear motions of a mode, by its number at the first speed."""
    number = int(spin.kept[mode - 1]) + 1 if mode <= len(spin.kept) else mode
    now = spin.study.mode.model_copy(update={"number": number})
    found = motions(spin.study.model_copy(update={"mode": now}), spin.analyse)
    return AtSpeed(spin.speed, spin.frequencies, spin.gap, mode=mode, motions=found)


def _of_mesh(study: MeshStudy, comm: MPI.Comm, stages: Stages) -> _Spinning:
    if not study.rotates:
        raise StudyError("rotation: is missing: fenics-nnm campbell needs its axis, of a mesh")
    return SpinningMesh.of(study, comm, stages)


def _of_matrices(study: MatrixStudy, comm: MPI.Comm, stages: Stages) -> _Spinning:
    if study.matrices.speed is None:
        raise StudyError(
            "matrices.speed: is missing: fenics-nnm campbell needs what the speed changes, "
            "matrices.speed_stiffness or contact.gap_growth"
        )
    return SpinningMatrices(study, comm)


_KINDS: Mapping[type, Callable[[Any, MPI.Comm, Stages], _Spinning]] = {
    MeshStudy: _of_mesh,
    MatrixStudy: _of_matrices,
}


def _spinning(study: Study, comm: MPI.Comm, stages: Stages) -> _Spinning:
    return _KINDS[type(study)](study, comm, stages)
