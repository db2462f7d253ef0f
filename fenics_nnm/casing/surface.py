"""What a contact point asks of the surface of a rigid casing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.casing.frame import Frame
from fenics_nnm.errors import GeometryError


class Surface(Protocol):
    """A rigid surface with the body on one side of it.

    Points and directions have three components, also for bodies of fewer dimensions.
    """

    def distance(self, points: Array, directions: Array) -> Array:
        """Distances in m from points to the surface along unit vectors, both of shape (n, 3).

        A point that is beyond the surface has a negative distance.

        Raises:
            GeometryError: if a line does not meet the surface.
        """

    def outward(self, points: Array) -> Array:
        """Unit normals of the surface at the points nearest to `points`, out of the body's side.

        Raises:
            GeometryError: if there is no single nearest point.
        """


class RoundSurface(Surface, Protocol):
    """A surface about an axis."""

    @property
    def frame(self) -> Frame:
        """Its axis, and where angles and axial coordinates begin."""

    def axial_range(self, low: float, high: float, *, tip: float) -> tuple[float, float]:
        """The part of a range of axial coordinates in m in which the surface has a radius.

        Args:
            low: First axial coordinate.
            high: Last axial coordinate.
            tip: A surface that ends at a point is left there, where its radius is this part of
                the largest in the range.
        """


@dataclass(frozen=True, slots=True)
class Reversed:
    """The same surface with the body on its other side: a shaft in place of a casing.

    Attributes:
        surface: Surface that has the body inside.
    """

    surface: Surface

    def distance(self, points: Array, directions: Array) -> Array:
        """As `Surface.distance`."""
        return -self.surface.distance(points, -directions)

    def outward(self, points: Array) -> Array:
        """As `Surface.outward`."""
        return -self.surface.outward(points)


def refuse(wrong: Mask, points: Array, reason: str) -> None:
    """Raise an error that names the first point where something is wrong.

    Raises:
        GeometryError: if `wrong`, of shape (n,), holds anywhere.
    """
    if np.any(wrong):
        place = ", ".join(f"{x:.6g}" for x in points[int(np.argmax(wrong))])
        raise GeometryError(f"the point at ({place}) m {reason}")
