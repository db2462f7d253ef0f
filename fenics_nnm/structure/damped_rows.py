"""Damping and driving forces of a study in the modes of its structure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.driven import Dampers
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.reduction.driven import DrivenPlaces
from fenics_nnm.structure.body import dashpots_of, excitations_of
from fenics_nnm.study import MeshStudy


@dataclass(frozen=True, slots=True)
class DampedRows:
    """Damping and forces at places, in modes.

    Attributes:
        rate: C of dashpots and of a damping matrix in 1/s, shape (J, J).
        excited: Displacement of the excited places, each along its force, kg^-1/2, shape (p, J).
        sizes: Sizes of the forces in N, 0-peak, shape (p,).
    """

    rate: Array
    excited: Array
    sizes: Array


def rows_of_body(linear: LinearAnalysis, study: MeshStudy) -> DampedRows:
    """Those of a body on its mesh; to be called on all ranks.

    Raises:
        MeshError: if a force or a dashpot is not on the body, or clamped.
    """
    solid, shapes = linear.solid, linear.modes.shapes
    comm, dim = solid.tagged.mesh.comm, solid.tagged.dim
    damped = Dampers.of(solid, dashpots_of(study, dim)).forces(shapes)
    pushes = [each.column(solid) for each in excitations_of(study, dim)]
    columns = np.reshape([column for column, _ in pushes], (-1, solid.owned))
    return DampedRows(
        rate=comm.allreduce(shapes.T @ damped, op=MPI.SUM),
        excited=comm.allreduce(columns @ shapes, op=MPI.SUM),
        sizes=np.array([size for _, size in pushes]),
    )


def rows_of_matrices(shapes: Array, places: DrivenPlaces) -> DampedRows:
    """Those of matrices, from the shapes of their modes, (n, J)."""
    rate = shapes.T @ places.damping(shapes)
    return DampedRows(rate, places.excited.T @ shapes, places.sizes)
