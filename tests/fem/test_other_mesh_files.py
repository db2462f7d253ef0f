"""Nastran, MED, VTK and .msh files that cannot be used, or say less than they should."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from conftest import BEAM, PLATE, Ended
from mpi4py import MPI

from fenics_nnm.fem.abaqus_mesh import read_abaqus
from fenics_nnm.fem.boundary import boundary
from fenics_nnm.fem.mesh import read_mesh
from fenics_nnm.fem.nastran_mesh import read_nastran
from fenics_nnm.fem.vtk_legacy import read_vtk

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

CUBE = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]

#: Bulk data in free, small and large fields, with numbers in Nastran's short forms.
BULK = """SOL 103
CEND
SET 7 = 1, 2
BEGIN BULK
$ a comment
GRID,1,,0.,0.,0.
GRID,2,0,1.,0.,0.
GRID    3               1.      1.      0.
GRID    4       0       0.      1.      0.0
GRID*   5                               0.              0.
*       1.
GRID*                  6               0  1.00000000E+00  0.00000000D+00+
*       1.00000000E+00
GRID,7,,10.-1,1.,1.+0
GRID,8,,0.,1.,.1+1
$ Elements and Element Properties for region : blade
PSOLID,4,1
CHEXA   1       4       1       2       3       4       5       6       +
+       7       8
$HMNAME COMP                   9"tip"
CQUAD4,2,9,2,3,7,6
ENDDATA
ignored
"""


def test_forms_of_bulk_data(tmp_path: Path) -> None:
    path = tmp_path / "cube.nas"
    path.write_text(BULK)
    tagged = read_mesh(path, "cm", MPI.COMM_SELF)
    assert set(tagged.cells) == {"PID 4", "blade", "body"}
    assert set(tagged.facets) == {"PID 9", "tip"}
    surface = boundary(tagged.mesh)
    tip = surface.mask(tagged.facets["tip"]) != 0
    np.testing.assert_allclose(surface.centres[tip], [[0.01, 0.005, 0.005]], rtol=1e-12)
    np.testing.assert_allclose(surface.corners.reshape(-1, 3).max(axis=0), 0.01, rtol=1e-12)


@pytest.mark.parametrize("reader", [read_abaqus, read_nastran, read_vtk])
def test_a_byte_order_mark_is_read_over(reader: Callable[[Path], Any], tmp_path: Path) -> None:
    """As editors of Windows write it before the first keyword."""
    texts = {
        read_abaqus: "*NODE\n1,0,0\n2,1,0\n3,0,1\n*ELEMENT,TYPE=CPS3\n1,1,2,3\n",
        read_nastran: "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nCTRIA3,1,1,1,2,3\n",
        read_vtk: "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        "POINTS 3 float\n0 0 0 1 0 0 0 1 0\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n",
    }
    path = tmp_path / "mesh"
    path.write_text(texts[reader], "utf-8-sig")
    found = reader(path)
    assert found.cells["triangle"].tolist() == [[0, 1, 2]] and len(found.points) == 3


BAD_BULK = [
    ("GRID,2,0,", "GRID,2,5,", ["line 7", "no system of coordinates 5", "CORD2C"]),
    ("GRID,2,0,1.", "GRID,2,0,one", ['"ONE" must be a number']),
    ("PSOLID,4,1", "CBAR,77,1,1,2,0.,0.,1.\nPBAR,1,4,1.", ["line 17", "CBAR cannot be followed"]),
    ("PSOLID,4,1", "CBAR,77,1,1,7,0.,0.,1.", ["1 lines hang on the body", "element 77"]),
    ("CQUAD4,2,9,2,3,7,6", "CQUAD4,2,9,2,3,7,66", ["there is no GRID 66"]),
    ("CQUAD4,2,9,2,3,7,6", "CQUAD4,2,9,2,3,7", ["CQUAD4 with 3 nodes: must have 4"]),
    ("CQUAD4,2,9,2,3,7,6", "CTETRA,2,9,2,3,7,5", ["elements overlap"]),
    ("ENDDATA", "INCLUDE 'a.bdf'", ["a.bdf", "No such file"]),
    ("ENDDATA", "INCLUDE 'cube.bdf'", ["cube.bdf", "includes itself"]),
]


@pytest.mark.parametrize(("old", "new", "words"), BAD_BULK)
def test_bulk_data_that_cannot_be_followed(
    old: str, new: str, words: list[str], study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    assert old in BULK
    (tmp_path / "cube.bdf").write_text(BULK.replace(old, new))
    study = study_file(BEAM, mesh={"=": {"file": "cube.bdf", "length_unit": "m"}})
    ended = command("check", study)
    assert ended.code == 2 and not [w for w in words if w.upper() not in ended.err.upper()], ended
    assert len(ended.err.splitlines()) == 1


def square(kind: str, cells: list[list[int]], height: float = 0.0) -> Any:
    """Two units of area in the plane, in a row."""
    points = [(x, y, height * x) for y in (0.0, 1.0) for x in (0.0, 1.0, 2.0)]
    return meshio.Mesh(np.array(points), {kind: np.array(cells)})


def mixed() -> Any:
    mesh = square("quad", [[0, 1, 4, 3]])
    return meshio.Mesh(mesh.points, [*mesh.cells, ("triangle", np.array([[1, 2, 4]]))])


BAD = [
    ("a.vtu", b"nonsense", ["no file of VTK that can be read"]),
    ("a.vtk", b"nonsense", ["no file of VTK that can be read"]),
    ("a.med", b"nonsense", ["meshio cannot read it"]),
    ("a.xyz", b"nonsense", ["meshio cannot read it"]),
    ("a.vtu", square("polygon", [[0, 1, 2, 5, 3]]), ["1 cells of the type", "must be of order"]),
    ("a.vtu", square("quad", [[0, 1, 4, 3], [1, 2, 5, 4]], 0.5), ["leaves the x-y plane"]),
    ("a.vtu", square("quad", [[0, 1, 3, 4], [1, 2, 5, 4]]), ["1 degenerate elements"]),
    ("a.vtu", square("vertex", [[0], [1]]), ["no physical groups with elements"]),
]


@pytest.mark.parametrize(("name", "content", "words"), BAD)
def test_files_of_meshio_that_cannot_be_used(
    name: str,
    content: Any,
    words: list[str],
    study_file: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    if isinstance(content, bytes):
        (tmp_path / name).write_bytes(content)
    else:
        content.write(tmp_path / name)
    study = study_file(PLATE, mesh={"=": {"file": name, "length_unit": "m"}})
    command("check", study).assert_one_line(2, name, *words)


def test_two_parts_that_touch_without_common_nodes_are_told(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """Both are held, so that the study runs; check tells of the nodes at one place."""
    points = [(x, y) for x in (0.0, 1.0, 1.0, 2.0) for y in (0.0, 1.0)]
    cells = np.array([[0, 2, 3, 1], [4, 6, 7, 5]])
    meshio.Mesh(np.array([(*p, 0.0) for p in points]), {"quad": cells}).write(tmp_path / "a.vtu")
    study = study_file(
        PLATE,
        mesh={"=": {"file": "a.vtu", "length_unit": "m"}},
        groups={"low": {"y": 0.0}, "high": {"y": 1.0}},
        clamp={"facets": "low"},
        contact={"facets": "high"},
    )
    ended = command("check", study)
    assert ended.code == 0, ended.err
    assert "coincident nodes 2 pairs, one at (1, 0) m" in ended.out
