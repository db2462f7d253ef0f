"""Matrices of another code at the speeds of a Campbell diagram."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ConvergenceError, ModelError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.reduction.matrix_modes import MatrixSolver
from fenics_nnm.reduction.mode_lines import same_modes
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.matrix_structure import MatrixStructure
from fenics_nnm.structure.spinning import SPARE, Spin
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

    def at(self, speed: float, count: int, before: Array | None) -> Spin:
        """The structure at a speed, see `structure.campbell`; to be called on all ranks."""
        matrices = self.study.matrices.model_copy(update={"speed": speed})
        study = self.study.model_copy(update={"matrices": matrices})
        kept, hertz, shapes, gap = on_root(self.comm, self._modes, study, count, before)
        return Spin(study, _analyse, kept, hertz, shapes, gap)

    def _modes(
        self, study: MatrixStudy, count: int, before: Array | None
    ) -> tuple[Indices, Array, Array, float]:
        """Indices, frequencies and shapes of the followed modes, and the smallest gap.

        Raises:
            ModelError: if there are no modes at the first speed.
            ConvergenceError: if there are none at a later one.
        """
        matrices = MatrixStructure(study).matrices_at_speed(Stages())
        if before is None:
            return _lowest(matrices, count)
        try:
            found = MatrixSolver(matrices).modes(min(count + SPARE, matrices.massive))
        except ModelError as error:  # of matrices that were in order at the first speed
            raise ConvergenceError(str(error)) from error
        kept = same_modes(before.T @ (matrices.M @ found.shapes))
        return kept, found.frequencies[kept], found.shapes[:, kept], float(matrices.gap.min())


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


def _lowest(matrices: Matrices, count: int) -> tuple[Indices, Array, Array, float]:
    found = MatrixSolver(matrices).modes(min(count, matrices.massive))
    gap = float(matrices.gap.min())
    return np.arange(len(found.omega)), found.frequencies, found.shapes, gap
