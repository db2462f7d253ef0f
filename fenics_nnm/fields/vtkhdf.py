"""Files of VTK's HDF format: a grid and its fields at several instants, all in one file.

The grid is there once. Each step says at which row of an array its values begin, so that steps
with the same values share them; see "VTKHDF File Format", docs.vtk.org. ParaView 5.12 and later
read it. Fields are in single precision, of seven digits.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fenics_nnm.arrays import Array
from fenics_nnm.fields.vtu import Grid, pays

#: Version of the format that is written.
_VERSION = (2, 0)

#: Rows of a compressed array that are packed together.
_CHUNK = 16384


#: How arrays are compressed.
_PACKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


@dataclass(frozen=True, slots=True)
class Piece:
    """Values of a field at the nodes of a grid.

    Attributes:
        name: Name of the field.
        number: Their number among the values of the field.
        values: Shape (nodes,) or (nodes, components).
        of_step: Number of the values that each step has of the field.
    """

    name: str
    number: int
    values: Array
    of_step: Sequence[int]


@dataclass(frozen=True, slots=True)
class StepsFile:
    """A file of a grid, with fields at its nodes at each step.

    Attributes:
        grid: The grid.
    """

    grid: Grid

    def begin(self, path: Path, times: Sequence[float]) -> None:
        """Make the file with its grid and steps, and no fields yet.

        Raises:
            OSError: if it cannot be made.
        """
        nodes, (count, width) = self.grid.nodes, self.grid.cells.shape
        with h5py.File(path, "w") as file:
            root = file.create_group("VTKHDF")
            root.attrs["Version"] = np.array(_VERSION)
            root.attrs["Type"] = np.bytes_("UnstructuredGrid")
            sizes = {
                "NumberOfPoints": len(nodes),
                "NumberOfCells": count,
                "NumberOfConnectivityIds": count * width,
            }
            for name, size in sizes.items():
                root[name] = np.array([size])
            _put(root, "Points", nodes.astype(np.float64))
            _put(root, "Connectivity", self.grid.cells.ravel().astype(np.int64))
            _put(root, "Offsets", width * np.arange(count + 1))
            _put(root, "Types", np.full(count, self.grid.cell_type, dtype=np.uint8))
            root.create_group("PointData")
            _add_steps(root.create_group("Steps"), times)

    def put(self, path: Path, each: Iterable[Piece]) -> None:
        """Add values of fields to a file.

        Raises:
            OSError: if they cannot be written.
        """
        with h5py.File(path, "r+") as file:
            root = file["VTKHDF"]
            data, offsets = root["PointData"], root["Steps/PointDataOffsets"]
            for piece in each:
                name, values = in_hdf(piece.name), piece.values.astype(np.float32)
                if name not in data:
                    shown = np.array(piece.of_step)
                    _make(data, name, values, int(shown.max()) + 1)
                    offsets[name] = shown * len(values)
                first = piece.number * len(values)
                data[name][first : first + len(values)] = values


def _add_steps(book: Any, times: Sequence[float]) -> None:
    """The steps, all of which have the same grid."""
    count = len(times)
    book.attrs["NSteps"] = count
    book["Values"] = np.array(times, dtype=np.float64)
    book["NumberOfParts"] = np.ones(count, dtype=np.int64)
    for name in ("PartOffsets", "PointOffsets"):
        book[name] = np.zeros(count, dtype=np.int64)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        book[name] = np.zeros((count, 1), dtype=np.int64)
    book.create_group("PointDataOffsets")


def in_hdf(name: str) -> str:
    """Name of a field in the file, where "/" stands between groups: "velocity (m per s)"."""
    return name.replace("/", " per ")


def _make(data: Any, name: str, values: NDArray[np.float32], count: int) -> None:
    """Make room for so many values of a field like these."""
    shape, packing = (count * len(values), *values.shape[1:]), {}
    if pays(values.ravel().view(np.uint8).data):
        rows = (min(len(values), _CHUNK), *values.shape[1:])
        packing = {**_PACKED, "chunks": rows}
    data.create_dataset(name, shape, values.dtype, **packing)


def _put(root: Any, name: str, values: Any) -> None:
    """An array of the grid, compressed."""
    root.create_dataset(name, data=values, **(_PACKED if len(values) else {}))
