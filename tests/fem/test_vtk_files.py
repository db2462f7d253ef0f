"""Files of VTK as VTK 9, ParaView and pyvista write them: text, 64 bits, base64, appended bytes."""

from __future__ import annotations

import base64
import lzma
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from brick_beams import bricks, nodes
from mpi4py import MPI

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.mesh import TaggedMesh, read_mesh, spread_mesh
from fenics_nnm.fem.mesh_file import ReadMesh

N = (4, 1, 1)
CELLS = np.array(bricks(N)) - 1
TEXT = "a text of many words, longer than one might think, so that its length takes two bytes"

ARRAYS = {
    "Points": (nodes(N).ravel(), "Float64", 3),
    "connectivity": (CELLS.ravel(), "Int64", 1),
    "offsets": (8 * (np.arange(4) + 1), "Int64", 1),
    "types": (np.full(4, 12), "UInt8", 1),
    "part": (np.array([1, 1, 2, 2]), "Int64", 1),
    "vtkGhostType": (np.array([0, 0, 0, 1]), "UInt8", 1),
}
DTYPES = {"Float64": "f8", "Int64": "i8", "UInt8": "u1"}
PACKERS: dict[str, Callable[[bytes], bytes]] = {
    "vtkZLibDataCompressor": zlib.compress,
    "vtkLZMADataCompressor": lzma.compress,
}


def packed(values: Any, kind: str, order: str, header: str, compressor: str) -> tuple[bytes, bytes]:
    """Counts and bytes of an array; in blocks of 64 bytes if compressed."""
    data = values.astype(order + DTYPES[kind]).tobytes()
    code = order + {"UInt32": "I", "UInt64": "Q"}[header]
    if not compressor:
        return struct.pack(code, len(data)), data
    blocks = [PACKERS[compressor](data[i : i + 64]) for i in range(0, len(data), 64)]
    counts = [len(blocks), 64, len(data) % 64, *map(len, blocks)]
    return struct.pack(code[0] + code[1] * len(counts), *counts), b"".join(blocks)


def vtu(form: str, order: str = "<", header: str = "UInt32", compressor: str = "") -> bytes:
    """An unstructured grid in one of the ways of VTK."""
    appended, written = b"", {}
    for name, (values, kind, width) in ARRAYS.items():
        counts, data = packed(values, kind, order, header, compressor)
        start = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" '
        if form == "ascii":
            text = " ".join(map(str, values.tolist()))
            written[name] = f'{start}format="ascii">{text}</DataArray>'
            continue
        coded = base64.b64encode(counts) + base64.b64encode(data)
        if not compressor:
            coded = base64.b64encode(counts + data)
        if form == "binary":
            written[name] = f'{start}format="binary">\n {coded.decode()}\n</DataArray>'
        else:
            written[name] = f'{start}format="appended" offset="{len(appended)}"/>'
            appended += counts + data if form == "raw" else coded
    cells = "".join(written[name] for name in ("connectivity", "offsets", "types"))
    byte_order = "LittleEndian" if order == "<" else "BigEndian"
    packer = f' compressor="{compressor}"' if compressor else ""
    encoding = "raw" if form == "raw" else "base64"
    tail = f'<AppendedData encoding="{encoding}">\n_'.encode() + appended + b"\n</AppendedData>"
    return (
        (
            f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order='
            f'"{byte_order}" header_type="{header}"{packer}><UnstructuredGrid><FieldData>'
            f'<Array type="String" Name="note" NumberOfTuples="1" format="ascii">72 105 0</Array>'
            f'<DataArray type="String" Name="other" format="ascii">72 105 0</DataArray></FieldData>'
            f'<Piece NumberOfPoints="20" NumberOfCells="4"><Points>{written["Points"]}</Points>'
            f"<Cells>{cells}</Cells><CellData>{written['part']}{written['vtkGhostType']}"
            '<DataArray type="String" Name="names" format="ascii">72 0</DataArray></CellData>'
            "</Piece></UnstructuredGrid>"
        ).encode()
        + (tail if form in ("appended", "raw") else b"")
        + b"</VTKFile>\n"
    )


WAYS = [
    ("ascii", "<", "UInt32", ""),
    ("binary", "<", "UInt64", ""),
    ("binary", ">", "UInt32", "vtkZLibDataCompressor"),
    ("binary", "<", "UInt64", "vtkLZMADataCompressor"),
    ("appended", "<", "UInt64", "vtkZLibDataCompressor"),
    ("appended", "<", "UInt32", ""),
    ("raw", "<", "UInt64", ""),
    ("raw", ">", "UInt32", "vtkZLibDataCompressor"),
]


def assert_beam(tagged: TaggedMesh, count: int) -> None:
    x = tagged.mesh.geometry.x
    assert len(x) == 4 * (count + 1)
    np.testing.assert_allclose(x.max(axis=0), [0.05 * count, 0.02, 0.01])
    wanted = {"part=1": 2, "part=2": count - 2, "body": count}
    assert {name: len(cells) for name, cells in tagged.cells.items()} == wanted


@pytest.mark.parametrize("way", WAYS, ids=[" ".join(way) for way in WAYS])
def test_ways_of_xml(way: tuple[str, str, str, str], tmp_path: Path) -> None:
    """The ghost, a copy of a cell of another piece, is left out."""
    path = tmp_path / "a.vtu"
    path.write_bytes(vtu(*way))
    assert_beam(read_mesh(path, "m", MPI.COMM_SELF), 3)


