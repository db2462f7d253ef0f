"""Tables of blade sections: from a CSV file to arrays in one length unit.

A table has one row per point and the columns `section, j, z_<unit>, r_<unit>, theta1_rad,
theta2_rad` with <unit> one of m, cm, mm, in, ft. `z` runs along the machine axis, `r` is the
distance from it, `theta1` and `theta2` are the angles of the two blade sides at the same (z, r).
Sections are numbered from the hub outwards; j runs from one edge of the blade to the other.
Lines that start with `#` are comments.
"""

import csv
import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.parameters import METRES

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
    header, rows = _read_cells(file)
    names = _find_columns(file, header)
    values = np.array([_read_row(file, line, header, cells, names) for line, cells in rows])
    scale = [METRES[name.split("_")[1]] / METRES[length_unit] for name in names[2:4]]
    numbers = np.unique(values[:, 0])
    sections = [_make_section(file, values[values[:, 0] == n], scale) for n in numbers]
    _check_order(file, sections)
    return sections


def _read_cells(file: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Header cells, and (line number, cells) of every row after it."""
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise GeometryError(f"mesh.sections = {file}: cannot be read: {reason}") from error
    rows = [
        (number, [cell.strip() for cell in next(csv.reader([line]))])
        for number, line in enumerate(lines, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(rows) < 2:
        raise GeometryError(f"{file}: has no table: must be a header line and rows of numbers")
    return rows[0][1], rows[1:]


def _find_columns(file: Path, header: list[str]) -> list[str]:
    """Full names of section, j, z, r, theta1, theta2 as this table spells them."""
    choices = [["section"], ["j"]]
    choices += [[f"{name}_{unit}" for unit in METRES] for name in "zr"]
    choices += [["theta1_rad"], ["theta2_rad"]]
    found = []
    for accepted in choices:
        present = [name for name in header if name in accepted]
        if len(present) != 1:
            wanted = " or ".join(accepted)
            problem = "is missing" if not present else f"is given {len(present)} times"
            raise GeometryError(f"{file}: column {wanted} {problem}; it has {', '.join(header)}")
        found.append(present[0])
    return found


def _read_row(
    file: Path, line: int, header: list[str], cells: list[str], names: list[str]
) -> list[float]:
    """The numbers of one row, in the order of `names`."""
    if len(cells) != len(header):
        raise GeometryError(f"{file}: line {line}: {len(cells)} cells, must be {len(header)}")
    by_name = dict(zip(header, cells, strict=True))
    return [_read_number(f"{file}: line {line}: {name}", by_name[name]) for name in names]


def _read_number(place: str, cell: str) -> float:
    """A finite number; whole if it counts something, positive if it is a radius."""
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    column = place.rsplit(" ", 1)[1]
    if not math.isfinite(value):
        raise GeometryError(f'{place} = "{cell}": must be a number')
    if column in ("section", "j") and not value.is_integer():
        raise GeometryError(f"{place} = {cell}: must be a whole number")
    if column.startswith("r_") and value <= 0:
        raise GeometryError(f"{place} = {cell}: must be positive")
    return value


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
