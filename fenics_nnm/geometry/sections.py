"""Tables of blade sections: from a CSV file to arrays in one length unit.

A table has one row per point and the columns `section, j, z_<unit>, r_<unit>, theta1_rad,
theta2_rad` with <unit> one of m, cm, mm, in, ft. `z` runs along the machine axis, `r` is the
distance from it, `theta1` and `theta2` are the angles of the two blade sides at the same (z, r).
Sections are numbered from the hub outwards; j runs from one edge of the blade to the other.
Lines that start with `#` are comments.
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.csv_table import CsvTable, read_table
from fenics_nnm.geometry.lengths import METRES

_FEWEST_POINTS = 5


@dataclass(frozen=True, slots=True)
class Section:
    """One blade section as the table gives it, edge to edge.

    Attributes:
        number: Its number in the table.
        axial: Coordinate along the machine axis, shape (n,), in the unit asked for.
        radius: Distance from the axis, shape (n,), same unit.
        theta: Angles of the two sides in radians, shape (n, 2).
    """

    number: int
    axial: np.ndarray
    radius: np.ndarray
    theta: np.ndarray


def read_sections(file: Path, length_unit: str) -> list[Section]:
    """Read all sections of a table, hub first, with lengths in `length_unit`.

    Raises:
        GeometryError: A line that names the file, and the line and column, and what is wrong.
    """
    return sections_of(read_table(file, "mesh.sections"), length_unit)


def sections_of(table: CsvTable, length_unit: str) -> list[Section]:
    """All sections of a table, hub first, with lengths in `length_unit`.

    Raises:
        GeometryError: A line that names the file, and the line and column, and what is wrong.
    """
    counts = [table.column("section"), table.column("j")]
    axial, radius = (table.column_with_unit(name) for name in "zr")
    angles = [table.column("theta1_rad"), table.column("theta2_rad")]
    scale = [METRES[name.split("_")[1]] / METRES[length_unit] for name in (axial, radius)]
    values = np.array(
        [
            [row.number(name, whole=True) for name in counts]
            + [row.number(axial), row.number(radius, positive=True)]
            + [row.number(name) for name in angles]
            for row in table.rows
        ]
    )
    numbers = np.unique(values[:, 0])
    sections = [_make_section(table.file, values[values[:, 0] == n], scale) for n in numbers]
    _check_order(table.file, sections)
    return sections


def _make_section(file: Path, rows: np.ndarray, scale: list[float]) -> Section:
    """One section from its rows, scaled, the side of larger angle first."""
    number = int(rows[0, 0])
    if len(rows) < _FEWEST_POINTS:
        raise GeometryError(
            f"{file}: section {number}: {len(rows)} points, must be {_FEWEST_POINTS} or more"
        )
    if np.any(np.diff(rows[:, 1]) <= 0):
        raise GeometryError(f"{file}: section {number}: column j must rise from row to row")
    theta = rows[:, 4:6]
    if theta[:, 0].mean() < theta[:, 1].mean():
        theta = theta[:, ::-1]
    return Section(number, rows[:, 2] * scale[0], rows[:, 3] * scale[1], theta)


def _check_order(file: Path, sections: list[Section]) -> None:
    """Refuse a table whose sections are not numbered from the hub outwards."""
    for inner, outer in pairwise(sections):
        if outer.radius.mean() <= inner.radius.mean():
            raise GeometryError(
                f"{file}: section {outer.number}: mean radius is not larger than that of "
                f"section {inner.number}; sections must be numbered from the hub outwards"
            )
