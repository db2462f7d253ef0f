"""Temperatures that change from place to place: by a table of points, or linear.

A table has one to three of the columns x_<unit>, y_<unit>, z_<unit> with <unit> one of m, cm, mm,
um, in, ft, mil: those that the temperature depends on; and T_K or T_C. Lines that start with `#`
are comments.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import GeometryError
from fenics_nnm.files.stamp import stamp_of
from fenics_nnm.geometry.csv_table import CsvTable, Row, read_table, with_units
from fenics_nnm.geometry.lengths import METRES
from fenics_nnm.geometry.scattered import ScatteredValues

#: Absolute temperature of the zero of each unit.
_ZEROS = {"T_K": 0.0, "T_C": 273.15}

#: Solids have temperatures in K below this one; a table has at most so many points.
HOTTEST, MOST_POINTS = 1e4, 100_000

#: Places this part of the extent of a table outside of it are taken as its edge.
_OUTSIDE = 0.01


class Temperatures(Protocol):
    """Temperature at each place of a body."""

    @property
    def words(self) -> str:
        """What it is given by."""

    @property
    def allowed(self) -> float:
        """How far places may lie outside of where it is given, in m."""

    @property
    def extent(self) -> float:
        """Largest extent of where it is given in m; 0 for anywhere."""

    @property
    def needs(self) -> int:
        """Number of dimensions that a body must have."""

    def at(self, places: Array) -> tuple[Array, Array]:
        """Temperatures in K at places (m, 3), and how far outside these lie in m, each (m,)."""


@dataclass(frozen=True, slots=True)
class LinearTemperatures:
    """A temperature that is linear in the place.

    Attributes:
        origin: A place in m, shape (3,).
        value: Temperature there in K.
        gradient: In K/m, shape (3,).
    """

    origin: tuple[float, float, float]
    value: float
    gradient: tuple[float, float, float]

    @property
    def words(self) -> str:
        """As `Temperatures`."""
        return f"linear, {float(np.linalg.norm(self.gradient)):.6g} K/m"

    @property
    def allowed(self) -> float:
        """As `Temperatures`."""
        return 0.0

    @property
    def extent(self) -> float:
        """As `Temperatures`."""
        return 0.0

    @property
    def needs(self) -> int:
        """As `Temperatures`."""
        return int(np.flatnonzero(self.gradient)[-1]) + 1

    def at(self, places: Array) -> tuple[Array, Array]:
        """As `Temperatures`."""
        values = self.value + (places - np.array(self.origin)) @ np.array(self.gradient)
        return np.asarray(values), np.zeros(len(places))


@dataclass(frozen=True, slots=True)
class TabulatedTemperatures:
    """Temperatures at points, linear in between.

    Attributes:
        table: Temperatures in K.
        outside: How far places may lie outside of the points in m; 1 % of their extent if None.
    """

    table: ScatteredValues
    outside: float | None = None

    @property
    def words(self) -> str:
        """As `Temperatures`."""
        return f"by a table of {self.table.count} points"

    @property
    def allowed(self) -> float:
        """As `Temperatures`."""
        return _OUTSIDE * self.extent if self.outside is None else self.outside

    @property
    def extent(self) -> float:
        """As `Temperatures`."""
        return self.table.hull.size

    @property
    def needs(self) -> int:
        """As `Temperatures`."""
        return self.table.axes[-1] + 1

    def at(self, places: Array) -> tuple[Array, Array]:
        """As `Temperatures`."""
        return self.table.at(places)


def read_temperatures(file: Path, key: str = "file") -> ScatteredValues:
    """Read a table of temperatures in K; the latest ones are kept.

    Args:
        file: The file.
        key: Key of the study that names it, for messages.

    Raises:
        GeometryError: A line that names the file, what is wrong, and what would be right.
    """
    try:
        stamp = stamp_of(file)
    except OSError as error:
        raise GeometryError(f"{key} = {file}: cannot be read: {error.strerror}") from error
    return _read(file.absolute(), key, stamp)


@lru_cache(maxsize=4)
def _read(file: Path, key: str, stamp: tuple[int, ...]) -> ScatteredValues:
    """The table of a file; `stamp` is another one when the file has changed."""
    table = read_table(file, key)
    if len(table.rows) > MOST_POINTS:
        raise GeometryError(f"{file}: {len(table.rows)} points: must be {MOST_POINTS} at most")
    columns = _columns(table)
    unit = table.column(*_ZEROS)
    points = np.array([[row.number(name) for name in columns.values()] for row in table.rows])
    scale = [METRES[name.split("_")[1]] for name in columns.values()]
    values = np.array([_kelvin(row, unit) for row in table.rows])
    try:
        return ScatteredValues.of(tuple(columns), points * scale, values)
    except GeometryError as error:
        raise GeometryError(f"{file}: {error}") from error


def _columns(table: CsvTable) -> dict[int, str]:
    """Columns of coordinates that there are, by the number of the coordinate.

    Raises:
        GeometryError: if there is none, one is there twice, or others are there.
    """
    present = {
        axis: table.column_with_unit(name)
        for axis, name in enumerate("xyz")
        if any(each.startswith(f"{name}_") for each in table.header)
    }
    if not present:
        table.column(*(column for name in "xyz" for column in with_units(name)))
    others = [name for name in table.header if name not in (*present.values(), *_ZEROS)]
    if others:
        raise GeometryError(
            f"{table.file}: column {others[0]} is unknown: must have x_m, y_m and z_m (or some of "
            "them, or with other units of length), and T_K or T_C"
        )
    return present


def _kelvin(row: Row, unit: str) -> float:
    """Temperature of a row in K.

    Raises:
        GeometryError: if no solid has it.
    """
    value = row.number(unit) + _ZEROS[unit]
    if not 0 < value <= HOTTEST:
        raise GeometryError(
            f"{row.place}: {unit} = {row.text(unit)}: must be above absolute zero and at most "
            f"{HOTTEST:g} K"
        )
    return value
