"""Products with the matrices of a body, and sums over all ranks, for blocks of columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.block import product
from fenics_nnm.fem.solid import Solid


@dataclass(frozen=True, slots=True)
class Pencil:
    """K and M of a body.

    Attributes:
        solid: Assembled body.
    """

    solid: Solid

    def stiffness(self, columns: Array) -> Array:
        """K u in N, of columns of shape (n_owned, k)."""
        return product(self.solid.stiffness, columns)

    def mass(self, columns: Array) -> Array:
        """M u in kg m, of columns of shape (n_owned, k)."""
        return product(self.solid.mass, columns)

    def inner(self, left: Array, right: Array) -> Array:
        """a^T b over all ranks."""
        return np.asarray(self.solid.tagged.mesh.comm.allreduce(left.T @ right))

    def products(self, left: Array, right: Array) -> Array:
        """Scalar product of each column of a with the same column of b, over all ranks."""
        own = np.einsum("ij,ij->j", left, right)
        return np.asarray(self.solid.tagged.mesh.comm.allreduce(own))
