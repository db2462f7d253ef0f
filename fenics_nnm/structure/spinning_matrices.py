"""Matrices of another code at the speeds of a Campbell diagram."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.reduction.matrix_modes import MatrixSolver
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.matrix_structure import MatrixStructure
from fenics_nnm.structure.spinning import SPARE, Spin, SpinModes
from fenics_nnm.structure.structure import Linear
from fenics_nnm.study import MatrixStudy, Study


@dataclass(frozen=True, slots=True)
class SpinningMatrices:
    """Matrices whose stiffness, or gap, changes with speed.

    Attributes:
        study: Study with a speed.
        comm: Communicator; the first rank deals with the matrices for all.
    """

    study: MatrixStudy
    comm: MPI.Comm

    def inner(self, left: Array, right: Array) -> Array:
        """a^T b of two blocks of columns, which all ranks have in full."""
        return np.asarray(left.T @ right)

    def at(self, speed: float, count: int) -> Spin:
        """The structure at a speed, see `structure.campbell`; to be called on all ranks."""
        study = matrices_spun(self.study, speed)
        return Spin(study, _analyse, on_root(self.comm, _modes, study, count + SPARE))


def matrices_spun(study: MatrixStudy, speed: float) -> MatrixStudy:
    """The study at another speed in rad/s."""
    matrices = study.matrices.model_copy(update={"speed": speed})
    return study.model_copy(update={"matrices": matrices})


def _modes(study: MatrixStudy, count: int) -> SpinModes:
    """Modes at the speed of a study, or as many as there are.

    Raises:
        ModelError: if there are none.
    """
    matrices = MatrixStructure(study).matrices_at_speed(Stages())
    solver = MatrixSolver(matrices)
    found = solver.modes(min(count, matrices.massive))
    coupled = solver.coriolis(found) / (2 * np.pi) if study.coriolis else np.empty(0)
    momenta, gap = matrices.M @ found.shapes, float(matrices.gap.min())
    speed = float(study.speed)
    frequencies = coupled if len(coupled) else found.frequencies
    return SpinModes(speed, frequencies, found.shapes, np.asarray(momenta), gap)


def _analyse(
    study: Study,
    comm: MPI.Comm,
    stages: Stages | None = None,
    *,
    at_most: int | None = None,
    reached: object = None,
) -> Linear:
    """As `linear_analysis`; terms of matrices are theirs, however far a branch goes."""
    return linear_analysis(study, comm, stages, at_most=at_most)
