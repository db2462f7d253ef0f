"""Geometries of STEP, IGES, BREP and .geo files: units, sizes, groups, and a run from picks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from conftest import BEAM, PLATE, Ended, changed
from mpi4py import MPI
from small_meshes import saved_model

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.boundary import boundary
from fenics_nnm.fem.cad_units import declared_unit
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.structure.meshing import tagged_mesh
from fenics_nnm.study import study_from
from fenics_nnm.study.error_keys import in_keys

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: A block of 100 x 40 x 20 with a hole of radius 8 along z, in the unit of the file.
RADIUS = 8.0
HOLE = {"axis": "z", "origin": [0.07, 0.02, 0.0], "radius": RADIUS / 1000}
GROUPS = {"root": {"x": 0.0}, "tip": {"x": 0.1}, "hole": {"cylinder": HOLE}}


def block(path: Path, scale: float = 1.0) -> Path:
    with saved_model(path):
        occ = gmsh.model.occ
        cut = occ.addCylinder(70, 20, -1, 0, 0, 30, RADIUS)
        occ.cut([(3, occ.addBox(0, 0, 0, 100, 40, 20))], [(3, cut)])
        occ.dilate(occ.getEntities(3), 0, 0, 0, scale, scale, scale)
        occ.synchronize()
    return path


def two_blocks(path: Path, gap: float = 0.0) -> Path:
    """Blocks of 10 x 10 x 10 that share a face, overlap or are apart."""
    with saved_model(path):
        for x in (0.0, 10.0 + gap):
            gmsh.model.occ.addBox(x, 0, 0, 10, 10, 10)
        gmsh.model.occ.synchronize()
    return path


def mesh_of(path: Path, groups: dict[str, Any] | None = None, **keys: Any) -> TaggedMesh:
    given = {"file": str(path), "length_unit": "mm", "element_size": 10.0, **keys}
    mesh = {key: value for key, value in given.items() if value is not None}
    study = changed(BEAM, {"mesh": {"=": mesh}, "groups": {"=": groups or {}}})
    return tagged_mesh(study_from(study, Path("study.toml")), MPI.COMM_SELF)


def areas(tagged: TaggedMesh) -> dict[str, float]:
    surface = boundary(tagged.mesh)
    return {
        name: float(surface.areas[surface.mask(facets) != 0].sum())
        for name, facets in tagged.facets.items()
    }


@pytest.mark.parametrize("ending", ["step", "iges", "brep"])
def test_areas_of_a_block_with_a_hole(ending: str, tmp_path: Path, capfd: Any) -> None:
    path = block(tmp_path / f"block.{ending}")
    capfd.readouterr()
    found = areas(mesh_of(path, GROUPS, order=2))
    assert capfd.readouterr() == ("", "")
    assert found["root"] == pytest.approx(8e-4, rel=1e-9)
    assert found["tip"] == pytest.approx(8e-4, rel=1e-9)
    side = 2 * np.pi * RADIUS * 20e-6
    assert found["hole"] == pytest.approx(side, rel=2e-3)
    by_number = sorted(area for name, area in found.items() if name.startswith("face "))
    flat = 4e-3 - np.pi * RADIUS**2 * 1e-6
    expected = sorted([8e-4, 8e-4, side, 2e-3, 2e-3, flat, flat])
    np.testing.assert_allclose(by_number, expected, rtol=2e-3)


def test_faces_by_number_are_those_of_check(tmp_path: Path) -> None:
    path = block(tmp_path / "block.step")
    tagged = mesh_of(path, {"both": {"faces": [1, 7]}})
    expected = np.union1d(tagged.facets["face 1"], tagged.facets["face 7"])
    np.testing.assert_array_equal(tagged.facets["both"], expected)


def test_elements_are_smaller_at_a_picked_group(tmp_path: Path) -> None:
    """Named in the study alone: it is found on a first mesh."""
    path = block(tmp_path / "block.step")
    refine = [{"facets": ["tip"], "size": 2.5, "distance": 15.0}]
    tagged = mesh_of(path, GROUPS, element_size=10.0, refine=refine)
    surface = boundary(tagged.mesh)
    tip = surface.mask(tagged.facets["tip"]) != 0
    root = surface.mask(tagged.facets["root"]) != 0
    assert np.median(surface.sizes[tip]) == pytest.approx(2.5e-3, rel=0.3)
    assert np.median(surface.sizes[root]) > 7e-3
    plain = mesh_of(path, GROUPS, curvature=24)
    surface = boundary(plain.mesh)
    hole = surface.mask(plain.facets["hole"]) != 0
    assert areas(plain)["hole"] == pytest.approx(2 * np.pi * RADIUS * 20e-6, rel=1.2e-2)
    assert hole.sum() > 48


@pytest.mark.parametrize("ending", ["step", "iges"])
@pytest.mark.parametrize("unit", ["m", "in"])
def test_declared_units(ending: str, unit: str, tmp_path: Path) -> None:
    """The numbers of the file are in the unit it declares, whatever OpenCASCADE makes of them."""
    scale = 1e-3 if (ending, unit) == ("iges", "m") else 1.0
    path = block(tmp_path / f"block.{ending}", scale)
    text = path.read_text()
    if ending == "step":
        inch = (
            "( CONVERSION_BASED_UNIT('INCH',#99991) LENGTH_UNIT() NAMED_UNIT(#99992) );\n"
            "#99991 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#99993);\n"
            "#99992 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
            "#99993 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"
        )
        metre = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.) );"
        old = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"
        new = {"m": metre, "in": inch}[unit]
    else:
        old, new = ",1.,2,2HMM,1,", {"m": ",1.,6,1HM,01,", "in": ",1.,1,2HIN,1,"}[unit]
    assert old in text
    path.write_text(text.replace(old, new))
    sizes = np.array([100, 40, 20]) * scale
    metres = {"m": 1.0, "in": 0.0254}[unit]
    tagged = mesh_of(path, length_unit=unit, element_size=10.0 * scale)
    np.testing.assert_allclose(tagged.mesh.geometry.x.max(axis=0), sizes * metres, rtol=1e-5)
    with pytest.raises(MeshError) as error:
        mesh_of(path)
    message = in_keys(error.value)
    assert f'declares "{unit}": must be that' in message and "ignore_declared_unit" in message
    assert f"{0.1 * scale:.4g} x {0.04 * scale:.4g}" in message
    tagged = mesh_of(path, ignore_declared_unit=True, element_size=10.0 * scale)
    np.testing.assert_allclose(tagged.mesh.geometry.x.max(axis=0), sizes / 1000, rtol=1e-5)


@pytest.mark.parametrize(
    ("declared", "unit", "metres"),
    [(",1.,3,2HIN,1,", "in", 0.0254), (",1.,7,2HKM,1,", "mm", 1000.0)],
)
def test_units_by_name_and_unknown_ones(
    declared: str, unit: str, metres: float, tmp_path: Path
) -> None:
    """An unknown one is converted to mm: no other unit is taken then for its numbers."""
    path = block(tmp_path / "block.iges")
    path.write_text(path.read_text().replace(",1.,2,2HMM,1,", declared))
    size = 100 * metres / {"in": 0.0254, "mm": 0.001}[unit]
    tagged = mesh_of(path, length_unit=unit, element_size=size)
    assert tagged.mesh.geometry.x[:, 0].max() == pytest.approx(100 * metres, rel=1e-5)
    with pytest.raises(MeshError, match=f'declares "{unit}": must be that'):
        mesh_of(path, length_unit="ft", element_size=size)


@pytest.mark.parametrize(
    ("names", "unit"),
    [
        (["INCHES"], "in"),
        (["IN."], "in"),
        (["CUBIT"], "mm"),
        (["INCH", "FOOT"], "mm"),
        ([], "m"),
    ],
)
def test_units_of_step_files_under_other_names(names: list[str], unit: str, tmp_path: Path) -> None:
    entity = "#1 = ( {}LENGTH_UNIT() NAMED_UNIT(*) {});\n"
    lines = [entity.format(f"CONVERSION_BASED_UNIT('{name}',#9) ", "") for name in names]
    path = tmp_path / "a.step"
    path.write_text("".join([*lines, entity.format("", "SI_UNIT($,.METRE.) ")]))
    assert declared_unit(path) == unit


def test_solids_that_touch_share_nodes(tmp_path: Path) -> None:
    tagged = mesh_of(two_blocks(tmp_path / "two.step"), element_size=5.0)
    surface = boundary(tagged.mesh)
    assert surface.areas.sum() == pytest.approx(10 * 1e-4, rel=1e-9)  # nothing of the joint
    parts = [name for name in tagged.cells if name != "body"]
    assert len(parts) == 2
    cells = tagged.mesh.topology.index_map(3).size_local
    assert sum(len(tagged.cells[name]) for name in parts) == len(tagged.cells["body"]) == cells
    apart = boundary(mesh_of(two_blocks(tmp_path / "far.step", 1.0), element_size=5.0).mesh)
    assert apart.areas.sum() == pytest.approx(12 * 1e-4, rel=1e-9)


GEO = """
SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 1, 0.25};
Mesh.MeshSizeMax = 0.25;
"""


def test_geo_file(tmp_path: Path) -> None:
    """Its own sizes and groups; all edges are numbered besides."""
    path = tmp_path / "plate.geo"
    path.write_text(GEO + 'Physical Surface("body") = {1};\nPhysical Curve("left") = {4};\n')
    tagged = mesh_of(path, length_unit="m", element_size=None)
    assert tagged.dim == 2 and set(tagged.cells) == {"body"}
    found = areas(tagged)
    assert found["left"] == found["edge 4"] == pytest.approx(0.25, rel=1e-12)
    finer = mesh_of(path, length_unit="m", element_size=0.05)
    assert finer.mesh.geometry.x.shape[0] > 2 * tagged.mesh.geometry.x.shape[0]
    path.write_text(GEO)
    assert set(mesh_of(path, length_unit="m", element_size=None).cells) == {"body"}


def test_bytes_that_are_no_text_do_not_spoil_later_files(tmp_path: Path) -> None:
    """Given to gmsh, a zero byte would leave its parser unusable."""
    (tmp_path / "noise.geo").write_bytes(bytes(range(256)))
    with pytest.raises(MeshError, match="is neither a mesh nor text"):
        mesh_of(tmp_path / "noise.geo", length_unit="m", element_size=None)
    path = tmp_path / "plate.geo"
    path.write_text(GEO)
    assert set(mesh_of(path, length_unit="m", element_size=None).cells) == {"body"}


def test_run_of_a_step_file_from_picks(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    block(tmp_path / "block.step")
    mesh = {"file": "block.step", "length_unit": "mm", "element_size": 20.0}
    study = study_file(
        BEAM,
        mesh={"=": mesh},
        groups={"root": {"x": 0.0}, "tip": {"x": 0.1}},
        clamp={"facets": "root"},
        contact={"facets": "tip", "points": 2},
        body={"degree": 1},
    )
    ended = command("check", study)
    assert (ended.code, ended.err) == (0, "")
    assert "[0, 0.1] x [0, 0.04] x [0, 0.02] m" in ended.out
    lines = {line.split("  ")[0]: line for line in ended.out.splitlines()}
    assert "0.0008   (0.1, 0.02, 0.01), [0.1, 0.1] x [0, 0.04] x [0, 0.02]" in lines["tip"]
    assert "face 7" in lines
    ended = command("run", study, "--output", "results")
    assert (ended.code, ended.err) == (0, "")
    assert (tmp_path / "results" / "backbone.csv").exists()


BAD = [
    (lambda path: None, {}, ["there is no such file"]),
    (lambda path: path.mkdir(), {}, ["is not a file"]),
    (lambda path: path.write_text("nonsense"), {}, ["gmsh cannot read it"]),
    (lambda path: two_blocks(path, -5.0), {}, ["solids overlap"]),
    (block, {"length_unit": "m"}, ['length_unit = "m"', "0.1 x 0.04 x 0.02 m", "100 x 40 x 20 m"]),
    (block, {"element_size": 0.01}, ["element_size = 0.01", "elements", "larger than 0.45"]),
    (block, {"element_size": 1e-300}, ["element_size = 1e-300", "elements", "than 0.45"]),
    (
        block,
        {"refine": [{"facets": "face 1", "size": 0.01, "distance": 5.0}]},
        ["mesh.refine.size = 0.01", "elements within 5 of the facets: must be larger"],
    ),
    (block, {"element_size": None}, ["mesh.element_size: is missing"]),
    (block, {"order": 3}, ["mesh.order = 3", "1: straight"]),
    (
        block,
        {"refine": [{"facets": "top", "size": 1.0, "distance": 5.0}]},
        ['mesh.refine.facets = "top"', "no such group"],
    ),
    (
        block,
        {"refine": [{"facets": "face 1", "size": 30.0, "distance": 5.0}]},
        ["refine.size = 30", "must be below element_size = 10"],
    ),
]


@pytest.mark.parametrize(("make", "keys", "words"), BAD)
def test_bad_geometry(
    make: Callable[[Path], Any],
    keys: dict[str, Any],
    words: list[str],
    study_file: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    make(tmp_path / "body.step")
    mesh = {"file": "body.step", "length_unit": "mm", "element_size": 10.0, **keys}
    mesh = {key: value for key, value in mesh.items() if value is not None}
    command("check", study_file(BEAM, mesh={"=": mesh})).assert_one_line(2, *words)


@pytest.mark.parametrize("ending", ["brep", "step"])
def test_faces_that_close_are_a_solid(ending: str, tmp_path: Path) -> None:
    """As of a surface model."""
    path = tmp_path / f"closed.{ending}"
    with saved_model(path):
        box = gmsh.model.occ.addBox(0, 0, 0, 100, 100, 100)
        gmsh.model.occ.remove([(3, box)])
        gmsh.model.occ.synchronize()
    tagged = mesh_of(path, element_size=50.0)
    assert tagged.dim == 3
    assert boundary(tagged.mesh).areas.sum() == pytest.approx(0.06, rel=1e-12)


def test_faces_that_close_to_no_solid(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    with saved_model(tmp_path / "open.brep"):
        box = gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.remove([(3, box)])
        gmsh.model.occ.remove([(2, 1)])
        gmsh.model.occ.synchronize()
    mesh = {"file": "open.brep", "length_unit": "m", "element_size": 0.5}
    ended = command("check", study_file(BEAM, mesh={"=": mesh}))
    ended.assert_one_line(2, "5 faces", "close to no solid")


def test_faces_beside_a_solid_are_told(tmp_path: Path) -> None:
    """They are no part of the body: a blade of surfaces on a disk that is a solid would be lost."""
    with saved_model(tmp_path / "sheet.step"):
        gmsh.model.occ.addBox(0, 0, 0, 100, 100, 100)
        gmsh.model.occ.addRectangle(0, 0, 200, 100, 50)
        gmsh.model.occ.synchronize()
    tagged = mesh_of(tmp_path / "sheet.step", element_size=50.0)
    assert tagged.notes == (
        "1 face that bounds no solid is left out, the first about (50, 25, 200) in the file",
    )
    assert mesh_of(block(tmp_path / "block.step")).notes == ()


def test_mesh_keys_of_a_geometry_are_refused_for_a_mesh(
    study_file: StudyFile, command: Command
) -> None:
    mesh = {"file": "a.msh", "length_unit": "m", "element_size": 1.0}
    ended = command("check", study_file(PLATE, mesh={"=": mesh}))
    ended.assert_one_line(2, "mesh.element_size: belongs to a geometry (.step, .stp")
