"""Factors of the stiffness of a body, in an order of its degrees of freedom that suits them."""

from __future__ import annotations

from collections.abc import Sequence
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
    negative_pivots,
    order_kept,
    takes_cholmod,
    use_fastest,
    use_mumps,
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
        matrix, kept = solid.stiffness, pays(solid, memory)
        order = dissected(solid.space) if kept else np.arange(solid.owned)
        ksp = _solver(_permuted(matrix, order) if kept else matrix, prefix)
        use_fastest(ksp, memory, (ROOT_ALONE,))
        return cls(ksp, order, kept)

    @classmethod
    def by_mumps(
        cls, matrix: PETSc.Mat, prefix: str, settings: Sequence[tuple[str, int]] = ()
    ) -> Ordered:
        """MUMPS, which finds an order by itself, for any symmetric matrix; not factorised yet.

        Args:
            matrix: Matrix.
            prefix: Prefix of its PETSc options.
            settings: Options of MUMPS and their values.
        """
        ksp = _solver(matrix, prefix)
        use_mumps(ksp, settings)
        return cls(ksp, np.arange(matrix.getLocalSize()[0]), kept=False)

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues of the matrix, once it is factorised."""
        return negative_pivots(self.ksp)

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
        return self.restored(self.solve_in_order(self.in_order(columns)))

    def solve_in_order(self, columns: Array) -> Array:
        """Solutions in the order of the solver for right-hand sides in this order.

        Raises:
            ConvergenceError: if the solver fails.
        """
        return solved(self.ksp, columns)

    def matrix_in_order(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """A symmetric matrix of the body with its rows in the order of the solver."""
        return _permuted(matrix, self.order) if self.kept else matrix

    def in_order(self, columns: Array) -> Array:
        """Columns of shape (n_owned, k) with their rows in the order of the solver."""
        return columns[self.order] if self.kept else columns

    def restored(self, columns: Array) -> Array:
        """Columns in the order of the solver, shape (n_owned, k), in that of the matrix."""
        if not self.kept:
            return columns
        found = np.empty(columns.shape, order="F")
        found[self.order] = columns
        return found

    def release(self) -> None:
        """Free the factors."""
        self.ksp.destroy()


def pays(solid: Solid, memory: float | None) -> bool:
    """Whether CHOLMOD in the order of nested dissection is the fastest for a body.

    Args:
        solid: Body.
        memory: Memory in bytes that a rank may take for factors; no limit if None.
    """
    return takes_cholmod(solid.stiffness, memory) and worth_dissecting(solid.space)


def _solver(matrix: PETSc.Mat, prefix: str) -> PETSc.KSP:
    ksp = PETSc.KSP().create(matrix.comm)
    ksp.setOptionsPrefix(prefix)
    ksp.setOperators(matrix)
    return ksp


def _permuted(matrix: PETSc.Mat, order: Indices) -> PETSc.Mat:
    """A symmetric matrix with rows and columns in an order."""
    places = PETSc.IS().createGeneral(order, comm=matrix.comm)
    found = matrix.permute(places, places)
    found.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return found
