"""What a reduction asks of a structure: products with its matrices, wherever they are kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fenics_nnm.arrays import Array

Product = Callable[[Array], Array]
"""From columns at the degrees of freedom, shape (n, k), to as many columns."""


@dataclass(frozen=True, slots=True)
class Operators:
    """Products with columns at the n degrees of freedom that a rank keeps.

    Attributes:
        stiffness: K u in N.
        mass: M u in kg m.
        static: K^-1 f, displacements under forces, in m.
        contact: B u, displacements of the contact points, shape (n_c, k), the same on all ranks.
        inner: a^T b over all ranks, of two blocks of columns.
    """

    stiffness: Product
    mass: Product
    static: Product
    contact: Product
    inner: Callable[[Array, Array], Array]

    def gram(self, left: Array, right: Array) -> Array:
        """left^T right of a product that is symmetric, without the round-off that is not."""
        whole = self.inner(left, right)
        return (whole + whole.T) / 2
