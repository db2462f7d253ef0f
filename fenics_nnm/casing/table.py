"""A measured casing: radii on a grid of angles and axial stations, from a CSV file.

A table has the columns theta_deg or theta_rad, x_<unit> and r_<unit> with <unit> one of m, cm, mm,
um, in, ft, mil, and one row for each pair of an angle and a station: the angles of one whole turn,
the last one before the first comes again, and at least two stations. Lines that start with `#` are
comments.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import NdBSpline, make_interp_spline

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.csv_table import read_table
from fenics_nnm.geometry.lengths import METRES

#: Fewest angles of a table, and the widest angle between two of them in radians.
_FEWEST, _WIDEST = 4, 2 * np.pi / 3 + 1e-9

#: Angles in radians that are nearer than this are the same.
_SAME = 1e-9

#: Angles of one turn, written from any angle on, spread over less than this, in radians.
_MOST_SPREAD = 4 * np.pi

_ANGLES = {"theta_deg": math.pi / 180, "theta_rad": 1.0}


@dataclass(frozen=True, slots=True)
class RadiusTable:
    """A spline through measured radii, twice differentiable.

    Cubic and periodic in the angle; along the axis cubic with four stations or more (not-a-knot
    ends), else of the highest degree that they determine.

    Attributes:
        spline: r over angle and axial coordinate.
        first: First angle in radians.
        span: First and last station in m.
        bounds: Radii in m that the spline stays between.
    """

    spline: NdBSpline
    first: float
    span: tuple[float, float]
    bounds: tuple[float, float]

    @property
    def angles(self) -> int:
        """Number of angles of the table."""
        return int(self.spline.c.shape[0]) - 3  # of a periodic cubic spline

    @classmethod
    def of(cls, theta: Array, x: Array, r: Array) -> RadiusTable:
        """Interpolate.

        Args:
            theta: Angles in radians of one turn, ascending, shape (n,).
            x: Stations in m, ascending, shape (m,), at least two.
            r: Radii in m, shape (n, m).
        """
        turn = np.append(theta, theta[0] + 2 * np.pi)
        around = make_interp_spline(turn, np.vstack([r, r[:1]]), k=3, bc_type="periodic")
        degree = min(3, len(x) - 1)
        along = make_interp_spline(x, around.c.T, k=degree)
        coefficients = along.c.T
        spline = NdBSpline((around.t, along.t), coefficients, (3, degree))
        bounds = float(coefficients.min()), float(coefficients.max())  # B-splines add up to one
        return cls(spline, float(theta[0]), (float(x[0]), float(x[-1])), bounds)

    def grown(self, growth: float) -> RadiusTable:
        """The same with all radii larger by a growth in m, as B-splines add up to one."""
        if not growth:
            return self
        old = self.spline
        spline = NdBSpline(old.t, old.c + growth, old.k)
        low, high = self.bounds
        return replace(self, spline=spline, bounds=(low + growth, high + growth))

    def __call__(self, theta: Array, s: Array) -> tuple[Array, Array, Array]:
        """As `Radius`."""
        at = np.column_stack([self.first + np.mod(theta - self.first, 2 * np.pi), s])
        r, around, along = (self.spline(at, nu=nu) for nu in ((0, 0), (1, 0), (0, 1)))
        return r, around, along


def read_radii(file: Path) -> RadiusTable:
    """Read a table of radii.

    Raises:
        GeometryError: A line that names the file, what is wrong, and what would be right.
    """
    table = read_table(file, "file")
    angle = table.column(*_ANGLES)
    x, r = (table.column_with_unit(name) for name in "xr")
    scale = [_ANGLES[angle], *(METRES[name.split("_")[1]] for name in (x, r))]
    rows = [[row.number(angle), row.number(x), row.number(r, positive=True)] for row in table.rows]
    values = np.array(rows) * scale
    _check_one_turn(file, angle, values[:, 0])
    return RadiusTable.of(*_grid(file, values))


def _check_one_turn(file: Path, column: str, angles: Array) -> None:
    """Refuse degrees that stand in a column of radians: they go around many times."""
    turns = float(np.ptp(angles)) / (2 * np.pi)
    if turns >= _MOST_SPREAD / (2 * np.pi):
        raise GeometryError(
            f"{file}: {column} goes around {turns:.3g} times: must be the angles of one turn: "
            "check degrees and radians"
        )


def _grid(file: Path, values: Array) -> tuple[Array, Array, Array]:
    """Angles, stations and radii on their grid."""
    angles, stations = np.mod(values[:, 0], 2 * np.pi), values[:, 1]
    angles[angles > 2 * np.pi - _SAME] = 0.0
    theta, row = _distinct(angles, _SAME)
    x, column = _distinct(stations, 1e-12 * float(np.abs(stations).max()))
    count = len(theta) * len(x)
    if len(values) != count or len(set(zip(row, column, strict=True))) != count:
        raise GeometryError(
            f"{file}: {len(values)} rows for {len(theta)} angles and {len(x)} stations: must have "
            "each pair once, and no angle again after a whole turn"
        )
    if len(x) < 2:
        raise GeometryError(f"{file}: has one axial station: must have two or more")
    widest = np.diff(np.append(theta, theta[0] + 2 * np.pi)).max()
    if len(theta) < _FEWEST or widest > _WIDEST:
        raise GeometryError(
            f"{file}: {len(theta)} angles with up to {np.degrees(widest):.4g} degrees in between: "
            f"must be {_FEWEST} or more all around, 120 degrees apart at most"
        )
    r = np.empty((len(theta), len(x)))
    r[row, column] = values[:, 2]
    return theta, x, r


def _distinct(values: Array, tolerance: float) -> tuple[Array, Indices]:
    """Ascending values, those within a tolerance as one, and the place of each among them."""
    order = np.argsort(values)
    ranks = np.concatenate([[0], np.cumsum(np.diff(values[order]) > tolerance)])
    place = np.empty(len(values), dtype=np.int64)
    place[order] = ranks
    return values[order][np.unique(ranks, return_index=True)[1]], place
