"""Blocks of columns at the degrees of freedom that a rank owns, and PETSc matrices."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array


def solved(ksp: PETSc.KSP, columns: Array) -> Array:
    """Solutions for right-hand sides of shape (n_owned, k), all at once."""
    comm = ksp.comm
    right, left = _dense(columns, comm), _dense(np.zeros_like(columns), comm)
    ksp.matSolve(right, left)
    solution = np.array(left.getDenseArray(readonly=True))
    right.destroy()
    left.destroy()
    return solution


def product(matrix: PETSc.Mat, columns: Array) -> Array:
    """Matrix times columns of shape (n_owned, k), all at once: the matrix is read once for several.

    Columns are one after the other in memory.
    """
    right = _dense(columns, matrix.comm)
    left = matrix.matMult(right)
    result = np.array(left.getDenseArray(readonly=True), order="F")
    right.destroy()
    left.destroy()
    return result


def _dense(columns: Array, comm: PETSc.Comm) -> PETSc.Mat:
    matrix = PETSc.Mat().createDense(
        ((len(columns), PETSc.DETERMINE), (PETSc.DECIDE, columns.shape[1])),
        array=np.asfortranarray(columns),
        comm=comm,
    )
    matrix.assemble()
    return matrix
