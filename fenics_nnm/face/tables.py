"""Tables of results as arrays: the columns of a CSV file by name."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import OutputError

#: Columns of text, whatever is in them.
_TEXT = {"event", "folder", "message", "monitor", "reason", "stability", "status"}

Table = dict[str, Array]
"""Columns by name, each with an entry for every row: numbers, nan where there is none, or texts."""


def read_table(file: Path, needed: Sequence[str]) -> Table:
    """The columns of a CSV file of results.

    Args:
        file: The file.
        needed: Columns that it must have.

    Raises:
        OutputError: if it cannot be read, or is no such table.
    """
    try:
        text = file.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise OutputError(f"{file}: cannot be read: {error}") from error
    names, *rows = list(csv.reader(text.splitlines())) or [[]]
    if missing := set(needed) - set(names):
        raise OutputError(f"{file}: cannot be read: has no column {min(missing)}")
    if any(len(row) != len(names) for row in rows):
        raise OutputError(f"{file}: cannot be read: its rows are not as long as its first line")
    return {name: _column(name, [row[place] for row in rows]) for place, name in enumerate(names)}


def _column(name: str, cells: list[str]) -> Array:
    """Numbers if all cells are numbers or empty; texts if not."""
    if name not in _TEXT:
        try:
            return np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            pass
    return np.array(cells, dtype=str)
