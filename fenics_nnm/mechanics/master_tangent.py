"""Derivatives of harmonics of forces that masters make, or that act on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices


@dataclass(frozen=True, slots=True)
class MasterTangent:
    """A derivative of harmonics by harmonics that is zero but in columns and rows of k masters.

    Attributes:
        masters: Places of the masters among the J coordinates, shape (k,).
        columns: Derivatives by the masters, rows by (n, j), shape (c J, c k).
        rows: What the other coordinates add on the masters, shape (c k, c J); their columns of
            masters add to `columns`.
    """

    masters: Indices
    columns: Array
    rows: Array

    @classmethod
    def between(cls, masters: Indices, modes: int, own: Array) -> MasterTangent:
        """One that is zero but among masters, shape (c, k, c, k), of so many coordinates."""
        c, k = own.shape[:2]
        columns = np.zeros((c, modes, c, k))
        columns[:, masters] = own
        return cls(masters, columns.reshape(c * modes, c * k), np.zeros((c * k, c * modes)))

    def plus(self, other: MasterTangent) -> MasterTangent:
        """The sum of both."""
        return MasterTangent(self.masters, self.columns + other.columns, self.rows + other.rows)

    @property
    def whole(self) -> Array:
        """The whole matrix, shape (c J, c J)."""
        k = len(self.masters)
        c = self.columns.shape[1] // k
        modes = len(self.columns) // c
        whole = np.zeros((c, modes, c, modes))
        whole[:, :, :, self.masters] = self.columns.reshape(c, modes, c, k)
        whole[:, self.masters] += self.rows.reshape(c, k, c, modes)
        return whole.reshape(c * modes, c * modes)

    def times(self, q: Array) -> Array:
        """Its product with coefficients of shape (.., c, J)."""
        masters, rows = q[:, :, self.masters], len(q)
        found = (masters.reshape(rows, -1) @ self.columns.T).reshape(q.shape)
        found[:, :, self.masters] += (q.reshape(rows, -1) @ self.rows.T).reshape(masters.shape)
        return found
