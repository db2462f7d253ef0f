"""Unstructured grids in VTK's XML files: text, base64 or appended bytes, compressed or not.

meshio stops at arrays of text, which VTK 9, ParaView and pyvista write, hence a reader of our own.
"""

from __future__ import annotations

import base64
import lzma
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.foreign_mesh import ForeignMesh
from fenics_nnm.fem.vtk_grid import Grid, foreign_of_grid

_TYPES = {
    **{f"Int{bits}": f"i{bits // 8}" for bits in (8, 16, 32, 64)},
    **{f"UInt{bits}": f"u{bits // 8}" for bits in (8, 16, 32, 64)},
    **{"Float32": "f4", "Float64": "f8"},
}

_DECOMPRESSORS: dict[str, Callable[[], Any]] = {
    "vtkZLibDataCompressor": zlib.decompressobj,
    "vtkLZMADataCompressor": lzma.LZMADecompressor,
}

_COUNTS = ("NumberOfPoints", "NumberOfCells")

#: Most bytes of an array for each point or cell: 27 nodes of 8 bytes.
_MOST_BYTES = 27 * 8


@dataclass(frozen=True, slots=True)
class _Coding:
    """How the arrays of a file are written.

    Attributes:
        order: "<" or ">".
        header: Type of the counts before an array.
        compressor: VTK's name of it, "" for none.
        appended: Bytes after the underscore of the appended data.
        raw: Whether these are the arrays themselves, not base64.
        offsets: Where arrays begin in them, ascending.
        most: Most bytes of a packed array: what points and cells can have.
    """

    order: str
    header: str
    compressor: str
    appended: bytes
    raw: bool
    offsets: tuple[int, ...]
    most: int


def read_vtu(path: Path) -> ForeignMesh:
    """Read an unstructured grid with its whole numbers on cells as groups.

    Raises:
        MeshError: if the file cannot be read.
    """
    try:
        return foreign_of_grid(path, _grid(path))
    except MeshError:
        raise
    except (OSError, ValueError, LookupError, zlib.error, lzma.LZMAError) as error:
        raise _unreadable(path, str(error)) from error
    except (ElementTree.ParseError, TypeError, AttributeError, OverflowError) as error:
        raise _unreadable(path, str(error)) from error


def _unreadable(path: Path, why: str) -> MeshError:
    reason = " ".join(why.split())
    return MeshError(
        f"mesh file {path}: is no file of VTK that can be read: {reason}", code=Code.MESH_FILE
    )


def _grid(path: Path) -> Grid:
    root, coding = _opened(path)
    if root.get("type") != "UnstructuredGrid":
        raise _unreadable(path, f"holds a {root.get('type')}: must be an UnstructuredGrid")
    pieces = [_piece(piece, coding) for piece in root.iter("Piece")]
    if not pieces:
        raise _unreadable(path, "holds no piece of a grid")
    starts = np.cumsum([0, *(len(piece.points) for piece in pieces)])
    nodes = np.cumsum([0, *(len(piece.connectivity) for piece in pieces)])
    shared = set.intersection(*(set(piece.cell_data) for piece in pieces))
    return Grid(
        np.concatenate([piece.points for piece in pieces]),
        np.concatenate([p.connectivity + start for p, start in zip(pieces, starts, strict=False)]),
        np.concatenate([p.ends + start for p, start in zip(pieces, nodes, strict=False)]),
        np.concatenate([piece.types for piece in pieces]),
        {name: np.concatenate([p.cell_data[name] for p in pieces]) for name in sorted(shared)},
    )


def _opened(path: Path) -> tuple[ElementTree.Element, _Coding]:
    """XML before the appended data, which may be bytes that are no XML, and how arrays are read."""
    text = path.read_bytes()
    head, tag, rest = text.partition(b"<AppendedData")
    attributes, _, data = rest.partition(b">")
    if b"<!DOCTYPE" in head or b"<!ENTITY" in head:
        raise ValueError("must have no document type")
    root = ElementTree.fromstring(head + b"</VTKFile>" if tag else text)
    appended = data.partition(b"_")[2]
    offsets = sorted({int(array.get("offset", 0)) for array in root.iter("DataArray")})
    return root, _Coding(
        ">" if root.get("byte_order") == "BigEndian" else "<",
        _TYPES[root.get("header_type", "UInt32")],
        root.get("compressor", ""),
        appended,
        b"raw" in attributes,
        tuple(offsets),
        _MOST_BYTES * sum(_count(piece, name) for piece in root.iter("Piece") for name in _COUNTS),
    )