def test_a_block_that_unpacks_to_more_than_it_says_is_refused(tmp_path: Path) -> None:
    """10 MB of zeros, packed to 10 kB, in place of the 3 ghost flags."""
    honest = vtu("raw", "<", "UInt32", "vtkZLibDataCompressor")
    start = int(honest.partition(b'Name="vtkGhostType"')[2].split(b'offset="')[1].split(b'"')[0])
    bomb = zlib.compress(bytes(10_000_000))
    head, tag, data = honest.partition(b"\n_")
    for size, words in ((4, "does not unpack to the bytes"), (2**31, "does not unpack")):
        path = tmp_path / "a.vtu"
        counts = struct.pack("<4I", 1, size, 0, len(bomb))
        path.write_bytes(head + tag + data[:start] + counts + bomb + b"\n</AppendedData></VTKFile>")
        with pytest.raises(MeshError, match=words):
            read_mesh(path, "m", MPI.COMM_SELF)


def legacy(version: str, *, binary: bool) -> bytes:
    """A legacy file with text, 64 bits, METADATA and a table of colours."""

    def block(values: Any, kind: str) -> bytes:
        if binary:
            return np.asarray(values).astype(f">{kind}").tobytes() + b"\n"
        return (" ".join(map(str, np.ravel(values).tolist())) + "\n").encode()

    def string(text: str) -> bytes:
        return struct.pack(">H", (2 << 14) | len(text)) + text.encode() if binary else text.encode()

    rows = np.column_stack([np.full(4, 8), CELLS])
    old = version < "5"
    cells = (
        b"CELLS 4 36\n" + block(rows, "i4")
        if old
        else b"CELLS 5 32\nOFFSETS vtktypeint64\n"
        + block(8 * np.arange(5), "i8")
        + b"CONNECTIVITY vtktypeint64\n"
        + block(CELLS, "i8")
    )
    return b"".join(
        [
            f"# vtk DataFile Version {version}\ntitle\n".encode(),
            b"BINARY\n" if binary else b"ASCII\n",
            b"DATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\nnote 1 1 string\n",
            *(string(TEXT), b"\n", b"POINTS 20 double\n", block(nodes(N), "f8")),
            *(b"METADATA\nINFORMATION 0\n\n", cells, b"\nCELL_TYPES 4\n"),
            *(block(np.full(4, 12), "i4"), b"POINT_DATA 20\nVECTORS v float\n"),
            *(block(np.zeros((20, 3)), "f4"), b"CELL_DATA 4\nSCALARS part long\nLOOKUP_TABLE t\n"),
            *(block([1, 1, 2, 2], "i8"), b"LOOKUP_TABLE t 2\n"),
            block(np.zeros(8, dtype=int), "u1"),
            b"FIELD FieldData 2\nnames 1 4 string\n",
            *([string(TEXT) + (b"" if binary else b"\n")] * 4),
            *(b"\nwide 2 4 vtktypeint64\n", block(np.zeros(8, dtype=int), "i8")),
        ]
    )


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("version", ["3.0", "4.2", "5.1"])
def test_legacy_files(version: str, binary: bool, tmp_path: Path) -> None:
    path = tmp_path / "a.vtk"
    path.write_bytes(legacy(version, binary=binary))
    assert_beam(read_mesh(path, "m", MPI.COMM_SELF), 4)


@pytest.mark.parametrize(
    "make", [lambda: vtu(*WAYS[6]), lambda: vtu(*WAYS[2]), lambda: vtu("ascii")]
)
def test_damaged_xml_is_refused_in_one_line(make: Callable[[], bytes], tmp_path: Path) -> None:
    _damage(tmp_path / "a.vtu", make())


@pytest.mark.parametrize("binary", [False, True])
def test_damaged_legacy_files_are_refused_in_one_line(binary: bool, tmp_path: Path) -> None:
    _damage(tmp_path / "a.vtk", legacy("5.1", binary=binary))


def _damage(path: Path, content: bytes) -> None:
    """Cut and change a file at many places; each is read, or refused in one line.

    All in this process: one of its own for each of them takes ten times as long.
    """
    refused = 0
    for place in range(0, len(content), max(1, len(content) // 60)):
        for damaged in (content[:place], content[:place] + b"\xff" + content[place + 1 :]):
            path.write_bytes(damaged)
            try:
                spread_mesh(lambda: ReadMesh(path)(path.parent), 1.0, MPI.COMM_SELF)
            except MeshError as error:
                refused += 1
                assert "\n" not in str(error)
    assert refused > 60


def test_compression_that_is_not_known_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.vtu"
    path.write_bytes(vtu(*WAYS[2]).replace(b"vtkZLib", b"vtkLZ4"))
    with pytest.raises(MeshError, match="compressed by vtkLZ4DataCompressor: write it with zlib"):
        read_mesh(path, "m", MPI.COMM_SELF)


WRONG = [
    (
        "a.inp",
        b"$MeshFormat\n4.1 0 8\n",
        "is a mesh of gmsh by its content: its name must end in .msh",
    ),
    ("a.msh", b"*HEADING\n*NODE\n1, 0, 0\n", "is a file of Abaqus or CalculiX by its content"),
    ("a.bdf", b"ISO-10303-21;\n", "is a STEP file by its content"),
    (
        "a.vtk",
        b'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid">',
        "is a file of VTK in XML",
    ),
    ("a.stl", b"solid a\n facet normal 0 0 1\n", "is a surface without volume"),
    ("a.msh", b"solid a\n facet normal 0 0 1\n", "is a surface without volume"),
    ("a.xyz", b"nonsense", ".cdb, .dat (Ansys)"),
]


@pytest.mark.parametrize(("name", "content", "words"), WRONG)
def test_files_that_are_not_what_their_ending_says(
    name: str, content: bytes, words: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError) as error:
        read_mesh(tmp_path / name, "m", MPI.COMM_SELF)
    assert words in str(error.value) and "\n" not in str(error.value)
