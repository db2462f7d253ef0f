"""A CSV file with one study a row: keys in its first row, their values below."""

from __future__ import annotations

import csv
from pathlib import Path

from fenics_nnm.errors import StudyError
from fenics_nnm.study.messages import plain
from fenics_nnm.study.settings import Setting, parts_of, value_from


def read_table(file: Path) -> tuple[tuple[Setting, ...], ...]:
    """Settings of each row; values are those of TOML, quotes may be left out as in `--set`.

    Empty lines and lines that begin with # are passed over.

    Raises:
        StudyError: if it cannot be read, or a row has too few or too many values.
    """
    try:
        with file.open(newline="", encoding="utf-8-sig") as opened:
            reader = csv.reader(opened, skipinitialspace=True)
            numbered = [(reader.line_num, row) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise StudyError(f"--table {file}: cannot be read: {plain(error)}") from error
    rows = [(n, row) for n, row in numbered if any(row) and not row[0].startswith("#")]
    if len(rows) < 2:
        raise StudyError(f"--table {file}: must have a row of keys, and rows of values below")
    keys = [key.strip() for key in rows[0][1]]
    try:
        for key in keys:
            parts_of(key)
        return tuple(_settings(keys, number, row) for number, row in rows[1:])
    except StudyError as error:
        raise StudyError(f"--table {file}: {error}") from error


def _settings(keys: list[str], number: int, row: list[str]) -> tuple[Setting, ...]:
    if len(row) != len(keys):
        raise StudyError(f"line {number}: has {len(row)} values: must have {len(keys)}")
    try:
        pairs = zip(keys, row, strict=True)
        return tuple(Setting(key, value_from(text, key)) for key, text in pairs)
    except StudyError as error:
        raise StudyError(f"line {number}: {error}") from error
