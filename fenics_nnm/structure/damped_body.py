"""Damping and driving forces of a body on its mesh, in its modes."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fenics_nnm.fem.driven import Dampers
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.structure.body import dashpots_of, excitations_of
from fenics_nnm.structure.damped_rows import DampedRows
from fenics_nnm.study import MeshStudy


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
