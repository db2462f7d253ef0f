"""Unstructured grids in legacy files of VTK, versions 2 to 5, in text or bytes.

meshio stops at text and at whole numbers of 64 bits, hence a reader of our own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.foreign_mesh import ForeignMesh
from fenics_nnm.fem.vtk_grid import Grid, foreign_of_grid

_TYPES = {
    **{"char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2"},
    **{"int": "i4", "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8"},
    **{"float": "f4", "double": "f8", "vtkidtype": "i4", "long_long": "i8"},
    **{f"vtktypeint{bits}": f"i{bits // 8}" for bits in (8, 16, 32, 64)},
    **{f"vtktypeuint{bits}": f"u{bits // 8}" for bits in (8, 16, 32, 64)},
    **{"vtktypefloat32": "f4", "vtktypefloat64": "f8"},
}

#: Values for each point or cell of attributes with fixed numbers of them.
_WIDTHS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6}


@dataclass(slots=True)
class _Cursor:
    """Where a file is read, and what was found so far."""

    data: bytes
    text: bool = True
    place: int = 0
    points: Any = None
    connectivity: Any = None
    ends: Any = None
    types: Any = None
    cell_data: dict[str, Any] = field(default_factory=dict)
    on_cells: bool = False
    count: int = 0

    @property
    def over(self) -> bool:
        """Whether nothing is left."""
        return self.place >= len(self.data)

    def line(self) -> str:
        """The next line."""
        end = self.data.find(b"\n", self.place)
        end = len(self.data) if end < 0 else end
        found = self.data[self.place : end].decode("utf-8", errors="replace")
        self.place = end + 1
        return found.strip()

    def words(self) -> list[str]:
        """The words of the next line that is not empty, none at the end."""
        while not self.over:
            found = self.line().split()
            if found:
                return found
        return []

    def values(self, count: int, name: str) -> Any:
        """Numbers of a type; bytes are ended by a line."""
        if count < 0 or count > len(self.data):
            raise ValueError(f"{count} values: the file is shorter")
        if name.lower() == "bit":
            return self._bits(count)
        kind = np.dtype(_TYPES[name.lower()]).newbyteorder(">")
        if self.text:
            return np.array(self._entries(count), dtype=kind.newbyteorder("="))
        size = count * kind.itemsize
        found = np.frombuffer(self.data[self.place : self.place + size], kind)
        if len(found) < count:
            raise ValueError("ends in the middle of an array")
        self.place += size
        return found

    def strings(self, count: int) -> None:
        """Skip text: lines, or bytes with their number before."""
        for _ in range(count):
            if self.text:
                self.line()
                continue
            first = self.data[self.place]
            more = {3: 0, 2: 1, 1: 3, 0: 7}[first >> 6]
            number = self.data[self.place : self.place + more + 1]
            self.place += more + 1 + (int.from_bytes(number, "big") & ~(3 << (6 + 8 * more)))

    def _bits(self, count: int) -> Any:
        if self.text:
            return np.array(self._entries(count), dtype=np.uint8)
        self.place += (count + 7) // 8
        return np.zeros(count)

    def _entries(self, count: int) -> list[bytes]:
        found: list[bytes] = []
        while len(found) < count and not self.over:
            end = self.data.find(b"\n", self.place)
            end = len(self.data) if end < 0 else end
            found += self.data[self.place : end].split()
            self.place = end + 1
        if len(found) != count:
            raise ValueError(f"{len(found)} values in place of {count}")
        return found


def read_vtk(path: Path) -> ForeignMesh:
    """Read an unstructured grid with its whole numbers on cells as groups.

    Raises:
        MeshError: if the file cannot be read.
    """
    try:
        cursor = _read(path.read_bytes().removeprefix(b"\xef\xbb\xbf"))
        grid = Grid(
            cursor.points.reshape(-1, 3).astype(float),
            cursor.connectivity.astype(np.int64),
            cursor.ends.astype(np.int64),
            cursor.types.astype(np.int64),
            cursor.cell_data,
        )
    except (OSError, ValueError, LookupError, AttributeError, OverflowError) as error:
        reason = " ".join(str(error).split())
        raise MeshError(
            f"mesh file {path}: is no file of VTK that can be read: {reason}", code=Code.MESH_FILE
        ) from error
    return foreign_of_grid(path, grid)


def _read(data: bytes) -> _Cursor:
    cursor = _Cursor(data)
    if not cursor.line().startswith("# vtk DataFile"):
        raise ValueError('does not begin with "# vtk DataFile"')
    cursor.line()
    cursor.text = cursor.line().upper() == "ASCII"
    while words := cursor.words():
        keyword = words[0].upper()
        if keyword == "DATASET" and words[1].upper() != "UNSTRUCTURED_GRID":
            raise ValueError(f"holds {words[1]}: must be UNSTRUCTURED_GRID")
        take = _TAKES.get(keyword)
        if take is not None:
            take(cursor, words)
        elif keyword != "DATASET":
            raise ValueError(f'"{words[0][:40]}": is not known')
    return cursor


def _points(cursor: _Cursor, words: list[str]) -> None:
    cursor.points = cursor.values(3 * int(words[1]), words[2])


def _cells(cursor: _Cursor, words: list[str]) -> None:
    """Before version 5 the number of nodes before those of each cell, then ends and nodes."""
    cells, size = int(words[1]), int(words[2])
    before = cursor.place
    after = cursor.words()
    if after and after[0].upper() == "OFFSETS":
        cursor.ends = cursor.values(cells, after[1])[1:]
        cursor.connectivity = cursor.values(size, cursor.words()[1])
        return
    cursor.place = before
    listed = cursor.values(size, "int").astype(np.int64)
    nodes, ends, place = np.ones(size, dtype=bool), [], 0
    for _ in range(cells):
        nodes[place] = False
        place += int(listed[place]) + 1
        ends.append(place)
    cursor.connectivity = listed[nodes]
    cursor.ends = np.array(ends, dtype=np.int64) - np.arange(1, cells + 1)


def _types(cursor: _Cursor, words: list[str]) -> None:
    cursor.types = cursor.values(int(words[1]), "int")


def _data(cursor: _Cursor, words: list[str]) -> None:
    cursor.on_cells = words[0].upper() == "CELL_DATA"
    cursor.count = int(words[1])


def _scalars(cursor: _Cursor, words: list[str]) -> None:
    width = int(words[3]) if len(words) > 3 else 1
    before = cursor.place
    if cursor.words()[0].upper() != "LOOKUP_TABLE":
        cursor.place = before
    _keep(cursor, words[1], cursor.values(width * cursor.count, words[2]), width)


def _attribute(cursor: _Cursor, words: list[str]) -> None:
    cursor.values(_WIDTHS[words[0].upper()] * cursor.count, words[2])


def _coordinates(cursor: _Cursor, words: list[str]) -> None:
    cursor.values(int(words[2]) * cursor.count, words[3])


def _ids(cursor: _Cursor, words: list[str]) -> None:
    _keep(cursor, words[1], cursor.values(cursor.count, words[2]), 1)


def _colours(cursor: _Cursor, words: list[str]) -> None:
    cursor.values(int(words[2]) * cursor.count, "float" if cursor.text else "unsigned_char")


def _table(cursor: _Cursor, words: list[str]) -> None:
    cursor.values(4 * int(words[2]), "float" if cursor.text else "unsigned_char")


def _fields(cursor: _Cursor, words: list[str]) -> None:
    """Arrays, each with a line before it, and perhaps METADATA after it."""
    left = int(words[2])
    while left:
        name, *numbers = cursor.words()
        if name.upper() == "METADATA":
            _metadata(cursor, [])
            continue
        width, rows, kind = int(numbers[0]), int(numbers[1]), numbers[2]
        left -= 1
        if kind.lower() == "string":
            cursor.strings(width * rows)
        else:
            _keep(cursor, name, cursor.values(width * rows, kind), width)


def _metadata(cursor: _Cursor, words: list[str]) -> None:
    """Lines up to an empty one."""
    while not cursor.over and cursor.line():
        continue


def _keep(cursor: _Cursor, name: str, values: Any, width: int) -> None:
    if cursor.on_cells and width == 1:
        cursor.cell_data[name] = values.astype(values.dtype.newbyteorder("="))


_TAKES: dict[str, Callable[[_Cursor, list[str]], None]] = {
    **{"POINTS": _points, "CELLS": _cells, "CELL_TYPES": _types, "METADATA": _metadata},
    **{"POINT_DATA": _data, "CELL_DATA": _data, "SCALARS": _scalars, "FIELD": _fields},
    **{"COLOR_SCALARS": _colours, "LOOKUP_TABLE": _table, "GLOBAL_IDS": _ids},
    **{"PEDIGREE_IDS": _ids, "TEXTURE_COORDINATES": _coordinates},
    **dict.fromkeys(_WIDTHS, _attribute),
}
