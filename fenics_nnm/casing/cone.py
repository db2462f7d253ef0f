"""A round casing, cylindrical or conical."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.casing.frame import Frame
from fenics_nnm.casing.surface import refuse

#: A radius of a point that is smaller than this part of the casing's is none.
_ON_AXIS = 1e-12


@dataclass(frozen=True, slots=True)
class Cone:
    """Radius R + k s at the axial coordinate s, with the body inside; k = 0 is a cylinder.

    Attributes:
        frame: Axis, and the point on it where s = 0.
        radius: R in m.
        slope: k, the tangent of the half-angle.
    """

    frame: Frame
    radius: float
    slope: float = 0.0

    def axial_range(self, low: float, high: float, *, tip: float) -> tuple[float, float]:
        """As `RoundSurface.axial_range`."""
        if self.slope == 0:
            return low, high
        largest = self.radius + max(self.slope * low, self.slope * high)
        end = (tip * largest - self.radius) / self.slope
        return (max(low, end), high) if self.slope > 0 else (low, min(high, end))

    def distance(self, points: Array, directions: Array) -> Array:
        """As `Surface.distance`, by the root of a quadratic where the line leaves the casing.

        With p, d the parts of point and direction normal to the axis, d_s the axial component and
        r = R + k s at the point: a t^2 + 2 b t + c = 0,

            a = |d|^2 - k^2 d_s^2,   b = p . d - k r d_s,   c = |p|^2 - r^2,

        whose discriminant b^2 - a c = |r d - k d_s p|^2 - |p x d|^2 is free of cancellation. The
        root with the positive square root leaves; it is written without a difference of numbers
        of the same size.
        """
        s, p = self.frame.split(points - self.frame.origin)
        d_s, d = self.frame.split(directions)
        k, r = self.slope, self.radius + self.slope * s
        a = np.sum(d * d, axis=1) - (k * d_s) ** 2
        b = np.sum(p * d, axis=1) - k * r * d_s
        distance = np.linalg.norm(p, axis=1)
        c = (distance - r) * (distance + r)
        stretched = np.linalg.norm(r[:, None] * d - (k * d_s)[:, None] * p, axis=1)
        turned = np.linalg.norm(np.cross(p, d), axis=1)
        discriminant = (stretched - turned) * (stretched + turned)
        root = np.sqrt(np.maximum(discriminant, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(b > 0, -c / (b + root), (root - b) / a)
            met = (discriminant > 0) & np.isfinite(t) & (r + k * d_s * t > 0)
        refuse(~met, points, "does not meet the casing along its contact direction")
        return np.asarray(t)

    def outward(self, points: Array) -> Array:
        """As `Surface.outward`."""
        _, p = self.frame.split(points - self.frame.origin)
        distance = np.linalg.norm(p, axis=1)
        refuse(
            distance <= _ON_AXIS * self.radius,
            points,
            "lies on the axis, as near to all of the casing",
        )
        normal = p / distance[:, None] - self.slope * self.frame.unit
        return np.asarray(normal / np.sqrt(1 + self.slope**2))
