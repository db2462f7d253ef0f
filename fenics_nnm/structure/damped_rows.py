"""Damping and driving forces of a study in the modes of its structure."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.arrays import Array
from fenics_nnm.reduction.driven import DrivenPlaces


@dataclass(frozen=True, slots=True)
class DampedRows:
    """Damping and forces at places, in modes.

    Attributes:
        rate: C of dashpots and of a damping matrix in 1/s, shape (J, J).
        excited: Displacement of the excited places, each along its force, kg^-1/2, shape (p, J).
        sizes: Sizes of the forces in N, 0-peak, shape (p,).
    """

    rate: Array
    excited: Array
    sizes: Array


def rows_of_matrices(shapes: Array, places: DrivenPlaces) -> DampedRows:
    """Those of matrices, from the shapes of their modes, (n, J)."""
    rate = shapes.T @ places.damping(shapes)
    return DampedRows(rate, places.excited.T @ shapes, places.sizes)
