"""The stiffness and mass that are solved with: those of the free, or of the independent, motion.

With constraints u = T v the matrices are T^T K T and T^T M T. Rows of dependent degrees of freedom
stay, with a unit diagonal in the stiffness, as those of clamped ones do, so that arrays of a rank
have one length throughout; v is zero there. Everything outside of the solvers sees u.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.block import product


class System(Protocol):
    """Matrices of the independent motion, and the ways there and back."""

    @property
    def stiffness(self) -> PETSc.Mat:
        """T^T K T in N/m, positive definite if the body is held."""

    @property
    def mass(self) -> PETSc.Mat:
        """T^T M T in kg."""

    @property
    def dependent(self) -> int:
        """Number of dependent degrees of freedom, of all ranks."""

    @property
    def keys(self) -> tuple[str, ...]:
        """Constraints, for messages; none without."""

    def forces(self, columns: Array) -> Array:
        """T^T f of forces at all degrees of freedom of this rank, shape (n_owned, k)."""

    def whole(self, columns: Array) -> Array:
        """T v: displacements u, shape (n_owned, k)."""

    def independent(self, columns: Array) -> Array:
        """The v of displacements u that keep the constraints, shape (n_owned, k)."""


@dataclass(frozen=True, slots=True)
class FreeSystem:
    """A body without constraints: T is the identity.

    Attributes:
        stiffness: K.
        mass: M.
    """

    stiffness: PETSc.Mat
    mass: PETSc.Mat
    dependent: int = 0
    keys: tuple[str, ...] = ()

    def forces(self, columns: Array) -> Array:
        """As `System.forces`."""
        return columns

    def whole(self, columns: Array) -> Array:
        """As `System.whole`."""
        return columns

    def independent(self, columns: Array) -> Array:
        """As `System.independent`."""
        return columns


@dataclass(frozen=True, slots=True)
class ConstrainedSystem:
    """A body with constraints.

    Attributes:
        stiffness: T^T K T, unit diagonal in dependent rows.
        mass: T^T M T.
        dependent: Number of dependent degrees of freedom, of all ranks.
        keys: Constraints, for messages.
        way: T.
        back: T^T.
        left: Local indices of dependent degrees of freedom of this rank.
    """

    stiffness: PETSc.Mat
    mass: PETSc.Mat
    dependent: int
    keys: tuple[str, ...]
    way: PETSc.Mat
    back: PETSc.Mat
    left: Indices

    def forces(self, columns: Array) -> Array:
        """As `System.forces`."""
        return product(self.back, columns)

    def whole(self, columns: Array) -> Array:
        """As `System.whole`."""
        return product(self.way, columns)

    def independent(self, columns: Array) -> Array:
        """As `System.independent`."""
        found = np.array(columns, order="F")
        found[self.left] = 0.0
        return found
