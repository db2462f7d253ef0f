"""A fillet as part of the sections of a blade: a collar that widens towards the hub.

At the height h above the hub, measured along the radius, an airfoil with a fillet of radius rho is
wider by d on all sides, with the angle phi of the arc from the hub's tangent:

    h = rho (1 - cos phi),    d = rho (1 - sin phi)

Where airfoil and hub are perpendicular this is the circular arc that touches both. The last
`_FOOT` of the angle, which would meet the hub at no angle, is replaced by its tangent: 0.4 % of the
cross-section of the fillet is lost.
"""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import PchipInterpolator, make_interp_spline

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.section_lines import SectionLines, cartesian
from fenics_nnm.geometry.walls import Wall

_FOOT = np.radians(15)
_ANGLES = np.radians([15, 22, 30, 40, 50, 60, 70, 80, 90])
_BELOW = 0.06  # of the radius: continuation of the foot inside the hub
_ABOVE = (1.12, 1.3, 1.6, 2.1)  # heights over the radius, so that the blade above stays as it was
_CLEAR = 3.0  # sections below this height over the radius are replaced
_STEPS = 60  # of the search for a height along the span


def widened(lines: Sequence[SectionLines], hub: Wall, radius: float) -> list[SectionLines]:
    """Sections of a blade with a fillet at the hub.

    Args:
        lines: Sections from inside the hub outwards.
        hub: The hub.
        radius: Radius of the fillet.

    Raises:
        GeometryError: The blade is too short for it.
    """
    above = [line for line in lines if _heights(line.sides, hub).min() > _CLEAR * radius]
    if len(above) < 2:
        raise GeometryError(
            f"mesh.block.fillet = {radius:g}: is too large for the blade: must leave two of its "
            f"sections more than {_CLEAR:g} times as high above the hub"
        )
    levels = [(-_BELOW, _offset(-_BELOW))]
    levels += [(1 - np.cos(phi), 1 - np.sin(phi)) for phi in _ANGLES]
    levels += [(height, 0.0) for height in _ABOVE]
    collar = [section_at(lines, hub, h * radius, d * radius) for h, d in levels]
    return [*collar, *above]


def _offset(height: float) -> float:
    """Offset of the straight foot at a height, both over the radius."""
    slope = np.cos(_FOOT) / np.sin(_FOOT)
    return float(1 - np.sin(_FOOT) + slope * (1 - np.cos(_FOOT) - height))


def _heights(points: np.ndarray, hub: Wall) -> np.ndarray:
    return np.hypot(points[..., 1], points[..., 2]) - hub.at(points[..., 0])


def section_at(
    lines: Sequence[SectionLines], hub: Wall, height: float, offset: float
) -> SectionLines:
    """The section at a height above the hub, wider by `offset` on all sides."""
    sides = _at_height(lines, hub, height)
    if offset == 0.0:
        return SectionLines(lines[0].parameter, sides)
    axial, theta = sides[..., 0], np.arctan2(sides[..., 1], sides[..., 2])
    radius = hub.at(axial) + height
    along = np.stack([np.gradient(c, lines[0].parameter, axis=1) for c in (axial, theta)])
    slope = np.sqrt(1 + hub.slope_at(axial) ** 2)
    # unit vectors of the wall: along the meridian, around the axis
    tangent = np.stack([along[0] * slope, radius * along[1]])
    tangent /= np.linalg.norm(tangent, axis=0)
    normal = np.stack([-tangent[1], tangent[0]])  # towards larger theta where x rises
    normal *= np.array([1.0, -1.0])[:, None] * np.sign(tangent[0].mean())
    moved = _moved((axial, theta), normal * offset, slope, radius)
    across = np.stack([slope * (axial - axial[::-1]), radius * (theta - theta[::-1])])
    across /= np.linalg.norm(across, axis=0)
    ends = [
        _moved(
            (axial[:, i], theta[:, i]),
            (normal[:, :, i] + _mitre(way * tangent[:, :, i], across[:, :, i])) * offset,
            slope[:, i],
            radius[:, i],
        )
        for i, way in ((0, -1.0), (-1, 1.0))
    ]
    points = np.concatenate([ends[0][:, :, None], moved, ends[1][:, :, None]], axis=2)
    return _resampled(points, lines[0].parameter, hub, height)


def _mitre(outwards: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Lengthening of a side, for a unit offset, up to the corner with the edge's offset.

    Args:
        outwards: Unit tangents of the two sides away from the airfoil, shape (2, sides).
        across: Unit vectors along the edge towards each side, shape (2, sides).
    """
    cosine = -(outwards * across).sum(axis=0)  # of the angle that the outline turns by
    return np.asarray(outwards * np.sqrt((1 - cosine) / (1 + cosine)))


def _moved(
    place: tuple[np.ndarray, np.ndarray], step: np.ndarray, slope: np.ndarray, radius: np.ndarray
) -> np.ndarray:
    """Axial coordinate and angle of points moved along the wall, stacked first."""
    return np.stack([place[0] + step[0] / slope, place[1] + step[1] / radius])


def _resampled(points: np.ndarray, parameter: np.ndarray, hub: Wall, height: float) -> SectionLines:
    """Sides through points (x, theta), shape (2, sides, n), at the parameter of all sections."""
    sides = []
    for axial, theta in np.moveaxis(points, 1, 0):
        radius = hub.at(axial) + height
        steps = np.linalg.norm(np.diff(cartesian(axial, radius, theta), axis=0), axis=1)
        length = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
        line = PchipInterpolator(length, np.column_stack([axial, theta]))(parameter)
        sides.append(cartesian(line[:, 0], hub.at(line[:, 0]) + height, line[:, 1]))
    return SectionLines(parameter, np.stack(sides))


def _at_height(lines: Sequence[SectionLines], hub: Wall, height: float) -> np.ndarray:
    """Where the spanwise lines through all stations have a height, shape (2, n, 3)."""
    points = np.stack([line.sides for line in lines])
    span = np.hypot(points[..., 1], points[..., 2]).mean(axis=(1, 2))
    along = make_interp_spline(span, points, k=min(3, len(lines) - 1))
    station = np.indices(points.shape[1:3])

    def at(places: np.ndarray) -> np.ndarray:
        """Points at one place along the span for each station."""
        values = along(places.ravel()).reshape(*places.shape, *points.shape[1:])
        side, number = station
        return np.asarray(values[side, number, side, number])

    low = np.full(points.shape[1:3], span[0])
    high = np.full(points.shape[1:3], span[-1])
    for _ in range(_STEPS):
        middle = (low + high) / 2
        inside = _heights(at(middle), hub) < height
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return at((low + high) / 2)
