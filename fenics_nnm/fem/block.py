"""Blocks of columns at the degrees of freedom that a rank owns, and PETSc matrices."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError

#: Columns that are dealt with at once where each is a copy: in products, and in solutions, which
#: are the faster the more there are.
_AT_ONCE, SOLVED_AT_ONCE = 16, 256


def groups(count: int, at_once: int = _AT_ONCE) -> Iterator[slice]:
    """Columns, a few at a time, so that copies of them take little memory."""
    for first in range(0, count, at_once):
        yield slice(first, min(first + at_once, count))


def solved(ksp: PETSc.KSP, columns: Array) -> Array:
    """Solutions for right-hand sides of shape (n_owned, k), many at once.

    Raises:
        ConvergenceError: if the solver fails, as with factors of numbers that are too far apart.
    """
    solution = np.zeros(columns.shape, order="F")
    for group in groups(columns.shape[1], SOLVED_AT_ONCE):
        right, left = (_dense(each[:, group], ksp.comm) for each in (columns, solution))
        try:
            ksp.matSolve(right, left)
        except PETSc.Error as error:
            raise ConvergenceError(
                f"linear equations cannot be solved, PETSc error {error.ierr}: numbers are too "
                "large or too far apart: check lengths, units, material and loads"
            ) from error
        right.destroy()
        left.destroy()
    return solution


def product(matrix: PETSc.Mat, columns: Array) -> Array:
    """Matrix times columns of shape (n_owned, k): the matrix is read once for several.

    Columns are one after the other in memory.
    """
    result = np.empty((matrix.getLocalSize()[0], columns.shape[1]), order="F")
    for group in groups(columns.shape[1]):
        right, left = (_dense(each[:, group], matrix.comm) for each in (columns, result))
        matrix.matMult(right, left)
        right.destroy()
        left.destroy()
    return result


def _dense(columns: Array, comm: PETSc.Comm) -> PETSc.Mat:
    """A matrix of columns; it is in their memory where they are one after the other there."""
    matrix = PETSc.Mat().createDense(
        ((len(columns), PETSc.DETERMINE), (PETSc.DECIDE, columns.shape[1])),
        array=np.asfortranarray(columns),
        comm=comm,
    )
    matrix.assemble()
    return matrix