def _count(piece: ElementTree.Element, name: str) -> int:
    return int(piece.get(name) or 0)


def _piece(piece: ElementTree.Element, coding: _Coding) -> Grid:
    cells = {array.get("Name"): _values(array, coding) for array in _arrays(piece, "Cells")}
    missing = [name for name in ("connectivity", "offsets", "types") if name not in cells]
    if missing:
        raise ValueError(f"its cells have no {missing[0]}")
    (points,) = (_values(array, coding) for array in _arrays(piece, "Points"))
    data = {
        str(array.get("Name")): _values(array, coding)
        for array in _arrays(piece, "CellData")
        if array.get("type", "").startswith(("Int", "UInt")) and _width(array) == 1
    }
    return Grid(
        points.reshape(-1, 3).astype(float),
        cells["connectivity"].astype(np.int64),
        cells["offsets"].astype(np.int64),
        cells["types"].astype(np.int64),
        data,
    )


def _arrays(piece: ElementTree.Element, name: str) -> list[ElementTree.Element]:
    section = piece.find(name)
    return [] if section is None else section.findall("DataArray")


def _width(array: ElementTree.Element) -> int:
    return int(array.get("NumberOfComponents") or 1)


def _values(array: ElementTree.Element, coding: _Coding) -> Any:
    """Values of an array in one row."""
    kind = _TYPES[array.get("type", "")]
    form = array.get("format", "ascii")
    if form == "ascii":
        return np.array((array.text or "").split(), dtype=kind)
    if form == "binary":
        data = _from_base64((array.text or "").encode())
    else:
        start = int(array.get("offset", 0))
        after = [offset for offset in coding.offsets if offset > start]
        data = coding.appended[start : after[0] if after else None]
        data = data if coding.raw else _from_base64(data)
    return np.frombuffer(_uncompressed(data, coding), dtype=coding.order + kind)


def _from_base64(text: bytes) -> bytes:
    """Bytes of a text in which counts and values may be coded one after the other."""
    parts = re.findall(rb"[A-Za-z0-9+/]+={0,2}", b"".join(text.partition(b"<")[0].split()))
    return b"".join(base64.b64decode(part) for part in parts)


def _uncompressed(data: bytes, coding: _Coding) -> bytes:
    """Bytes of the values, after the counts."""
    header = np.dtype(coding.order + coding.header)
    if not coding.compressor:
        (size,) = np.frombuffer(data, header, count=1)
        values = data[header.itemsize : header.itemsize + int(size)]
        if len(values) < size:
            raise ValueError("ends in the middle of an array")
        return values
    if coding.compressor not in _DECOMPRESSORS:
        raise ValueError(f"is compressed by {coding.compressor}: write it with zlib")
    blocks, size = map(int, np.frombuffer(data, header, count=2))
    if blocks * size > coding.most + size:
        raise ValueError(f"unpacks {blocks * size} bytes: its points and cells have fewer")
    counts = np.frombuffer(data, header, count=3 + blocks)[3:].astype(np.int64)
    ends = np.cumsum([header.itemsize * (3 + blocks), *counts])
    unpack = _DECOMPRESSORS[coding.compressor]
    return b"".join(
        _unpacked(unpack(), data[start:end], min(size, coding.most))
        for start, end in pairwise(ends)
    )


def _unpacked(unpack: Any, data: bytes, most: int) -> bytes:
    """A block, which may be packed far smaller than it is."""
    found: bytes = unpack.decompress(data, most + 1)
    if len(found) > most or not unpack.eof:
        raise ValueError("has a block that does not unpack to the bytes that it says")
    return found
