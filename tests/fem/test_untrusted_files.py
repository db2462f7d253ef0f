"""Files that would run commands, and those of which gmsh crashes: one line, and nothing is done."""

from __future__ import annotations

import ctypes
import os
import time
from dataclasses import dataclass
from pathlib import Path

import gmsh
import numpy as np
import pytest
from mpi4py import MPI
from small_meshes import saved_model

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cad_model import Cad, MeshCad
from fenics_nnm.fem.geo_script import plain_script
from fenics_nnm.fem.mesh import read_mesh
from fenics_nnm.fem.native import Limits, in_own_process
from fenics_nnm.fem.native_errors import FileErrors
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.study.error_keys import one_line

pytestmark = pytest.mark.own_process

#: A block of gmsh's language; what comes before and after it must not do anything.
BLOCK = 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 4, 2, 1};\n'


#: Whether the kernel can keep a process from writing: landlock(7).
LANDLOCK = ctypes.CDLL(None).syscall(444, None, 0, 1) > 0


def meshed(path: Path, **keys: object) -> RawMesh:
    return in_own_process(MeshCad(Cad(path, "mm", element_size=1.0, **keys)), Limits(time=60.0))  # type: ignore[arg-type]


def refused(path: Path, text: str) -> str:
    path.write_text(text)
    with pytest.raises(MeshError) as error:
        plain_script(path, lambda merged: merged)
    return str(error.value)


@pytest.mark.parametrize(
    "statement",
    [
        'SystemCall "touch {done}";',
        'System "touch {done}";',
        'NonBlockingSystemCall "touch {done}";',
        'SystemCall Str("touch ", "{done}");',
        'cmd = "touch {done}"; SystemCall cmd;',
        'cmd = "touch {done}"; If (1)\nSystemCall cmd;\nEndIf',
        'For i In {{1:2}} SystemCall "touch {done}"; EndFor',
        'Macro Do\nSystemCall "touch {done}";\nReturn\nCall Do;',
        'Macro Do SystemCall "touch {done}"; Return\nCall Do;',
        'OnelabRun("a", "touch {done}");',
        "/* a */ SystemCall /* b */ 'touch {done}';",
        'SystemCall\n// the command\n"touch {done}";',
        'SomethingNew "touch {done}";',
        "x = 1; y = 2; x y;",
        'Field[1] = ExternalProcess; Field[1].CommandLine = "touch {done}";',
        'Field[1] = StringToName("ExternalProcess");',
        'Field[1] = Structured; Field[1].FileName = "/etc/passwd";',
        'Printf("x") > "{done}";',
        'Printf("%g", 1) >> "{done}";',
        'name = "{done}"; Printf("x") > name;',
        'Print "{done}.png";',
        'Save "{done}.msh";',
        'Save View[0] "{done}";',
        'CreateDir "{done}";',
        'Merge "/etc/passwd";',
        'Merge "../outside.msh";',
        'Merge Str("inside.step");',
        'name = "inside.step"; Merge name;',
        'Include "/etc/passwd";',
        'Include "../outside.geo";',
        'Merge "inside.txt";',
        'ShapeFromFile("/etc/passwd");',
        'l() = ListFromFile("/etc/passwd");',
        "Plugin(MathEval).Run;",
        'Solver.Executable0 = "touch {done}";',
        'General.DefaultFileName = "{done}";',
        'name = "{done}"; General.DefaultFileName = name;',
        'DefineConstant[ a = {{1, Name "a", ServerAction "touch {done}"}} ];',
        'DefineConstant[ a = {{1, Name "a", Macro "touch {done}"}} ];',
        'x = GetEnv("HOME");',
        "Exit;",
        "Abort;",
        'If (0)\na = " EndIf SystemCall ";\n b = "touch {done} EndIf"; EndIf',
        'a = "' + "x" * 2000 + ' SystemCall ";',
        'a = "open',
        "/* open",
        "\0",
        "f\xe9 = 1;",
        "Open\\Project;",
    ],
)
def test_statements_that_do_more_than_a_geometry(statement: str, tmp_path: Path) -> None:
    done = tmp_path / "done"
    (tmp_path / "in").mkdir()
    (tmp_path / "outside.geo").write_text("x = 1;")
    (tmp_path / "outside.msh").write_text("$MeshFormat\n")
    for inside in ("inside.step", "inside.txt"):
        (tmp_path / "in" / inside).write_text("")
    path = tmp_path / "in" / "a.geo"
    message = refused(path, BLOCK + statement.format(done=done))
    assert message.startswith(f"mesh file {path}, line ") and "\n" not in message
    assert not done.exists()


