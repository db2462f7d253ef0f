"""Static displacements by preconditioned conjugate gradients, several columns at once."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError
from fenics_nnm.fem.block import groups
from fenics_nnm.fem.pencil import Pencil
from fenics_nnm.reduction.operators import Product

#: Largest number of iterations.
_ITERATIONS = 500


def static_displacements(
    pencil: Pencil, precondition: Product, forces: Array, *, tolerance: float
) -> Array:
    """K^-1 f for columns f of shape (n_owned, k), some of which take their steps together.

    Args:
        pencil: Products with K, and sums over all ranks.
        precondition: T, symmetric positive definite, near K^-1.
        forces: Columns in N.
        tolerance: Largest sqrt(r^T T r / f^T T f) of the residual r of each column, near its
            relative error in the norm of the strain energy.

    Raises:
        ConvergenceError: if that is not met.
    """
    x = np.empty_like(forces, order="F")
    for group in groups(forces.shape[1]):
        x[:, group] = _iterated(pencil, precondition, forces[:, group], tolerance)
    return x


def _iterated(pencil: Pencil, precondition: Product, forces: Array, tolerance: float) -> Array:
    x, residual = np.zeros_like(forces, order="F"), forces.copy(order="F")
    preconditioned = precondition(residual)
    direction = preconditioned
    squared = pencil.products(residual, preconditioned)
    wanted = squared * tolerance**2
    for _ in range(_ITERATIONS):
        if np.all(squared <= wanted):
            return x
        pushed = pencil.stiffness(direction)
        step = _ratio(squared, pencil.products(direction, pushed))
        x += direction * step
        residual -= pushed * step
        preconditioned = precondition(residual)
        before, squared = squared, pencil.products(residual, preconditioned)
        direction = preconditioned + direction * _ratio(squared, before)
    worst = float(np.sqrt(np.max(_ratio(squared, wanted)))) * tolerance
    raise ConvergenceError(
        f"static displacements: relative error {worst:.1e} after {_ITERATIONS} iterations"
    )


def _ratio(above: Array, below: Array) -> Array:
    """Quotients, zero for a column without force."""
    return np.divide(above, below, out=np.zeros_like(above), where=below > 0)
