"""Points given in rectangular, cylindrical or spherical coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, radians, sin


def in_rectangular(x: Sequence[float], system: str) -> list[float]:
    """Rectangular coordinates of a point.

    Args:
        x: Coordinates; angles in degrees.
        system: "R", "C" for radius, angle and height, or "S".

    Of "S" the second coordinate is the angle in the x-y plane and the third the one above it, as
    Abaqus has it.
    """
    if system == "R":
        return list(x)
    r, a, b = x[0], radians(x[1]), radians(x[2])
    if system == "C":
        return [r * cos(a), r * sin(a), x[2]]
    return [r * cos(a) * cos(b), r * sin(a) * cos(b), r * sin(b)]
