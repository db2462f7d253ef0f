"""A plane as obstacle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.casing.surface import refuse

#: A direction with a smaller cosine to the normal does not lead to the plane.
_GRAZING = 1e-9


@dataclass(frozen=True, slots=True)
class Plane:
    """The half-space that `normal` points into is rigid.

    Attributes:
        origin: A point of the plane in m, shape (3,).
        normal: Direction from the body to the obstacle, shape (3,); any length.
    """

    origin: Array
    normal: Array

    def distance(self, points: Array, directions: Array) -> Array:
        """As `Surface.distance`: t = (o - p) . n / (d . n)."""
        unit = self._unit
        cosine = directions @ unit
        refuse(cosine < _GRAZING, points, "does not meet the plane along its contact direction")
        return np.asarray((self.origin - points) @ unit / cosine)

    def outward(self, points: Array) -> Array:
        """As `Surface.outward`."""
        return np.tile(self._unit, (len(points), 1))

    @property
    def _unit(self) -> Array:
        return np.asarray(self.normal / np.linalg.norm(self.normal))
