"""Modes of a body whose contact interface is held, by a low-rank change of the free solve."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.block_lanczos import BlockLanczos
from fenics_nnm.fem.factored import Factored


class _Held:
    """K^-1 and M with the interface held, as `block_lanczos.Inverse`.

    With F the interface forces and X = K^-1 F,

        y = K^-1 b - X (F^T X)^-1 F^T K^-1 b

    is the displacement under b that keeps F^T y = 0.
    """

    def __init__(self, free: Factored, forces: Array, attachments: Array) -> None:
        self._free, self._forces, self._attachments = free, forces, attachments
        self.mass, self.inner, self.random = free.mass, free.inner, free.random
        flexibility = free.inner(forces, attachments)
        self._stiffness = np.linalg.inv((flexibility + flexibility.T) / 2)

    def solve(self, forces: Array) -> Array:
        """Displacements under columns of forces."""
        moved = self._free.solve(forces)
        moved -= self._attachments @ (self._stiffness @ self._free.inner(self._forces, moved))
        return moved


def fixed_interface_modes(
    inverse: Factored, free: int, forces: Array, attachments: Array, count: int
) -> Array:
    """The lowest modes of the body with its contact interface held.

    Args:
        inverse: Factorised body, interface free.
        free: Number of its free degrees of freedom, of all ranks.
        forces: Unit forces of the interface, shape (n_owned, i).
        attachments: Displacements under them, shape (n_owned, i).
        count: Number of modes.

    Returns:
        Mass-normalised shapes, shape (n_owned, count).

    Raises:
        ConvergenceError: if the eigensolver fails.
    """
    system, factors = inverse.system, inverse.inverse
    pushed, moved = system.forces(forces), system.independent(attachments)
    held = _Held(inverse, factors.in_order(pushed), factors.in_order(moved))
    lanczos = BlockLanczos(held, inverse.rows, free - forces.shape[1], count, 0)
    lanczos.run()
    return system.whole(factors.restored(lanczos.shapes(count)))
