"""Two ranks: the same results as one, and an end of all ranks where one of them fails."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import small_meshes
from conftest import BEAM, PLATE, Ended
from fork_mesh import fork, fork_study
from ranks import SAME_FIELD, field_differences, on_ranks, own_lines, row_differences, rows

from fenics_nnm.results import branch_file

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

FAILING = """
import sys
from mpi4py import MPI
import fenics_nnm.fem.parallel
import fenics_nnm.running.publishing
import fenics_nnm.structure.mesh_structure
from fenics_nnm.cli import main
from fenics_nnm.errors import StudyError

def fail(*arguments, **keywords):
    raise {error}

if MPI.COMM_WORLD.rank in {ranks}:
    fenics_nnm.{name} = fail
if {ranks} != [0, 1]:  # the other never comes
    fenics_nnm.fem.parallel.all_arrive.__kwdefaults__["seconds"] = 1.0
sys.exit(main(sys.argv[1:]))
"""


GROUPS = """
import sys
from pathlib import Path
from mpi4py import MPI
from fenics_nnm.structure.meshing import tagged_mesh
from fenics_nnm.structure.group_table import group_table
from fenics_nnm.study import read_study

text = group_table(tagged_mesh(read_study(Path(sys.argv[1])), MPI.COMM_WORLD))
if MPI.COMM_WORLD.rank == 0:
    print("\\n".join(text))
