"""Meshes that cannot be used end with one line that says why."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import small_meshes
from conftest import BEAM, PLATE, ROD, Ended

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

FILE = {"=": {"file": "mesh.msh", "length_unit": "m"}}

BAD = [
    ("missing", PLATE, ["mesh.file = ", "there is no such file"]),
    ("folder", PLATE, ["mesh.file = ", "is not a file"]),
    ("empty", PLATE, ["mesh.file = ", "holds no mesh: is empty"]),
    ("garbage", PLATE, ["mesh.file = ", "gmsh cannot read it"]),
    ("truncated", PLATE, ["mesh.file = ", "gmsh cannot read it"]),
    (
        "no groups",
        PLATE,
        ['clamp.facets = "left"', "it has none", "[groups.left]", "lies in [0, 1]"],
    ),
    ("no facet groups", PLATE, ['clamp.facets = "left"', "it has none"]),
    ("no body", PLATE, ["dimension 1", "the body needs a physical group too"]),
    ("flat", PLATE, ["1 degenerate elements", "number 3 at (0, 0, 0)"]),
    ("shell", PLATE, ["dimension 2", "leaves the x-y plane", "no shells"]),
    ("curved rod", ROD, ["dimension 1", "leaves the x axis", "curved beams"]),
]


@pytest.mark.parametrize("action", ["run", "check"])
@pytest.mark.parametrize(("kind", "base", "words"), BAD, ids=[kind for kind, *_ in BAD])
def test_bad_mesh(
    action: str,
    kind: str,
    base: dict[str, Any],
    words: list[str],
    study_file: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    small_meshes.MAKERS[kind](tmp_path / "mesh.msh")
    before = sorted(tmp_path.iterdir())
    study = study_file(base, mesh=FILE)
    ended = command(action, study)
    ended.assert_one_line(2, *words)
    assert kind in ("no facet groups", "no groups") or str(tmp_path / "mesh.msh") in ended.err
    assert sorted(tmp_path.iterdir()) == sorted([*before, study])


SURFACE = [
    ("middle", "2 facets lie inside the body"),
    (["right", "middle"], "2 facets lie inside the body"),
    (["right", "nothing"], 'contact.facets = "nothing"'),
    ("body", 'it has "left", "middle", "right"'),
]


@pytest.mark.parametrize(("facets", "words"), SURFACE)
def test_contact_facets_must_be_on_the_surface(
    facets: Any, words: str, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    small_meshes.square(tmp_path / "mesh.msh")
    study = study_file(PLATE, mesh=FILE, contact={"facets": facets})
    command("run", study).assert_one_line(2, "contact.facets", words)


@pytest.mark.parametrize(("dim", "base", "rigid"), [(1, ROD, 1), (2, PLATE, 3), (3, BEAM, 6)])
def test_part_that_nothing_holds(
    dim: int,
    base: dict[str, Any],
    rigid: int,
    study_file: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    """The clamp holds one of two parts; the other one is free, as by nodes that are not shared."""
    small_meshes.loose_part(tmp_path / "mesh.msh", dim)
    study = study_file(base, mesh=FILE, reduction={"modes": 4})
    ended = command("check", study)
    ended.assert_one_line(2, f"{rigid} rigid-body modes found", "not held", "clamp.facets")


def test_good_mesh_file_is_read(study_file: StudyFile, command: Command, tmp_path: Path) -> None:
    """What the other tests spoil does run, and gmsh keeps quiet."""
    small_meshes.square(tmp_path / "mesh.msh")
    ended = command("run", study_file(PLATE, mesh=FILE), "--output", "results")
    assert (ended.code, ended.err) == (0, "")
    assert "Info" not in ended.out
    assert (tmp_path / "results" / "backbone.csv").exists()


@pytest.mark.parametrize("base", [ROD, PLATE, BEAM], ids=["rod", "plate", "beam"])
def test_built_in_geometries_are_quiet(
    base: dict[str, Any], study_file: StudyFile, command: Command
) -> None:
    ended = command("check", study_file(base))
    assert (ended.code, ended.err) == (0, "")
    assert ended.out.startswith(base["title"])
    assert "Info" not in ended.out
