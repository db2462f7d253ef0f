"""The mesh that results keep: --resume goes on with it, though its file and gmsh have changed."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import h5py
import numpy as np
import pytest
from conftest import Ended, toml
from ranks import on_ranks

from fenics_nnm.cli import main
from fenics_nnm.errors import MeshError
from fenics_nnm.fem import mesh as fem_mesh
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.kept_mesh import mesh_as_read
from fenics_nnm.fem.raw_mesh import RawMesh, arrays_of, raw_of
from fenics_nnm.output.html_report import origin
from fenics_nnm.results.branch_file import read
from fenics_nnm.results.kept_mesh import kept_mesh
from fenics_nnm.results.seal import break_seal

Command = Callable[..., Ended]

#: A cube and a wedge behind it, which are split into tetrahedra on reading.
BODY = """*NODE, NSET=all
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
9, 2, 0, 0
10, 2, 1, 0
*ELEMENT, TYPE=C3D8
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D6
2, 2, 9, 6, 3, 10, 7
*NSET, NSET=root
1, 4, 5, 8
"""

STUDY: dict[str, Any] = {
    "mesh": {"file": "a.inp", "length_unit": "cm"},
    "body": {"theory": "solid", "degree": 1},
    "material": {"young": 2.1e11, "poisson": 0.3, "density": 7800.0},
    "clamp": {"facets": "root"},
    "contact": {"facets": "slope", "direction": [0.0, 0.0, 1.0], "gap": 1e-4, "points": 3},
    "reduction": {"modes": 2},
    "mode": {"harmonics": 3, "samples": 32},
    "continuation": {"energies": {"from": 0.8, "to": 1.1, "step": 0.1}},
}

SLOPE = """
[groups.slope]
facing = { direction = [1.0, 0.0, 1.0], angle = 10 }
"""

NOTE = "1 hexahedra and 1 prisms are split into 9 tetrahedra"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a study that was run into `out`."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "a.inp").write_text(BODY)
    (folder / "s.toml").write_text(toml(STUDY) + SLOPE)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(["run", "s.toml", "--output", "out"]) == 0
    return folder


@pytest.fixture
def ran(made: Path, tmp_path: Path, command: Command) -> Command:
    """The command line in a copy of that folder."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    return command


def without_meshing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*arguments: object) -> None:
        raise MeshError("meshed again")

    monkeypatch.setattr(fem_mesh, "in_own_process", refused)


def farther(folder: Path) -> None:
    """The same study with one point more."""
    study = folder / "s.toml"
    study.write_text(study.read_text().replace("1.1", "1.2"))


def test_notes_of_the_mesh_are_in_summary_and_report(ran: Command, tmp_path: Path) -> None:
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert NOTE in summary["mesh_notes"]
    assert summary["facet_groups"] == {"all": 16, "root": 2, "slope": 2}
    section = origin.study_file(Mock(summary=summary, header=Mock(study="")))
    assert any(NOTE in str(part) for part in section.content)


def test_resume_needs_neither_mesh_file_nor_gmsh(
    ran: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: Any
) -> None:
    header, before = read(tmp_path / "out" / "branch.h5")
    with h5py.File(tmp_path / "out" / "branch.h5") as file:
        kept = {name: values[:] for name, values in file["input_mesh"].items()}
        cells = file["mesh/cells"][:]
    (tmp_path / "a.inp").unlink()
    without_meshing(monkeypatch)
    farther(tmp_path)
    ended = ran("run", "s.toml", "--output", "out", "--resume")
    assert ended.code == 0, ended.err
    assert f"mesh file: {NOTE}" in caplog.text
    again, after = read(tmp_path / "out" / "branch.h5")
    assert [point.gamma_ratio for point in after] == pytest.approx([0.8, 0.9, 1.0, 1.1, 1.2])
    for one, other in zip(before, after, strict=False):
        assert one.motion.frequency == other.motion.frequency
    for name in ("omega", "Phi", "R", "gap"):
        assert np.array_equal(getattr(header.model, name), getattr(again.model, name))
    with h5py.File(tmp_path / "out" / "branch.h5") as file:
        assert np.array_equal(file["mesh/cells"][:], cells)
        assert set(file["input_mesh"]) == set(kept)
        for name, values in kept.items():
            assert np.array_equal(file["input_mesh"][name][:], values), name


