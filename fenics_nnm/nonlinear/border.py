"""What borders a Jacobian, and the dense solution of the bordered system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array


@dataclass(frozen=True, slots=True)
class Border:
    """Columns and rows that border the Jacobian of the equations, and the right-hand sides.

    Attributes:
        columns: Derivatives of the equations by the b unknowns besides q, shape (b, c, J).
        rows: Derivatives of the b further equations by q, shape (b, c, J).
        corner: Derivatives of these by the further unknowns, shape (b, b).
        right: Right-hand sides of the equations, shape (c, J).
        below: Right-hand sides of the further equations, shape (b,).
    """

    columns: Array
    rows: Array
    corner: Array
    right: Array
    below: Array

    def around(self, jacobian: Array, scale: Array) -> Array:
        """The bordered matrix, q first, whose equations are divided by `scale`, shape of q."""
        size, more = self.right.size, len(self.columns)
        matrix = np.zeros((size + more, size + more))
        by_row = scale.ravel()
        matrix[:size, :size] = jacobian / by_row[:, None]
        matrix[:size, size:] = (self.columns.reshape(more, size) / by_row).T
        matrix[size:, :size] = self.rows.reshape(more, size)
        matrix[size:, size:] = self.corner
        return matrix

    def dense_solution(self, jacobian: Array, scale: Array) -> Array:
        """Solution of the bordered system, q first, shape (c J + b,).

        Args:
            jacobian: Derivative of the equations by q, shape (c J, c J).
            scale: Size of each equation per unit of its coordinate, shape of q.

        Raises:
            numpy.linalg.LinAlgError: if the system is singular.
        """
        right = np.concatenate([(self.right / scale).ravel(), self.below])
        return np.linalg.solve(self.around(jacobian, scale), right)
