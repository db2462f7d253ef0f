"""Files of VTK's XML formats: unstructured grids, compressed, and collections of them in time.

Arrays are appended as raw bytes that zlib has compressed, which VTK and ParaView read at once;
see "VTK XML Formats", docs.vtk.org.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: zlib's levels: fast, and none. Higher ones take longer and hardly make numbers smaller.
_FAST, _STORED = 1, 0

#: An array is compressed if that takes a quarter, or more, off its first bytes, so many.
_WORTH, _SAMPLE = 0.75, 2**16

_TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}


@dataclass(frozen=True, slots=True)
class _Block:
    """An array as it is in the file: its description without offset, and its bytes."""

    description: str
    data: bytes


@dataclass(frozen=True, slots=True)
class GridFile:
    """A grid, compressed once for all files that share it.

    Attributes:
        nodes: Number of nodes.
        cells: Number of cells.
        geometry: Places of the nodes, and the cells.
    """

    nodes: int
    cells: int
    geometry: tuple[_Block, ...]

    def bytes_with(self, fields: Mapping[str, Array]) -> bytes:
        """The .vtu file with fields at the nodes, each of shape (nodes,) or (nodes, components)."""
        blocks = [*self.geometry, *(_block(name, values) for name, values in fields.items())]
        offsets = np.concatenate([[0], np.cumsum([len(block.data) for block in blocks])])
        arrays = [
            f'<DataArray {block.description} format="appended" offset="{offset}"/>'
            for block, offset in zip(blocks, offsets[:-1], strict=True)
        ]
        piece = f'<Piece NumberOfPoints="{self.nodes}" NumberOfCells="{self.cells}">'
        lines = [
            '<?xml version="1.0"?>',
            '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64" compressor="vtkZLibDataCompressor">',
            f"<UnstructuredGrid>{piece}",
            *("<Points>", arrays[0], "</Points>"),
            *("<Cells>", *arrays[1:4], "</Cells>"),
            *("<PointData>", *arrays[4:], "</PointData>"),
            "</Piece></UnstructuredGrid>",
            '<AppendedData encoding="raw">',
        ]
        data = b"".join(block.data for block in blocks)
        return "\n".join(lines).encode() + b"\n_" + data + b"\n</AppendedData>\n</VTKFile>\n"


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
        _block("Points", nodes.astype(np.float64)),
        _block("connectivity", cells.ravel().astype(np.int64)),
        _block("offsets", ends),
        _block("types", np.full(count, cell_type, dtype=np.uint8)),
    )
    return GridFile(len(nodes), count, geometry)


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


def _block(name: str, values: Array | Indices) -> _Block:
    kind = _TYPES[values.dtype.str[1:]]
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    raw = np.ascontiguousarray(values).tobytes()
    packed = zlib.compress(raw, _level(raw))
    header = np.array([1, len(raw), 0, len(packed)] if raw else [0, 0, 0], dtype="<u8").tobytes()
    return _Block(f'type="{kind}" Name={quoteattr(name)}{width}', header + (packed if raw else b""))


def _level(raw: bytes) -> int:
    """Whether compression pays: the digits of most stresses and displacements are like noise."""
    sample = raw[:_SAMPLE]
    return _FAST if len(zlib.compress(sample, _FAST)) < _WORTH * len(sample) else _STORED