def test_the_line_and_the_statement_are_named(tmp_path: Path) -> None:
    message = refused(tmp_path / "a.geo", BLOCK + '\n// nothing\nSystemCall "true";')
    assert "line 5: SystemCall:" in message and "trust_script = true" in message
    (tmp_path / "part.geo").write_text('\nSystemCall "true";')
    message = refused(tmp_path / "a.geo", BLOCK + 'Include "part.geo";')
    assert f"{tmp_path / 'part.geo'}, line 2: SystemCall" in message
    assert "includes itself" in refused(tmp_path / "a.geo", 'Include "a.geo";')


def test_a_link_out_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "secret.geo").write_text("x = 1;")
    (tmp_path / "in" / "link.geo").symlink_to(tmp_path / "secret.geo")
    message = refused(tmp_path / "in" / "a.geo", 'Include "link.geo";')
    assert "must be a file in the folder of the script" in message


def test_an_ordinary_script_builds_its_geometry(tmp_path: Path) -> None:
    """Variables, loops, macros, conditions, fields, options, included and merged files."""
    (tmp_path / "sizes.geo").write_text("H = 2; // height\nOnelab = 0;")
    (tmp_path / "a.geo").write_text(
        '\ufeff/* a block */ SetFactory("OpenCASCADE");\r\nInclude "sizes.geo";\r\n'
        'DefineConstant[ L = {4, Min 1, Max 9, Step 1, Name "Geometry/Length"} ];\n'
        "Macro Build\n  v = newv; Box(v) = {0, 0, 0, L, H, 1};\nReturn\n"
        'For i In {1:1}\n  If (i > 0 && H == 2)\n    Call Build;\n  Else\n    Error("no");\n'
        '  EndIf\nEndFor\nPrintf("volume %g", v);\n'
        'Physical Volume("block") = {v};\nPhysical Surface(Sprintf("side %g", 1)) = {1};\n'
        'Field[1] = MathEval; Field[1].F = "1.5";\nBackground Field = 1;\n'
        "Mesh.MeshSizeExtendFromBoundary = 0; General.Terminal = 1;\n"
        "Transfinite Curve {1} = 3 Using Progression 1.1;\nMesh 1;\nCoherence;\n",
        "utf-8",
    )
    raw = meshed(tmp_path / "a.geo")
    np.testing.assert_allclose(raw.points.max(axis=0), [4, 2, 1])
    assert set(raw.groups) == {"block"} and "side 1" in raw.facets
    with saved_model(tmp_path / "cube.step"):
        gmsh.model.occ.addBox(0, 0, 0, 3, 3, 3)
        gmsh.model.occ.synchronize()
    (tmp_path / "cube.step.opt").write_text('SystemCall "false";')
    (tmp_path / "b.geo").write_text('Merge "cube.step";')
    np.testing.assert_allclose(meshed(tmp_path / "b.geo").points.max(axis=0), 3)


def test_a_script_that_is_trusted_does_all(tmp_path: Path) -> None:
    done = tmp_path / "done"
    (tmp_path / "a.geo").write_text(BLOCK + f'SystemCall "touch {done}";')
    meshed(tmp_path / "a.geo", trust_script=True)
    assert done.exists()


A_FILE, A_STEP_FILE = FileErrors(Path("a")), FileErrors(Path("a.step"))


