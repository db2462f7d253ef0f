"""A casing whose radius depends on angle and axial coordinate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.interpolate import PchipInterpolator

from fenics_nnm.arrays import Array
from fenics_nnm.casing.cone import Cone
from fenics_nnm.casing.frame import Frame
from fenics_nnm.casing.surface import refuse
from fenics_nnm.errors import GeometryError

#: Places on a line among which the surface is looked for.
_PLACES = 65

#: Steps of the root finder, all of which may halve an interval.
_STEPS = 200

#: The root is found when a step is shorter than this part of the casing's radius.
_ACCURACY = 1e-15

#: The nearest point is found when a step turns the normal by less.
_TURN = 1e-13

_MISSES = "does not meet the casing along its contact direction"


class Radius(Protocol):
    """A radius r(theta, s) of angle and axial coordinate, periodic in the angle."""

    @property
    def bounds(self) -> tuple[float, float]:
        """Radii in m that r stays between."""

    @property
    def span(self) -> tuple[float, float]:
        """Axial coordinates in m between which r is known."""

    def __call__(self, theta: Array, s: Array) -> tuple[Array, Array, Array]:
        """r, dr/dtheta and dr/ds at angles in radians and axial coordinates in the span, (n,)."""


@dataclass(frozen=True, slots=True)
class LobedRadius:
    """r = R(s) + A cos(n (theta - theta_0)).

    Attributes:
        mean: Mean radius R in m, or its value at each station of `stations`.
        lobes: n, the number of lobes.
        amplitude: A in m, the height of a lobe.
        phase: theta_0 in radians, the angle of a largest radius.
        stations: Axial coordinates in m of the mean radii, ascending; empty for one radius. Between
            them R(s) is a monotone cubic (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984)
            300-304), smooth in its first derivative.
    """

    mean: tuple[float, ...]
    lobes: int
    amplitude: float
    phase: float = 0.0
    stations: tuple[float, ...] = ()

    @property
    def bounds(self) -> tuple[float, float]:
        """As `Radius.bounds`."""
        height = abs(self.amplitude)
        return min(self.mean) - height, max(self.mean) + height

    @property
    def span(self) -> tuple[float, float]:
        """As `Radius.span`."""
        return (self.stations[0], self.stations[-1]) if self.stations else (-np.inf, np.inf)

    def __call__(self, theta: Array, s: Array) -> tuple[Array, Array, Array]:
        """As `Radius`."""
        mean, slope = np.full_like(s, self.mean[0]), np.zeros_like(s)
        if self.stations:
            profile = PchipInterpolator(self.stations, self.mean)
            mean, slope = profile(s), profile(s, 1)
        turn = self.lobes * (theta - self.phase)
        around = -self.amplitude * self.lobes * np.sin(turn)
        return mean + self.amplitude * np.cos(turn), around, slope


@dataclass(frozen=True, slots=True)
class RadialSurface:
    """The surface rho = r(theta, s) about an axis, with the body inside.

    Attributes:
        frame: Axis with the direction of angle zero.
        radius: r(theta, s).

    Raises:
        GeometryError: if the radius is not positive everywhere.
    """

    frame: Frame
    radius: Radius

    def __post_init__(self) -> None:
        if self.radius.bounds[0] <= 0:
            raise GeometryError(
                f"the radius falls to {self.radius.bounds[0]:.6g} m: must be positive all around"
            )

    def axial_range(self, low: float, high: float, *, tip: float) -> tuple[float, float]:
        """As `RoundSurface.axial_range`: up to where radii are given."""
        return max(low, self.radius.span[0]), min(high, self.radius.span[1])

    def distance(self, points: Array, directions: Array) -> Array:
        """As `Surface.distance`.

        The line meets the surface between where it leaves the cylinders of the smallest and the
        largest radius. Of the places there where it leaves the casing that next to the point is
        taken, found by Newton's method within an interval of different signs.
        """
        low, high = self._bracketed(points, directions)
        t = (low + high) / 2
        for _ in range(_STEPS):
            value, slope = self._excess(points + t[:, None] * directions, directions)
            low, high = np.where(value <= 0, t, low), np.where(value > 0, t, high)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = t - value / slope
            inside = (newton >= low) & (newton <= high)
            step = np.where(inside, newton, (low + high) / 2) - t
            t = t + step
            if np.all(np.abs(step) <= _ACCURACY * self.radius.bounds[1]):
                break
        self._refuse_outside(points, points + t[:, None] * directions)
        return np.asarray(t)

    def outward(self, points: Array) -> Array:
        """As `Surface.outward`: the normal whose line from the surface leads through the point."""
        cylinder = Cone(self.frame, self.radius.bounds[1])
        normal = cylinder.outward(points)
        for _ in range(_STEPS):
            feet = points + self.distance(points, normal)[:, None] * normal
            renewed = self._normals(feet)
            turn = np.abs(renewed - normal).max(initial=0.0)
            normal = renewed
            if turn < _TURN:
                return normal
        raise GeometryError("the nearest points are not unique: the casing is curved too much")

    def _bracketed(self, points: Array, directions: Array) -> tuple[Array, Array]:
        """Interval of each line in which it leaves the casing, the one next to the point."""
        slack = 1e-9 * self.radius.bounds[1]
        low, high = self.radius.bounds[0] - slack, self.radius.bounds[1] + slack
        last = Cone(self.frame, high).distance(points, directions)
        first = self._leaves(points, directions, low)
        places = first + np.linspace(0, 1, _PLACES)[:, None] * (last - first)
        excess = np.array(
            [self._excess(points + t[:, None] * directions, directions)[0] for t in places]
        )
        leaves = (excess[:-1] <= 0) & (excess[1:] > 0)
        refuse(np.asarray(~leaves.any(axis=0)), points, _MISSES)
        near = np.minimum(np.abs(places[:-1]), np.abs(places[1:]))
        near[(places[:-1] <= 0) & (places[1:] >= 0)] = 0
        chosen = np.argmin(np.where(leaves, near, np.inf), axis=0)
        columns = np.arange(len(points))
        return places[chosen, columns], places[chosen + 1, columns]

    def _leaves(self, points: Array, directions: Array, radius: float) -> Array:
        """Where lines leave a cylinder, or are nearest to its axis if they pass it by."""
        _, p = self.frame.split(points - self.frame.origin)
        _, d = self.frame.split(directions)
        a, b = np.sum(d * d, axis=1), np.sum(p * d, axis=1)
        c = np.sum(p * p, axis=1) - radius**2
        return np.asarray((np.sqrt(np.maximum(b**2 - a * c, 0)) - b) / a)

    def _coordinates(self, points: Array) -> tuple[Array, Array, Array, Array]:
        """Distance from the axis, its unit vector, angle, and axial coordinate in the span."""
        s, p = self.frame.split(points - self.frame.origin)
        rho = np.linalg.norm(p, axis=1)
        return rho, p / rho[:, None], self.frame.angles(p), np.clip(s, *self.radius.span)

    def _gradients(self, points: Array) -> tuple[Array, Array]:
        """Excess rho - r, and its gradient."""
        rho, radial, theta, s = self._coordinates(points)
        r, around, along = self.radius(theta, s)
        around_vector = np.cross(self.frame.unit, radial)
        gradient = radial - (around / rho)[:, None] * around_vector
        return rho - r, gradient - along[:, None] * self.frame.unit

    def _excess(self, points: Array, directions: Array) -> tuple[Array, Array]:
        """Excess rho - r, and its derivative along the directions."""
        value, gradient = self._gradients(points)
        return value, np.sum(gradient * directions, axis=1)

    def _normals(self, points: Array) -> Array:
        _, gradient = self._gradients(points)
        return np.asarray(gradient / np.linalg.norm(gradient, axis=1)[:, None])

    def _refuse_outside(self, points: Array, met: Array) -> None:
        """Refuse lines that meet the surface where its radius is not known."""
        s, _ = self.frame.split(met - self.frame.origin)
        low, high = self.radius.span
        slack = 1e-9 * self.radius.bounds[1]
        refuse(
            (s < low - slack) | (s > high + slack),
            points,
            f"meets the casing beyond the axial coordinates from {low:.6g} to {high:.6g} m that "
            "its radii are given for",
        )
