"""Which places of a surface a viewer sees, and which are behind other parts of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from fenics_nnm.arrays import Array

#: A face hides a place from this distance on, as a part of the size of the surface.
_BEHIND = 1e-3


@dataclass(frozen=True, slots=True)
class Sight:
    """A surface as a viewer far away sees it.

    Attributes:
        first: First corners of its triangles in the picture plane, m, shape (t, 2).
        inverse: Give the weights of second and third corner of a place in it, shape (t, 2, 2).
        depths: Of the three corners, towards the viewer, m, shape (t, 3).
        frame: Right, up and towards the viewer, shape (3, 3).
    """

    first: Array
    inverse: Array
    depths: Array
    frame: Array

    @classmethod
    def of(cls, faces: Array, frame: Array) -> Self:
        """The sight of triangles or quadrangles, shape (f, 3 or 4, 3), outwards."""
        parts = [faces[:, [0, k, k + 1]] for k in range(1, faces.shape[1] - 1)]
        seen = np.concatenate(parts) @ frame.T
        sides = np.stack([seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0]], axis=2)[:, :2]
        areas = np.linalg.det(sides)
        facing = areas > 1e-9 * areas.max(initial=0.0)
        seen, sides = seen[facing], sides[facing]
        return cls(seen[:, 0, :2], np.linalg.inv(sides), seen[:, :, 2], frame)

    def hides(self, place: Array) -> bool:
        """Whether a face lies between the viewer and a place in m, shape (3,)."""
        *flat, depth = self.frame @ place
        second, third = np.einsum("tij,tj->it", self.inverse, flat - self.first)
        within = (second >= 0) & (third >= 0) & (second + third <= 1)
        weights = np.stack([1 - second - third, second, third], axis=1)[within]
        over = np.sum(weights * self.depths[within], axis=1)
        return any(over > depth + _BEHIND * np.ptp(self.first)) if len(over) else False