@dataclass(frozen=True)
class Escape:
    """What a reader would do that a file has taken over."""

    target: Path
    errors: FileErrors = A_FILE
    advice: str = "none"
    trusted: bool = False

    def fault(self) -> str:
        return ""

    def __call__(self, folder: Path) -> RawMesh:
        os.system(f"touch {self.target}")
        if LANDLOCK:
            with pytest.raises(PermissionError):
                self.target.write_text("x")
        raise MeshError("tried")


def test_what_runs_in_the_other_process_starts_and_writes_nothing(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="tried"):
        in_own_process(Escape(tmp_path / "done"), Limits())
    assert not (tmp_path / "done").exists()


@pytest.mark.parametrize("ending", ["msh", "MSH", "msh2", "unv", "step", "iges", "brep", "stl"])
def test_a_file_is_not_run_whatever_its_ending(ending: str, tmp_path: Path) -> None:
    path, done = tmp_path / f"a.{ending}", tmp_path / "done"
    path.write_text(f'SystemCall "touch {done}";\n{BLOCK}')
    with pytest.raises(MeshError) as error:
        if ending in ("step", "iges", "brep"):
            meshed(path)
        else:
            read_mesh(path, "m", MPI.COMM_SELF)
    assert str(error.value).startswith(f"mesh file {path}: ") and not done.exists()


def test_comments_and_marks_may_stand_before_a_mesh(tmp_path: Path) -> None:
    path, done = tmp_path / "a.msh", tmp_path / "done"
    with saved_model(path):
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [1], name="body")
        gmsh.model.mesh.generate(3)
    (tmp_path / "a.msh.opt").write_text(f'SystemCall "touch {done}";')
    comments = f'\ufeff\n$Comments\nSystemCall "touch {done}";\n$EndComments\n'
    path.write_text(comments + path.read_text(), "utf-8")
    assert "body" in read_mesh(path, "m", MPI.COMM_SELF).cells
    assert not done.exists()


MISSING_2 = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 0 1 0
3 0 0 1
4 1 0 0
$EndNodes
$Elements
2
3 4 2 1 1 1 2 3 4
4 4 2 1 1 2 3 4 77
$EndElements
"""
MISSING_4 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
1 4 1 4
3 1 0 4
1
2
3
4
0 0 0
0 1 0
0 0 1
1 0 0
$EndNodes
$Elements
1 2 1 2
3 1 4 2
1 1 2 3 4
4 2 3 4 77
$EndElements
"""


@pytest.mark.parametrize("text", [MISSING_2, MISSING_4])
def test_the_element_without_its_node_is_named(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text(text)
    with pytest.raises(MeshError) as error:
        read_mesh(tmp_path / "a.msh", "m", MPI.COMM_SELF)
    assert "77" in str(error.value) and "4" in str(error.value)


@dataclass(frozen=True)
class Ends:
    """A reader that ends in a way of its own."""

    way: str
    errors: FileErrors = A_STEP_FILE
    advice: str = "heal it"
    trusted: bool = False

    def fault(self) -> str:
        return ""

    def __call__(self, folder: Path) -> RawMesh:
        if self.way == "signal":
            os.abort()
        if self.way == "exit":
            os._exit(0)
        if self.way == "memory":
            np.ones(2**31)
        if self.way == "defect":
            raise KeyError("x")
        time.sleep(60)
        raise AssertionError


@pytest.mark.parametrize(
    ("way", "words"),
    [
        ("signal", "gmsh or OpenCASCADE crashed on reading (SIGABRT): heal it"),
        ("exit", "gmsh ended on reading with exit code 0 and without a mesh: heal it"),
        ("memory", "GiB of memory, which is the limit mesh.memory"),
        ("defect", "cannot be read: KeyError: 'x': heal it"),
        ("sleep", "took more than 3 s on reading: heal it; or raise mesh.time"),
    ],
)
def test_an_end_without_a_mesh_is_one_line(way: str, words: str) -> None:
    begin = time.monotonic()
    with pytest.raises(MeshError) as error:
        in_own_process(Ends(way), Limits(memory=1.0, time=3.0 if way == "sleep" else 60.0))
    message = one_line(error.value)
    assert message.startswith("mesh.file = a.step: ") and words in message
    assert time.monotonic() - begin < 40
