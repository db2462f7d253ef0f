"""CSV tables with units in their column names: cells by column, and errors that name the place."""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.lengths import METRES


@dataclass(frozen=True, slots=True)
class Row:
    """One row of a table.

    Attributes:
        place: File and line, for messages.
        cells: Text of each column.
    """

    place: str
    cells: dict[str, str]

    def text(self, column: str) -> str:
        """The cell as it stands."""
        return self.cells[column]

    def number(self, column: str, *, whole: bool = False, positive: bool = False) -> float:
        """The cell as a finite number.

        Raises:
            GeometryError: It is none, or not whole or positive where it must be.
        """
        cell = self.cells[column]
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise GeometryError(f'{self.place}: {column} = "{cell}": must be a number')
        if whole and not value.is_integer():
            raise GeometryError(f"{self.place}: {column} = {cell}: must be a whole number")
        if positive and value <= 0:
            raise GeometryError(f"{self.place}: {column} = {cell}: must be positive")
        return value


@dataclass(frozen=True, slots=True)
class CsvTable:
    """A table as its file gives it; lines that start with `#` are left out.

    Attributes:
        file: Its file.
        header: Names of the columns.
        rows: Its rows, at least one.
    """

    file: Path
    header: list[str]
    rows: list[Row]

    def column(self, *accepted: str) -> str:
        """The one column with an accepted name.

        Raises:
            GeometryError: There is none, or more than one.
        """
        present = [name for name in self.header if name in accepted]
        if len(present) != 1:
            wanted = " or ".join(accepted)
            problem = "is missing" if not present else f"is given {len(present)} times"
            known = ", ".join(self.header)
            raise GeometryError(f"{self.file}: column {wanted} {problem}; it has {known}")
        return present[0]

    def column_with_unit(self, name: str) -> str:
        """The one column `name_<unit>` of a length.

        Raises:
            GeometryError: There is none, or more than one.
        """
        return self.column(*with_units(name))


def with_units(name: str) -> Sequence[str]:
    """Names of the columns that may hold a length."""
    return [f"{name}_{unit}" for unit in METRES]


def _separator(header: str) -> str:
    """What stands between the cells: a comma, or a semicolon or tab where there is none."""
    return next((sign for sign in ",;\t" if sign in header), ",")


def read_table(file: Path, key: str) -> CsvTable:
    """Read a table: a header line, then rows with a cell for each column.

    Args:
        file: The file.
        key: Key of the study that names it, for messages.

    Raises:
        GeometryError: A line that names the file, and the line, and what is wrong.
    """
    try:
        lines = file.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise GeometryError(f"{key} = {file}: cannot be read: {reason}") from error
    told = [
        (number, line)
        for number, line in enumerate(lines, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    try:
        separator = _separator(told[0][1] if told else "")
        cells = [
            (number, [cell.strip() for cell in next(csv.reader([line], delimiter=separator))])
            for number, line in told
        ]
    except csv.Error as error:
        raise GeometryError(f"{key} = {file}: cannot be read: {error}") from error
    if len(cells) < 2:
        raise GeometryError(f"{file}: has no table: must be a header line and rows of numbers")
    header = cells[0][1]
    for number, row in cells[1:]:
        if len(row) != len(header):
            raise GeometryError(f"{file}: line {number}: {len(row)} cells, must be {len(header)}")
    rows = [
        Row(f"{file}: line {number}", dict(zip(header, row, strict=True)))
        for number, row in cells[1:]
    ]
    return CsvTable(file, header, rows)
