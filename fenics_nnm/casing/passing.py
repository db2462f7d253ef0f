r"""A casing that stands still while the body turns past it: gaps in harmonics of the speed.

A point of the body at x with the contact direction d is at T x with T d after a turn T about the
axis of rotation. Its gap g is the distance to the casing there, and with the angle Omega t of the
turn

    g(t) = g_0 + Re(sum_m G_m exp(i m Omega t)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.casing.frame import Frame
from fenics_nnm.casing.surface import Surface

#: Places of a turn, over the number of harmonics, at which gaps are measured.
_PLACES = 4

#: Axes that differ in direction by less than this angle in radians are parallel.
_PARALLEL = 1e-6


@dataclass(frozen=True, slots=True)
class Turning:
    """How a body turns.

    Attributes:
        origin: A point on the axis in m, shape (3,).
        axis: Direction of the axis, about which the body turns right-handed, shape (3,).
    """

    origin: Array
    axis: Array

    def turned(self, vectors: Array, angle: float) -> Array:
        """Vectors (n, 3) after a turn by an angle in radians."""
        unit = self.axis / np.linalg.norm(self.axis)
        along = (vectors @ unit)[:, None] * unit
        normal = vectors - along
        return np.asarray(along + np.cos(angle) * normal + np.sin(angle) * np.cross(unit, normal))

    def places(self, points: Array, angle: float) -> Array:
        """Points (n, 3) after a turn by an angle in radians."""
        return self.turned(points - self.origin, angle) + self.origin

    def is_about(self, frame: Frame, near: float) -> bool:
        """Whether the axis of a frame is that of the turn, to a distance in m."""
        unit = self.axis / np.linalg.norm(self.axis)
        tilt = np.linalg.norm(np.cross(unit, frame.unit))
        away = np.linalg.norm(np.cross(unit, frame.origin - self.origin))
        return bool(tilt <= _PARALLEL and away <= near)


@dataclass(frozen=True, slots=True)
class Passing:
    """A casing past which a body turns.

    Attributes:
        surface: The casing where it stands.
        turning: How the body turns.
        multiples: Multiples m of the speed that the casing has, a range from its step on; none
            where it turns with the body.
    """

    surface: Surface
    turning: Turning
    multiples: range

    def mean(self, points: Array, directions: Array) -> Array:
        """Mean distances g_0 in m of points along unit vectors, both (n, 3), shape (n,)."""
        return np.asarray(self._harmonics(points, directions)[0].real)

    def amplitudes(self, points: Array, directions: Array) -> Complex:
        """G_m in m of all multiples, shape (m, n).

        Raises:
            GeometryError: if a line does not meet the casing somewhere.
        """
        return 2 * self._harmonics(points, directions)[1:]

    def _harmonics(self, points: Array, directions: Array) -> Complex:
        count = _PLACES * len(self.multiples) + 1
        angles = 2 * np.pi * np.arange(count) / (count * self.multiples.step)
        places = np.concatenate([self.turning.places(points, angle) for angle in angles])
        lines = np.concatenate([self.turning.turned(directions, angle) for angle in angles])
        gaps = self.surface.distance(places, lines).reshape(count, len(points))
        return np.asarray(np.fft.rfft(gaps, axis=0)[: len(self.multiples) + 1] / count)
