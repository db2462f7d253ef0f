"""Cylindrical coordinates about an axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array


@dataclass(frozen=True, slots=True)
class Frame:
    """An axis, a point on it, and the direction that angles begin at.

    Attributes:
        origin: Point on the axis in m, where axial coordinates begin, shape (3,).
        axis: Direction of the axis, shape (3,); any length.
        zero: Direction of angle zero, shape (3,); angles turn right-handed about the axis from
            its part that is normal to the axis. None where angles do not matter.
    """

    origin: Array
    axis: Array
    zero: Array | None = None

    @property
    def unit(self) -> Array:
        """Unit vector along the axis."""
        return np.asarray(self.axis / np.linalg.norm(self.axis))

    def split(self, vectors: Array) -> tuple[Array, Array]:
        """Components of vectors (n, 3) along the axis, (n,), and their parts normal to it."""
        along = vectors @ self.unit
        return along, vectors - along[:, None] * self.unit

    def angles(self, normal: Array) -> Array:
        """Angles in radians of vectors (n, 3) normal to the axis."""
        assert self.zero is not None
        first = self.zero - (self.zero @ self.unit) * self.unit
        second = np.cross(self.unit, first)
        return np.asarray(np.arctan2(normal @ second, normal @ first))
