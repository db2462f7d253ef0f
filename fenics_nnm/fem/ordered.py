"""Factors of the stiffness of a body, in an order of its degrees of freedom that suits them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.block import solved
from fenics_nnm.fem.dissection import dissected, worth_dissecting
from fenics_nnm.fem.factorisation import (
    ROOT_ALONE,
    factorise,
    limited_memory,
    order_kept,
    takes_cholmod,
    use_fastest,
)
from fenics_nnm.fem.solid import Solid


@dataclass(frozen=True, slots=True)
class Ordered:
    """A solver of a matrix whose rows are in another order.

    Attributes:
        ksp: Solver.
        order: Which row of the matrix each row of the solver's is, shape (n_owned,).
        kept: Whether the solver keeps this order; else it finds one by itself.
    """

    ksp: PETSc.KSP
    order: Indices
    kept: bool

    @classmethod
    def of(cls, solid: Solid, memory: float | None, prefix: str) -> Ordered:
        """The fastest solver of the stiffness of a body, not factorised yet.

        Args:
            solid: Body whose stiffness is positive definite.
            memory: Memory in bytes that a rank may take for factors; no limit if None.
            prefix: Prefix of its PETSc options.
        """
        matrix = solid.stiffness
        kept = takes_cholmod(matrix, memory) and worth_dissecting(solid.space)
        order = dissected(solid.space) if kept else np.arange(solid.owned)
        ksp = PETSc.KSP().create(matrix.comm)
        ksp.setOptionsPrefix(prefix)
        ksp.setOperators(_permuted(matrix, order) if kept else matrix)
        use_fastest(ksp, memory, (ROOT_ALONE,))
        return cls(ksp, order, kept)

    def factorise(self, memory: float | None) -> None:
        """Factorise the matrix, with some memory in bytes at most.

        Raises:
            OutOfMemoryError: if there is too little memory.
            ConvergenceError: if there is no factorisation for another reason.
        """
        with limited_memory(self.ksp, memory), order_kept(self.ksp, self.kept):
            factorise(self.ksp)

    def solve(self, columns: Array) -> Array:
        """Solutions for right-hand sides of shape (n_owned, k).

        Raises:
            ConvergenceError: if the solver fails.
        """
        found = np.empty(columns.shape, order="F")
        found[self.order] = solved(self.ksp, columns[self.order])
        return found

    def release(self) -> None:
        """Free the factors."""
        self.ksp.destroy()


def _permuted(matrix: PETSc.Mat, order: Indices) -> PETSc.Mat:
    """A symmetric matrix with rows and columns in an order."""
    places = PETSc.IS().createGeneral(order, comm=matrix.comm)
    found = matrix.permute(places, places)
    found.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return found
