"""Where an obstacle lies as seen from the points of a body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError


@dataclass(frozen=True, slots=True)
class Direction:
    """Where the obstacle lies as seen from a contact point.

    Attributes:
        kind: "normal" (outward normal of the body), "radial" (away from an axis) or "vector".
        vector: Direction of the axis, or the direction itself; empty for "normal", and for an
            axis normal to the plane of a 2-D body.
        origin: A point on the axis in m.
        key: Place of the patch in the study file, for messages.
    """

    kind: str
    vector: tuple[float, ...] = ()
    origin: tuple[float, ...] = ()
    key: str = "contact"

    def at(self, points: Array, normals: Array) -> Array:
        """Unit vectors at points of shape (n, dim) with outward normals of the same shape.

        Raises:
            ModelError: if a direction has no length there.
        """
        if self.kind == "normal":
            found = normals
        elif self.kind == "radial":
            found = self._from_axis(points)
        else:
            found = np.broadcast_to(np.asarray(self.vector), points.shape)
        length = np.linalg.norm(found, axis=1)
        if len(length) and length.min() <= 1e-12 * max(1.0, float(length.max())):
            where = points[int(np.argmin(length))]
            place = ", ".join(f"{x:.6g}" for x in where)
            raise ModelError(
                f'{self.key}.direction = "{self.kind}": is not defined at ({place}) m: must not '
                "meet the axis"
            )
        return np.asarray(found / length[:, None])

    def distance(self, points: Array) -> Array:
        """Distance in m of points (n, dim) from the axis of a radial direction."""
        return np.asarray(np.linalg.norm(self._from_axis(points), axis=1))

    def _from_axis(self, points: Array) -> Array:
        found = points - np.asarray(self.origin)
        if self.vector:
            axis = np.asarray(self.vector) / np.linalg.norm(self.vector)
            found = found - np.outer(found @ axis, axis)
        return found
