"""Files of VTK's XML formats: unstructured grids, compressed, and collections of them in time.

Arrays are appended as raw bytes that zlib has compressed, which VTK and ParaView read at once;
see "VTK XML Formats", docs.vtk.org.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: zlib's levels: fast, and none. Higher ones take longer and hardly make numbers smaller.
_FAST, _STORED = 1, 0

#: An array is compressed if that takes a quarter, or more, off a sample: so many pieces of it, each
#: of so many bytes.
_WORTH, _PIECES, _PIECE = 0.75, 4, 2**10

#: No offset in a file is larger, and no array at the nodes has more components.
_FAR, _WIDE = 10**15, 9

_TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}


@dataclass(frozen=True, slots=True)
class Block:
    """An array as it is in files: its description without offset, and its bytes."""

    description: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Grid:
    """Nodes, and cells of one type.

    Attributes:
        nodes: Places in m, shape (n, 3).
        cells: Nodes of each cell in VTK's order, shape (cells, nodes a cell).
        cell_type: VTK's number of the type.
    """

    nodes: Array
    cells: Indices
    cell_type: int


@dataclass(frozen=True, slots=True)
class GridFile:
    """A grid, compressed once for all files that share it.

    Attributes:
        grid: The grid.
        geometry: Places of its nodes, and its cells, as they are in files.
    """

    grid: Grid
    geometry: tuple[Block, ...]

    def write(self, path: Path, fields: Mapping[str, Array]) -> None:
        """Write a .vtu file with fields at the nodes.

        Args:
            path: File to write.
            fields: Each of shape (nodes,) or (nodes, components).

        Raises:
            OSError: if it cannot be written.
        """
        self.write_each(path, list(fields), fields.values())

    def write_each(self, path: Path, names: Sequence[str], fields: Iterable[Array]) -> None:
        """The same with fields that are made one after the other, and none of them kept."""
        self._write(path, names, map(block, names, fields))

    def write_blocks(self, path: Path, blocks: Mapping[str, Block]) -> None:
        """The same with fields that were packed before."""
        self._write(path, list(blocks), blocks.values())

    def _write(self, path: Path, names: Sequence[str], fields: Iterable[Block]) -> None:
        """Write a file; the header tells where each field is and stands before them.

        Room is left for it.
        """
        widest = [*self.geometry, *(Block(_described(name, "f8", _WIDE), b"") for name in names)]
        room = len(self._header(widest, [_FAR] * len(widest)))
        known: list[Block] = []
        offsets: list[int] = []
        with path.open("wb") as file:
            file.write(b" " * room)
            for each in chain(self.geometry, fields):
                offsets.append(file.tell() - room)
                file.write(each.data)
                known.append(replace(each, data=b""))
            file.write(b"\n</AppendedData>\n</VTKFile>\n")
            file.seek(0)
            file.write(self._header(known, offsets, room))

    def _header(self, blocks: Sequence[Block], offsets: Sequence[int], room: int = 0) -> bytes:
        """All before the data, filled up with blanks."""
        arrays = [
            f'<DataArray {each.description} format="appended" offset="{offset}"/>'
            for each, offset in zip(blocks, offsets, strict=True)
        ]
        nodes, cells = len(self.grid.nodes), len(self.grid.cells)
        piece = f'<Piece NumberOfPoints="{nodes}" NumberOfCells="{cells}">'
        lines = [
            '<?xml version="1.0"?>',
            '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64" compressor="vtkZLibDataCompressor">',
            f"<UnstructuredGrid>{piece}",
            *("<Points>", arrays[0], "</Points>"),
            *("<Cells>", *arrays[1:4], "</Cells>"),
            *("<PointData>", *arrays[4:], "</PointData>"),
            "</Piece></UnstructuredGrid>",
        ]
        text, opening = "\n".join(lines).encode(), b'\n<AppendedData encoding="raw">\n_'
        return text.ljust(room - len(opening)) + opening


def grid_file(nodes: Array, cells: Indices, cell_type: int) -> GridFile:
    """A grid of cells of one type.

    Args:
        nodes: Places in m, shape (n, 3).
        cells: Nodes of each cell in VTK's order, shape (cells, nodes a cell).
        cell_type: VTK's number of the type.
    """
    count, width = cells.shape
    ends = width * np.arange(1, count + 1, dtype=np.int64)
    geometry = (
        block("Points", nodes.astype(np.float64)),
        block("connectivity", cells.ravel().astype(np.int64)),
        block("offsets", ends),
        block("types", np.full(count, cell_type, dtype=np.uint8)),
    )
    return GridFile(Grid(nodes, cells, cell_type), geometry)


def write_collection(path: Path, files: Sequence[str], times: Sequence[float]) -> None:
    """Write a .pvd file: files, relative to its folder, each with its time.

    Raises:
        OSError: if it cannot be written.
    """
    lines = [
        f'<DataSet timestep="{time!r}" group="" part="0" file={quoteattr(file)}/>'
        for file, time in zip(files, times, strict=True)
    ]
    opening = '<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">'
    text = ['<?xml version="1.0"?>', opening, "<Collection>", *lines, "</Collection>", "</VTKFile>"]
    path.write_text("\n".join([*text, ""]))


def block(name: str, values: Array | Indices) -> Block:
    """An array at the nodes that is in several files, packed once."""
    raw = np.ascontiguousarray(values).ravel().view(np.uint8).data
    packed = zlib.compress(raw, _FAST if pays(raw) else _STORED)
    header = np.array([1, len(raw), 0, len(packed)] if raw else [0, 0, 0], dtype="<u8").tobytes()
    width = values.shape[1] if values.ndim == 2 else 0
    description = _described(name, values.dtype.str[1:], width)
    return Block(description, header + packed if raw else header)


def _described(name: str, kind: str, components: int) -> str:
    width = f' NumberOfComponents="{components}"' if components else ""
    return f'type="{_TYPES[kind]}" Name={quoteattr(name)}{width}'


def pays(raw: memoryview) -> bool:
    """Whether compression pays: the digits of most stresses and displacements are like noise."""
    starts = range(0, len(raw), max(_PIECE, len(raw) // _PIECES))
    sample = b"".join(raw[start : start + _PIECE] for start in starts)
    return len(zlib.compress(sample, _FAST)) < _WORTH * len(sample)
