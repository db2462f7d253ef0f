"""K^-1 and M of a body whose stiffness is factorised, for blocks of columns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem.block import product
from fenics_nnm.fem.system import System


class Factors(Protocol):
    """Factors of a stiffness: `Ordered` or `Substructures`."""

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues of the stiffness."""

    def solve(self, columns: Array) -> Array:
        """Solutions for right-hand sides of shape (n_owned, k)."""

    def solve_in_order(self, columns: Array) -> Array:
        """The same with rows in the order of the factors."""

    def in_order(self, columns: Array) -> Array:
        """Columns of shape (n_owned, k) with their rows in the order of the factors."""

    def matrix_in_order(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """A symmetric matrix of the body with its rows in the order of the factors."""

    def restored(self, columns: Array) -> Array:
        """Columns in the order of the factors, shape (n_owned, k), in that of the matrix."""

    def release(self) -> None:
        """Free the factors."""


@dataclass(frozen=True, slots=True)
class Factored:
    """The system that is solved, as `block_lanczos.Inverse`: rows are in the order of its factors.

    Attributes:
        inverse: The factors of K.
        system: Stiffness and mass, in their own order.
        mass_matrix: Its mass in the order of the factors.
        comm: Ranks.
        generator: Of random displacements, of this rank.
    """

    inverse: Factors
    system: System
    mass_matrix: PETSc.Mat
    comm: MPI.Comm
    generator: np.random.Generator

    @classmethod
    def of(cls, inverse: Factors, system: System, comm: MPI.Comm) -> Factored:
        """With a generator that gives the same numbers in each run."""
        mass = inverse.matrix_in_order(system.mass)
        return cls(inverse, system, mass, comm, np.random.default_rng(comm.rank))

    @property
    def rows(self) -> int:
        """Owned degrees of freedom, n_owned."""
        return int(self.mass_matrix.getLocalSize()[0])

    def solve(self, forces: Array) -> Array:
        """K^-1 f, columns of shape (n_owned, k)."""
        return self.inverse.solve_in_order(forces)

    def mass(self, columns: Array) -> Array:
        """M u, columns of shape (n_owned, k)."""
        return product(self.mass_matrix, columns)

    def inner(self, left: Array, right: Array) -> Array:
        """a^T b over all ranks."""
        return np.asarray(self.comm.allreduce(left.T @ right))

    def random(self, count: int) -> Array:
        """Random columns, other ones at each call, shape (n_owned, count)."""
        return self.generator.standard_normal((self.rows, count))
