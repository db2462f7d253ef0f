"""Directions of the material axes 1, 2, 3 in a body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError

#: Two axes are taken as parallel when the sine of their angle is below this.
_PARALLEL = 1e-6

Three = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Axes:
    """The same material axes everywhere.

    Attributes:
        first: Direction of axis 1.
        second: Axis 2 is the part of this vector that is normal to axis 1; axis 3 completes a
            right-handed system.
    """

    first: Three = (1.0, 0.0, 0.0)
    second: Three = (0.0, 1.0, 0.0)

    def __post_init__(self) -> None:
        a, b = np.array(self.first), np.array(self.second)
        sine = np.linalg.norm(np.cross(a, b)) / max(
            float(np.linalg.norm(a) * np.linalg.norm(b)), np.finfo(float).tiny
        )
        if sine < _PARALLEL:
            raise ModelError(
                f"axes = [{list(self.first)}, {list(self.second)}]: must be two vectors that are "
                "neither zero nor parallel"
            )

    @property
    def matrix(self) -> Array:
        """Orthonormal axes as rows, shape (3, 3)."""
        first = np.array(self.first) / np.linalg.norm(self.first)
        third = np.cross(first, self.second)
        third /= np.linalg.norm(third)
        return np.array([first, np.cross(third, first), third])


@dataclass(frozen=True, slots=True)
class Cylindrical:
    """Material axes that turn about an axis: 1 radial, 2 circumferential, 3 along it.

    Attributes:
        axis: Direction of the axis.
        origin: A point on it in m.
    """

    axis: Three
    origin: Three = (0.0, 0.0, 0.0)

    @property
    def unit(self) -> Array:
        """Unit vector of the axis, shape (3,)."""
        return np.asarray(np.array(self.axis) / np.linalg.norm(self.axis))


Orientation = Axes | Cylindrical


#: Material axes along x, y and z.
XYZ = Axes()


def euler_axes(degrees: Three) -> Axes:
    """Axes turned from x, y, z by Euler angles in degrees.

    First about z, then about the new x, then about the new z (z-x'-z'', Bunge).
    """
    turns = [_turn(angle, axis) for angle, axis in zip(np.radians(degrees), (2, 0, 2), strict=True)]
    columns = turns[0] @ turns[1] @ turns[2]
    first, second = (tuple(float(x) for x in columns[:, i]) for i in (0, 1))
    return Axes((first[0], first[1], first[2]), (second[0], second[1], second[2]))


def _turn(angle: float, axis: int) -> Array:
    """Rotation about a coordinate axis; its columns are the turned axes."""
    matrix = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i, i] = matrix[j, j] = np.cos(angle)
    matrix[i, j], matrix[j, i] = -np.sin(angle), np.sin(angle)
    return matrix
