"""Walls of a flow passage: surfaces of revolution about the machine axis, as lines r(x)."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Self

import numpy as np
from pydantic import Field
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.csv_table import CsvTable, read_table
from fenics_nnm.geometry.lengths import METRES
from fenics_nnm.geometry.parameters import Coordinate, GmshModel, Length

WallLine = Path | Annotated[tuple[tuple[Coordinate, Length], ...], Field(min_length=2)]
"""Points (x, r) of a wall, or the table that has them."""

_STRAIGHT = 1e-9  # deviation from a straight line over its length
_CASING = ("casing", "shroud")  # words of a table for the outer wall


@dataclass(frozen=True, slots=True)
class Wall:
    """Line r(x) in cubic pieces with continuous slope, and straight beyond its ends.

    Attributes:
        axial: Rising coordinates x along the machine axis, shape (n,).
        radius: Distance from the axis there, shape (n,), same unit.
        slope: dr/dx there, shape (n,).
    """

    axial: np.ndarray
    radius: np.ndarray
    slope: np.ndarray

    @classmethod
    def through(cls, axial: np.ndarray, radius: np.ndarray) -> Self:
        """Monotone cubic pieces through given points (a straight line through two)."""
        line = PchipInterpolator(axial, radius)
        return cls(axial, radius, line(axial, 1))

    def at(self, axial: np.ndarray) -> np.ndarray:
        """Radius at coordinates along the axis, same shape."""
        inside = np.clip(axial, self.axial[0], self.axial[-1])
        return np.asarray(self._line()(inside) + self.slope_at(axial) * (axial - inside))

    def slope_at(self, axial: np.ndarray) -> np.ndarray:
        """Slope dr/dx at coordinates along the axis, same shape."""
        return np.asarray(self._line()(np.clip(axial, self.axial[0], self.axial[-1]), 1))

    def _line(self) -> CubicHermiteSpline:
        return CubicHermiteSpline(self.axial, self.radius, self.slope)

    def raised(self, height: float) -> "Wall":
        """The same line farther from the axis by `height`."""
        return Wall(self.axial, self.radius + height, self.slope)

    def between(self, first: float, last: float) -> "Wall":
        """The part between two coordinates, beyond the ends of the line too."""
        inner = (self.axial > first) & (self.axial < last)
        axial = np.concatenate([[first], self.axial[inner], [last]])
        return Wall(axial, self.at(axial), self.slope_at(axial))

    def add_curve(self, occ: GmshModel, angle: float) -> tuple[int, int, int]:
        """Add the line in the plane at `angle`; its two end points and the curve."""
        control, knots, multiplicities = self._control()
        tags = [
            occ.addPoint(x, r * np.sin(angle), r * np.cos(angle))
            for x, r in (control if knots else control[[0, -1]])
        ]
        if not knots:
            return tags[0], tags[-1], occ.addLine(tags[0], tags[-1])
        curve = occ.addBSpline(tags, degree=3, knots=knots, multiplicities=multiplicities)
        occ.remove([(0, tag) for tag in tags[1:-1]])
        return tags[0], tags[-1], curve

    def _control(self) -> tuple[np.ndarray, list[float], list[int]]:
        """Control points (x, r) of the cubic with double knots; no knots if it is straight."""
        third = np.diff(self.axial) / 3
        after = np.column_stack(
            [self.axial[:-1] + third, self.radius[:-1] + third * self.slope[:-1]]
        )
        before = np.column_stack([self.axial[1:] - third, self.radius[1:] - third * self.slope[1:]])
        ends = np.column_stack([self.axial, self.radius])[[0, -1]]
        inner = np.stack([after, before], axis=1).reshape(-1, 2)
        control = np.vstack([ends[:1], inner, ends[1:]])
        chord = ends[0, 1] + (ends[1, 1] - ends[0, 1]) * (control[:, 0] - ends[0, 0]) / np.ptp(
            ends[:, 0]
        )
        if np.abs(control[:, 1] - chord).max() < _STRAIGHT * np.ptp(ends[:, 0]):
            return control, [], []
        return control, list(map(float, self.axial)), [4, *[2] * (len(self.axial) - 2), 4]


def wall_of(key: str, given: WallLine, length_unit: str) -> Wall:
    """The wall that a study gives as points (x, r), or as a table with the column `wall`.

    Args:
        key: "hub" or "casing".
        given: Points in `length_unit`, or a CSV file with columns wall, z_<unit>, r_<unit>; rows
            whose wall is "hub", or "casing" or "shroud".
        length_unit: Unit of the line.

    Raises:
        GeometryError: The table is wrong, or x does not rise from point to point.
    """
    if not isinstance(given, Path):
        points = np.array(given, dtype=float)
        if np.any(np.diff(points[:, 0]) <= 0):
            raise GeometryError(f"mesh.{key}: x must rise from point to point")
        return Wall.through(points[:, 0], points[:, 1])
    table = read_table(given, f"mesh.{key}")
    words = _CASING if key == "casing" else (key,)
    points = _points(table, words, length_unit)
    if len(points) < 2:
        wanted = " or ".join(f'"{word}"' for word in words)
        raise GeometryError(f"{given}: {len(points)} rows have wall = {wanted}: must be 2 or more")
    if np.any(np.diff(points[:, 0]) <= 0):
        raise GeometryError(f"{given}: {words[-1]}: column z must rise from row to row")
    return Wall.through(points[:, 0], points[:, 1])


def _points(table: CsvTable, words: tuple[str, ...], length_unit: str) -> np.ndarray:
    """Rows (x, r) of one wall, in `length_unit`."""
    wall = table.column("wall")
    names = [table.column_with_unit(name) for name in "zr"]
    scale = [METRES[name.split("_")[1]] / METRES[length_unit] for name in names]
    rows = [row for row in table.rows if row.text(wall) in words]
    return np.array([[row.number(name) for name in names] for row in rows]).reshape(-1, 2) * scale
