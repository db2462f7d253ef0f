"""Sparse matrices without the zeros that they were made with."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc


def without_zeros(matrix: PETSc.Mat) -> PETSc.Mat:
    """A copy with the entries alone that are not zero; products are the same bit for bit.

    A mass has blocks of a node and another one that are multiples of the unit matrix: two thirds of
    the entries that it shares with the stiffness of a body in space are zero.
    """
    first, columns, values = matrix.getValuesCSR()
    kept = np.flatnonzero(values)
    rows = np.searchsorted(kept, first).astype(first.dtype)
    csr = (rows, columns[kept], values[kept])
    return PETSc.Mat().createAIJ(matrix.getSizes(), csr=csr, comm=matrix.comm)