def test_two_ranks_go_on_with_a_kept_mesh(ran: Command, tmp_path: Path) -> None:
    (tmp_path / "a.inp").unlink()
    farther(tmp_path)
    ended = on_ranks(
        2, "-m", "fenics_nnm", "run", "s.toml", "--output", "out", "--resume", folder=tmp_path
    )
    assert ended.code == 0, ended.err
    assert len(read(tmp_path / "out" / "branch.h5")[1]) == 5


def test_a_mesh_file_that_has_changed_is_read(ran: Command, tmp_path: Path) -> None:
    """The same body with a comment more is that of the points, another one is not."""
    file = tmp_path / "a.inp"
    file.write_text(BODY + "** a comment\n")
    assert ran("run", "s.toml", "--output", "out", "--resume").code == 0
    file.write_text(BODY.replace("9, 2, 0, 0", "9, 2.5, 0, 0"))
    ended = ran("run", "s.toml", "--output", "out", "--resume")
    assert ended.code == 2
    assert "its points cannot be taken over, as linear frequency 1 was" in ended.err


def test_a_mesh_in_several_files_is_read(ran: Command, tmp_path: Path) -> None:
    """The digest of the file that is named says nothing of those that it includes."""
    path, files = tmp_path / "out" / "branch.h5", {"mesh.file": tmp_path / "a.inp"}
    header, _ = read(path)
    assert kept_mesh(path, header, dict(header.inputs), files) is not None
    files["mesh.file"].write_text("*INCLUDE, INPUT=b.inp\n")
    assert kept_mesh(path, header, dict(header.inputs), files) is None


def test_results_of_earlier_versions_have_none(ran: Command, tmp_path: Path) -> None:
    path = tmp_path / "out" / "branch.h5"
    break_seal(path)
    with h5py.File(path, "r+") as file:
        del file["input_mesh"], file.attrs["inputs"]
    farther(tmp_path)
    assert ran("run", "s.toml", "--output", "out", "--resume").code == 0
    assert len(read(path)[1]) == 5


def raw(**changes: Any) -> RawMesh:
    """Two triangles with all that a mesh can have."""
    known: dict[str, Any] = {
        "cell_type": 2,
        "dim": 2,
        "points": np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]),
        "cells": np.array([[0, 1, 2], [1, 3, 2]]),
        "facets": {"left": np.array([[0, 2]]), "none": np.empty((0, 2), dtype=np.int64)},
        "groups": {"one": np.array([1])},
        "nodes": {"corner": np.array([3])},
        "attached": (Attachment("CONM2 7", "mass", (1.0, 1.0), (0.0, 1.0)),),
        "notes": ("said",),
    }
    return RawMesh(**{**known, **changes})


def test_a_mesh_comes_back_as_it_was() -> None:
    kept = mesh_as_read(raw(), 1e-3)
    assert kept.arrays["cells"].dtype == np.int32
    back = raw_of(kept.arrays)
    assert back.cells.dtype == np.int64
    assert mesh_as_read(back, 1e-3).digest == kept.digest
    for name, values in arrays_of(raw()).items():
        assert np.array_equal(arrays_of(back)[name], values)
    assert (back.attached, back.notes, list(back.facets)) == (
        raw().attached,
        ("said",),
        ["left", "none"],
    )
    for other in (raw(notes=()), raw(cells=np.array([[0, 1, 2], [2, 1, 3]]))):
        assert mesh_as_read(other, 1e-3).digest != kept.digest
    assert mesh_as_read(raw(), 1e-2).digest != kept.digest


def test_rows_that_are_not_there_are_refused() -> None:
    with pytest.raises(IndexError, match="outside of 0 to 3"):
        raw_of(arrays_of(raw(cells=np.array([[0, 1, 4]]))))
    with pytest.raises(IndexError, match="outside of 0 to 1"):
        raw_of(arrays_of(raw(groups={"one": np.array([-1])})))
