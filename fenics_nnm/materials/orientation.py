"""Directions of the material axes 1, 2, 3 in a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.errors import ModelError
from fenics_nnm.materials.elasticity import listed

#: Two axes are taken as parallel when the sine of their angle is below this.
_PARALLEL = 1e-6

#: A point is on the axis of cylindrical material axes within this part of the coordinates' size.
_ON_AXIS = 1e-9

Three = tuple[float, float, float]


class Orientation(Protocol):
    """Directions of the material axes at each point of a body."""

    @property
    def turns(self) -> bool:
        """Whether they differ from point to point."""

    @property
    def words(self) -> str:
        """The directions in words."""

    def undefined_at(self, points: Array) -> Mask:
        """Where they are not defined among points in m of shape (n, 3)."""


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
    def turns(self) -> bool:
        """They are the same everywhere."""
        return False

    @property
    def words(self) -> str:
        """The directions in words."""
        rows = [f"({listed(row)})" for row in np.round(self.matrix, 12) + 0.0]
        return f"axes 1, 2, 3 along {', '.join(rows)}"

    def undefined_at(self, points: Array) -> Mask:
        """Nowhere."""
        return np.zeros(len(points), dtype=bool)

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
    def turns(self) -> bool:
        """They follow the angle about the axis."""
        return True

    @property
    def words(self) -> str:
        """The directions in words."""
        return (
            f"axes 1, 2, 3 radial, circumferential, along ({listed(self.axis)}) through "
            f"({listed(self.origin)}) m"
        )

    def undefined_at(self, points: Array) -> Mask:
        """On the axis, where no direction is radial."""
        away = points - np.array(self.origin)
        away -= np.outer(away @ self.unit, self.unit)
        size = np.abs(points).max(initial=0.0)
        return np.asarray(np.linalg.norm(away, axis=1) <= _ON_AXIS * size)

    @property
    def unit(self) -> Array:
        """Unit vector of the axis, shape (3,)."""
        return np.asarray(np.array(self.axis) / np.linalg.norm(self.axis))


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
