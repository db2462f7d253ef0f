"""The part of a casing about a contact patch, as it is drawn before a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from fenics_nnm.arrays import Array, Indices, in_space
from fenics_nnm.casing import Cone, Plane, RadialSurface, Reversed, RoundSurface, Surface
from fenics_nnm.output.pictures.scene import Faces, Layer, Lines

#: Colour of a casing, how much of it hides what is behind it, and how it is seen on white.
CASING, _OPACITY, CASING_TINT = "#8a5a44", 0.3, "#dccdc7"

#: A sheet is larger than its patch by this part of the patch's size on each side, which counts as
#: this part of the body's size at least.
_MARGIN, _LEAST = 0.25, 0.2

#: Intervals of a sheet along each of its coordinates, and of a whole turn.
_ALONG, _TURN = 12, 72

#: Patches that leave less than this part of a turn free have a casing all around, in radians.
_FREE = np.pi / 3

#: A cone is drawn up to where its radius is this part of the largest at its patch.
_TIP = 0.02


def casing_layers(surface: Surface, points: Array, size: float, dim: int) -> list[Layer]:
    """A translucent sheet of a casing about contact points, or its line in the plane of a body.

    Args:
        surface: The casing.
        points: Contact points of one patch in m, shape (n, dim).
        size: Size of the body in m.
        dim: Dimension of the body; in the plane a round casing has the axis z.

    Raises:
        GeometryError: if the casing is not met about the points.
    """
    return _layers(sheet_grid(surface, points, size, dim))


def sheet_grid(surface: Surface, points: Array, size: float, dim: int) -> Array:
    """Places (a, b, 3) of a sheet of a casing about points, as of `casing_layers`.

    In the plane of a body it is one row of them.

    Raises:
        GeometryError: if the casing is not met about the points.
    """
    return _sheet(surface, in_space(points), _LEAST * size, dim)


def cells_of(grid: Array) -> Indices:
    """Numbers of the places of each quadrangle of a grid, or of each line of one row, (f, 2 or 4).

    Args:
        grid: Places, shape (a, b, 3).
    """
    number = np.arange(grid.shape[0] * grid.shape[1]).reshape(grid.shape[:2])
    if len(grid) == 1:
        return np.stack([number[0, :-1], number[0, 1:]], axis=1)
    corners = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    return np.stack([corner.ravel() for corner in corners], axis=1)


def _sheet(surface: Surface, points: Array, least: float, dim: int) -> Array:
    """Places (a, b, 3) of a casing about points; one row of them in the plane."""
    return _SHEET_OF[type(surface)](surface, points, least, dim)


def _of_reversed(surface: Reversed, points: Array, least: float, dim: int) -> Array:
    return _sheet(surface.surface, points, least, dim)


def _layers(grid: Array) -> list[Layer]:
    """A sheet of places (a, b, 3) with its edge, or the line of places (1, b, 3)."""
    rim = [grid[0], grid[:, -1], grid[-1, ::-1], grid[::-1, 0]] if len(grid) > 1 else [grid[0]]
    around = np.concatenate(rim)
    edge = Lines(np.stack([around[:-1], around[1:]], axis=1), CASING, 1.5 if len(grid) > 1 else 3.0)
    if len(grid) == 1:
        return [edge]
    return [Faces(grid.reshape(-1, 3), cells_of(grid), CASING, opacity=_OPACITY), edge]


def _widened(values: Array, least: float) -> tuple[float, float]:
    """Ends of values with a margin, which count as `least` wide at least."""
    margin = _MARGIN * max(float(np.ptp(values)), least)
    return float(values.min()) - margin, float(values.max()) + margin


def _of_plane(plane: Plane, points: Array, least: float, dim: int) -> Array:
    """Places of the plane about the feet of points."""
    unit = plane.normal / np.linalg.norm(plane.normal)
    feet = points + ((plane.origin - points) @ unit)[:, None] * unit
    if dim < 3:
        along = np.array([[-unit[1], unit[0], 0.0]])
    else:
        along = _square_to(unit, points - points.mean(axis=0))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    middle = feet.mean(axis=0)
    ends = [_widened((feet - middle) @ each, least) for each in along]
    steps = [np.linspace(*each, _ALONG + 1) for each in ends]
    if dim < 3:
        return np.asarray(middle + steps[0][None, :, None] * along[0])
    return np.asarray(middle + steps[0][:, None, None] * along[0] + steps[1][:, None] * along[1])


def _square_to(unit: Array, spread: Array) -> Array:
    """Two unit vectors square to another and to each other, along the spread of points."""
    flat = spread - (spread @ unit)[:, None] * unit
    _, sizes, directions = np.linalg.svd(np.vstack([flat, np.zeros((3, 3))]))
    first = directions[0] if sizes[0] > 0 else np.eye(3)[int(np.argmin(np.abs(unit)))]
    first = first - (first @ unit) * unit
    return np.array([first / np.linalg.norm(first), np.cross(unit, first / np.linalg.norm(first))])


def _of_round(casing: RoundSurface, points: Array, least: float, dim: int) -> Array:
    """Places of a round casing about points: where rays from its axis meet it."""
    frame = casing.frame
    s, p = frame.split(points - frame.origin)
    radial = p / np.maximum(np.linalg.norm(p, axis=1, keepdims=True), np.finfo(float).tiny)
    turns = _turns(frame.unit, radial, least / float(np.linalg.norm(p, axis=1).max()))
    if dim < 3:
        return _met(casing, -frame.origin[2:] * frame.unit[2], turns)
    low, high = casing.axial_range(*_widened(s, least), tip=_TIP)
    return _met(casing, np.linspace(low, high, _ALONG + 1), turns)


def _turns(unit: Array, radial: Array, least: float) -> Array:
    """Unit vectors square to an axis, over the angles of others and a margin."""
    first = radial[0]
    second = np.cross(unit, first)
    angles = np.sort(np.arctan2(radial @ second, radial @ first))
    free = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    after = int(np.argmax(free))
    start, end = angles[(after + 1) % len(angles)], angles[after]
    end += 2 * np.pi if end < start else 0.0
    margin = _MARGIN * max(end - start, least)
    if free[after] < max(_FREE, 2 * margin):
        start, end, margin = -np.pi, np.pi, 0.0
    count = int(np.ceil((end - start + 2 * margin) / (2 * np.pi) * _TURN)) + 1
    theta = np.linspace(start - margin, end + margin, max(count, _ALONG + 1))[:, None]
    return np.asarray(np.cos(theta) * first + np.sin(theta) * second)


def _met(casing: RoundSurface, s: Array, turns: Array) -> Array:
    """Places where rays from the axis at s (a,) along unit vectors (b, 3) meet it, (a, b, 3)."""
    rays = np.tile(turns, (len(s), 1))
    starts = casing.frame.origin + np.repeat(s, len(turns))[:, None] * casing.frame.unit
    met = starts + casing.distance(starts, rays)[:, None] * rays
    return np.asarray(met.reshape(len(s), len(turns), 3))


_SHEET_OF: Mapping[type, Callable[..., Array]] = {
    Reversed: _of_reversed,
    Plane: _of_plane,
    Cone: _of_round,
    RadialSurface: _of_round,
}