"""


def failing_script(folder: Path, **values: Any) -> Path:
    path = folder / "failing.py"
    path.write_text(FAILING.format(**values))
    return path


def assert_same_fields(one: Path, two: Path) -> None:
    assert len(list(one.rglob("*.vtu"))) == 3 + 2 * 24  # modes, shapes, peaks, two motions
    apart = field_differences(one, two)
    assert {name: value for name, value in apart.items() if value > SAME_FIELD} == {}


@pytest.mark.parametrize(
    ("base", "changes"),
    [
        (PLATE, {"mesh": {"elements": [8, 2]}, "reduction": {"modes": 3}}),
        (BEAM, {"mesh": {"elements": [4, 1, 2]}, "contact": {"points": 3}}),
        (PLATE, {"mesh": {"elements": [8, 2]}, "reduction": {"method": "none", "modes": 3}}),
    ],
    ids=["plate", "beam", "full order"],
)
def test_two_ranks_give_the_backbone_of_one(
    base: dict[str, Any],
    changes: dict[str, Any],
    study_file: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    study = study_file(base, **changes)
    assert command("run", study, "--output", "one").code == 0
    ended = on_ranks(2, "-m", "fenics_nnm", "run", study, "--output", "two", folder=tmp_path)
    assert ended.code == 0, ended.err
    assert ended.out.count("results in two") == 1  # of all ranks the first one prints
    assert len(own_lines(ended)) <= 1  # a warning is told once
    tables = (tmp_path / name / "backbone.csv" for name in ("one", "two"))
    assert row_differences(*tables) == {}
    _, one = branch_file.read(tmp_path / "one" / "branch.h5")
    assert len(one) == len(rows(tmp_path / "two" / "backbone.csv")) == 4
    assert_same_fields(tmp_path / "one" / "fields", tmp_path / "two" / "fields")


SEVERAL: list[dict[str, Any]] = [
    {"name": "tines", "facets": "left tine", "against": "right tine"},
    {
        "name": "stop",
        "facets": "right tine",
        "direction": [0.0, 1.0],
        "points": 2,
        "rows": "averaged",
        "casing": {"shape": "cylinder", "axis": "z", "radius": 0.2},
    },
]


def test_two_ranks_have_the_same_patches(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """The tines are on both ranks, and each row of facing patches may be, too."""
    fork(tmp_path / "fork.msh", right=9)
    values = fork_study(tmp_path / "fork.msh", patch=SEVERAL)
    values["reduction"]["modes"] = 3
    values["continuation"] = {"energies": {"from": 0.9, "to": 1.1, "step": 0.1}, "shooting": False}
    study = study_file(values)
    assert command("run", study, "--output", "one").code == 0
    ended = on_ranks(2, "-m", "fenics_nnm", "run", study, "--output", "two", folder=tmp_path)
    assert ended.code == 0, ended.err
    one, two = (branch_file.read(tmp_path / name / "branch.h5") for name in ("one", "two"))
    np.testing.assert_allclose(two[0].model.R, one[0].model.R, rtol=1e-9)
    np.testing.assert_allclose(np.abs(two[0].model.Phi), np.abs(one[0].model.Phi), atol=1e-7)
    assert [point.motion.frequency for point in two[1]] == pytest.approx(
        [point.motion.frequency for point in one[1]], rel=1e-8
    )
    with h5py.File(tmp_path / "one/branch.h5") as a, h5py.File(tmp_path / "two/branch.h5") as b:
        for name in ("points", "directions", "areas", "patches", "patch_names"):
            np.testing.assert_array_equal(a["contact"][name][:], b["contact"][name][:])
        np.testing.assert_allclose(a["model/gap"][:], b["model/gap"][:], rtol=1e-13)


def test_check_prints_once(study_file: StudyFile, command: Command, tmp_path: Path) -> None:
    study = study_file(PLATE)
    alone = command("check", study)
    ended = on_ranks(2, "-m", "fenics_nnm", "check", study, folder=tmp_path)
    assert (ended.code, own_lines(ended)) == (0, [])
    assert ended.out.count("degrees of freedom") == 1
    assert ended.out.splitlines()[:6] == alone.out.splitlines()[:6]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"material": {"young": -1.0}}, "material.young = -1.0"),
        ({"clamp": {"facets": "lefft"}}, 'clamp.facets = "lefft"'),
        ({"clamp": None}, "3 rigid-body modes"),
        ({"contact": {"facets": "top"}}, "must not touch the clamp"),
        ({"reduction": {"modes": 46}}, "residual flexibility"),
        ({"output": {"folder": "study.toml"}}, "output folder study.toml"),
    ],
)
def test_bad_input_is_told_once(
    changes: dict[str, Any], words: str, study_file: StudyFile, tmp_path: Path
) -> None:
    study = study_file(PLATE, **changes)
    ended = on_ranks(2, "-m", "fenics_nnm", "run", study, folder=tmp_path)
    assert ended.code == 2, ended.err
    (line,) = own_lines(ended)
    assert words in line and "rank" not in line and "Traceback" not in ended.err
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


def test_bad_mesh_is_told_once(study_file: StudyFile, tmp_path: Path) -> None:
    small_meshes.square(tmp_path / "mesh.msh")
    mesh = {"=": {"file": "mesh.msh", "length_unit": "m"}}
    study = study_file(PLATE, mesh=mesh, contact={"facets": "middle"})
    ended = on_ranks(2, "-m", "fenics_nnm", "run", study, folder=tmp_path)
    assert ended.code == 2, ended.err
    (line,) = own_lines(ended)
    assert "2 facets lie inside the body" in line


def test_picked_groups_are_the_same(study_file: StudyFile, tmp_path: Path) -> None:
    """Also those that elements are made smaller at, and those of a face that ranks share."""
    with small_meshes.saved_model(tmp_path / "body.step"):
        small_meshes.gmsh.model.occ.addCylinder(0, 0, 0, 100, 0, 0, 10)
        small_meshes.gmsh.model.occ.synchronize()
    refine = [{"facets": "tip", "size": 3.0, "distance": 20.0}]
    mesh = {"file": "body.step", "length_unit": "mm", "element_size": 8.0, "refine": refine}
    groups = {
        "root": {"x": 0.0},
        "tip": {"nearest": {"point": [0.1, 0.0, 0.0]}},
        "side": {"cylinder": {"axis": "x", "radius": 0.01}},
    }
    study = study_file(
        BEAM, mesh={"=": mesh}, groups=groups, clamp={"facets": "root"}, contact={"facets": "tip"}
    )
    (tmp_path / "groups.py").write_text(GROUPS)
    told = [on_ranks(n, "groups.py", study, folder=tmp_path) for n in (1, 2)]
    assert [ended.code for ended in told] == [0, 0], told[1].err
    tables = [ended.out for ended in told]
    assert tables[0] == tables[1]
    assert all(name in tables[0] for name in groups)


@pytest.mark.parametrize("rank", [0, 1])
@pytest.mark.parametrize(
    "name",
    [
        "resolution.auto.linear_analysis",
        "structure.mesh_structure.gathered_basis",
        "running.publishing.write_linear_modes",
    ],
)
def test_failure_of_one_rank_ends_all(
    rank: int, name: str, study_file: StudyFile, tmp_path: Path
) -> None:
    """The other rank waits in a collective call that will never be answered."""
    error = 'ZeroDivisionError("by zero")'
    script = failing_script(tmp_path, name=name, error=error, ranks=[rank])
    assert_ends_all(rank, script, study_file(PLATE), tmp_path)


@pytest.mark.parametrize("rank", [0, 1])
@pytest.mark.parametrize(
    ("name", "error", "code"),
    [
        ("fem.ordered.solved", 'StudyError("of one rank")', 2),
        ("fem.harmonic.solved", 'ZeroDivisionError("by zero")', 1),
    ],
)
def test_failure_of_one_rank_in_a_solve_ends_all(
    rank: int, name: str, error: str, code: int, study_file: StudyFile, tmp_path: Path
) -> None:
    """The factorisation cannot be freed, for which both ranks would have to come."""
    script = failing_script(tmp_path, name=name, error=error, ranks=[rank])
    study = study_file(PLATE, reduction={"method": "none", "modes": 3})
    assert_ends_all(rank, script, study, tmp_path, code, error.split('"')[1])


def assert_ends_all(
    rank: int, script: Path, study: Path, folder: Path, code: int = 1, words: str = "by zero"
) -> None:
    ended = on_ranks(2, script, "run", study, "--output", "out", folder=folder, seconds=60)
    assert ended.code == code, ended.err
    (line,) = own_lines(ended)
    assert f"fenics-nnm: rank {rank}: " in line and words in line
    assert "Traceback" not in ended.err


def test_failure_of_all_ranks_is_told_once(study_file: StudyFile, tmp_path: Path) -> None:
    error = 'ZeroDivisionError("by zero")'
    script = failing_script(
        tmp_path, name="running.publishing.write_linear_modes", error=error, ranks=[0, 1]
    )
    ended = on_ranks(2, script, "run", study_file(PLATE), "--output", "out", folder=tmp_path)
    assert ended.code == 1, ended.err
    (line,) = own_lines(ended)
    assert "rank" not in line and "4 points are in out" in line
    assert len(branch_file.read(tmp_path / "out" / "branch.h5")[1]) == 4
