"""Modes of a body whose contact interface is held, by a low-rank change of the free solve."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError
from fenics_nnm.fem.eigenproblem import eigenproblem
from fenics_nnm.fem.solid import Solid


class _HeldSolve:
    """Preconditioner that solves with the interface held.

    With F the interface forces and X = K^-1 F,

        y = K^-1 b - X (F^T X)^-1 F^T K^-1 b

    is the displacement under b that keeps F^T y = 0.
    """

    def __init__(self, ksp: PETSc.KSP, forces: Array, attachments: Array, comm: MPI.Comm) -> None:
        self._ksp, self._forces, self._attachments, self._comm = ksp, forces, attachments, comm
        flexibility = comm.allreduce(forces.T @ attachments)
        self._stiffness = np.linalg.inv((flexibility + flexibility.T) / 2)

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, left: PETSc.Vec) -> None:
        """Solve for one right-hand side."""
        self._ksp.solve(right, left)
        motion = self._comm.allreduce(self._forces.T @ left.array_r)
        left.array -= self._attachments @ (self._stiffness @ motion)


def fixed_interface_modes(
    solid: Solid, ksp: PETSc.KSP, forces: Array, attachments: Array, count: int
) -> Array:
    """The lowest modes of the body with its contact interface held.

    Args:
        solid: Assembled body.
        ksp: Solver with the factorised stiffness of the body, interface free.
        forces: Unit forces of the interface, shape (n_owned, i).
        attachments: Displacements under them, shape (n_owned, i).
        count: Number of modes.

    Returns:
        Mass-normalised shapes, shape (n_owned, count).

    Raises:
        ConvergenceError: if the eigensolver fails.
    """
    system = solid.system
    eps = eigenproblem(system.stiffness, system.mass, "nnm_interface_")
    eps.setDimensions(count)
    solver = eps.getST().getKSP()
    solver.setType(PETSc.KSP.Type.PREONLY)
    solver.getPC().setType(PETSc.PC.Type.PYTHON)
    comm = solid.tagged.mesh.comm
    held = _HeldSolve(ksp, system.forces(forces), system.independent(attachments), comm)
    solver.getPC().setPythonContext(held)
    eps.solve()
    if eps.getConverged() < count:
        raise ConvergenceError(
            f"eigensolver: {eps.getConverged()} of {count} fixed-interface modes converged"
        )
    shapes = np.empty((solid.owned, count))
    vector = system.stiffness.createVecRight()
    for column in range(count):
        eps.getEigenvector(column, vector)
        shapes[:, column] = vector.array_r
    vector.destroy()
    eps.destroy()
    return system.whole(shapes)
