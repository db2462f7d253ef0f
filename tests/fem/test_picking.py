"""Groups picked by place: areas against closed forms, and what is said of a pick that fails."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, changed
from mpi4py import MPI
from small_meshes import saved_model

from fenics_nnm.errors import MeshError, StudyError
from fenics_nnm.fem.boundary import boundary
from fenics_nnm.structure.meshing import tagged_mesh
from fenics_nnm.study import study_from

RADIUS, LENGTH = 0.25, 1.0


def picked(base: dict[str, Any], group: dict[str, Any], mesh: dict[str, Any] | None = None) -> Any:
    """Areas, centres and normals of the facets that a group picks."""
    mesh = base["mesh"] if mesh is None else mesh
    study = changed(base, {"mesh": {"=": mesh}, "groups": {"picked": group}})
    tagged = tagged_mesh(study_from(study, Path("study.toml")), MPI.COMM_SELF)
    surface = boundary(tagged.mesh)
    chosen = surface.mask(tagged.facets["picked"]) != 0
    return surface.areas[chosen], surface.centres[chosen], surface.normals[chosen]


def cylinder(path: Path, order: int, size: float) -> dict[str, Any]:
    """A mesh file of a cylinder along z, and the keys of its study."""
    with saved_model(path):
        gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, LENGTH, RADIUS)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [1], name="body")
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
    return {"file": str(path), "length_unit": "m"}


BOX = [
    ({"x": 0.0}, 0.15 * 0.1, (0.0, 0.075, 0.05), (-1.0, 0.0, 0.0)),
    ({"z": 0.1}, 0.15 * 1.0, (0.5, 0.075, 0.1), (0.0, 0.0, 1.0)),
    ({"plane": {"point": [9.0, 0.15, 7.0], "normal": "y"}}, 0.1, (0.5, 0.15, 0.05), (0, 1.0, 0)),
    ({"facing": {"direction": "-y"}}, 0.1, (0.5, 0.0, 0.05), (0.0, -1.0, 0.0)),
    ({"facing": {"direction": [1.0, 0.1, 0.0]}}, 0.015, (1.0, 0.075, 0.05), (1.0, 0.0, 0.0)),
    ({"nearest": {"point": [0.4, 0.08, 0.3]}}, 0.15, (0.5, 0.075, 0.1), (0.0, 0.0, 1.0)),
    (
        {"box": {"from": [0.3, -1.0, 0.05], "to": [0.7, 1.0, 1.0]}, "facing": {"direction": "z"}},
        0.05,
        (0.5, 0.075, 0.1),
        (0.0, 0.0, 1.0),
    ),
    (
        {"facets": "top", "box": {"from": [-1.0, -1.0, -1.0], "to": [0.4, 1.0, 1.0]}},
        0.05,
        (1 / 6, 0.075, 0.1),
        (0.0, 0.0, 1.0),
    ),
    (
        {"radii": {"axis": "x", "from": 0.0, "to": 0.5}, "x": 1.0},
        0.015,
        (1, 0.075, 0.05),
        (1, 0, 0),
    ),
]


@pytest.mark.parametrize("cells", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize(("group", "area", "centre", "normal"), BOX)
def test_faces_of_a_box(
    group: dict[str, Any], area: float, centre: Any, normal: Any, cells: str
) -> None:
    areas, centres, normals = picked(BEAM, group, {**BEAM["mesh"], "cells": cells})
    assert areas.sum() == pytest.approx(area, rel=1e-12)
    np.testing.assert_allclose(areas @ centres / area, centre, atol=1e-12)
    np.testing.assert_allclose(normals, np.broadcast_to(normal, normals.shape), atol=1e-12)


def test_edges_of_a_plate_and_the_end_of_a_rod() -> None:
    areas, centres, normals = picked(PLATE, {"y": 0.25})
    assert areas.sum() == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(normals, [[0.0, 1.0]] * 4, atol=1e-14)
    edge, *_ = picked(PLATE, {"nearest": {"point": [1.1, 0.2]}})
    assert edge.sum() == pytest.approx(0.25, rel=1e-14)
    areas, centres, normals = picked(ROD, {"x": 1.0})
    assert (areas.tolist(), centres.tolist(), normals.tolist()) == ([1.0], [[1.0]], [[1.0]])
    _, centres, _ = picked(ROD, {"nearest": {"point": [0.2]}})
    assert centres.tolist() == [[0.0]]


@pytest.mark.parametrize(("order", "rate"), [(1, 2), (2, 4)])
def test_area_of_a_cylinder_converges(order: int, rate: int, tmp_path: Path) -> None:
    """Its side picked by radius and by the nearest point."""
    exact = 2 * np.pi * RADIUS * LENGTH
    group = {"cylinder": {"axis": "z", "radius": RADIUS}}
    errors = []
    for size in (0.1, 0.05):
        mesh = cylinder(tmp_path / f"{size}.msh", order, size)
        areas, centres, normals = picked(BEAM, group, mesh)
        errors.append(abs(areas.sum() / exact - 1))
        outward = centres[:, :2] / np.linalg.norm(centres[:, :2], axis=1, keepdims=True)
        assert np.sum(outward * normals[:, :2], axis=1).min() > 0.99
        near = {"nearest": {"point": [RADIUS, 0.0, LENGTH / 2], "angle": 60}}
        assert picked(BEAM, near, mesh)[0].sum() == pytest.approx(areas.sum(), rel=1e-12)
        end = picked(BEAM, {"z": 0.0}, mesh)[0].sum()
        assert end == pytest.approx(np.pi * RADIUS**2, rel=0.2 / order**4)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(rate, abs=0.2)


EMPTY = [
    ({"x": 0.3}, "x = 0.3: x of the surface runs from 0 to 1 m (0 facets by itself)"),
    ({"x": 0.0, "z": 0.1}, "x = 0: x of the surface runs from 0 to 1 m (1 facets by itself)"),
    ({"cylinder": {"axis": "x", "radius": 2.0}}, "radius 2 m: the radius of the surface runs"),
    ({"facing": {"direction": [1.0, 1.0, 0.0]}}, "the nearest normal is 45 degrees away"),
    ({"box": {"from": [2.0, 2.0, 2.0], "to": [3.0, 3.0, 3.0]}}, "the surface is from [0, 0, 0]"),
    ({"plane": {"point": [0.0, 0.0], "normal": "x"}}, "point = [0, 0]: must have 3 components"),
    ({"faces": [3]}, 'groups.picked.faces = "face 3": the mesh has no such group'),
    ({"facets": "nothing"}, 'groups.picked.facets = "nothing": the mesh has no such group'),
]


@pytest.mark.parametrize(("group", "words"), EMPTY)
def test_empty_pick_says_what_is_near(group: dict[str, Any], words: str) -> None:
    with pytest.raises(MeshError) as error:
        picked(BEAM, group)
    assert words in str(error.value)
    assert "groups.picked" in str(error.value)


def test_pick_with_the_name_of_a_group_is_refused() -> None:
    study = changed(BEAM, {"groups": {"left": {"x": 1.0}}})
    with pytest.raises(MeshError, match=r"groups\.left: the mesh has a group of that name"):
        tagged_mesh(study_from(study, Path("study.toml")), MPI.COMM_SELF)


BAD = [
    ({"tip": {}}, "groups.tip: must have at least one of x, y, z, plane"),
    ({"Tip": {"x": "far"}}, 'groups.Tip.x = "far": must be a number'),
    ({"tip": {"xx": 1.0}}, "groups.tip.xx: unknown key"),
    ({"tip": {"plane": {"normal": "x"}}}, "groups.tip.plane.point: is missing"),
    ({"tip": {"facing": {"direction": [0.0, 0.0, 0.0]}}}, "direction = [0.0, 0.0, 0.0]: must not"),
    (
        {"tip": {"radii": {"axis": "x", "from": 2.0, "to": 1.0}}},
        "from = 2 m: must not be above to = 1 m",
    ),
    ({"tip": 3}, "groups.tip = 3: must be a section with conditions"),
    ({"tip": {"faces": []}}, "groups.tip.faces"),
]


@pytest.mark.parametrize(("groups", "words"), BAD)
def test_wrong_keys_of_a_pick(groups: dict[str, Any], words: str) -> None:
    with pytest.raises(StudyError) as error:
        study_from(changed(BEAM, {"groups": {"=": groups}}), Path("study.toml"))
    assert words in str(error.value)
    assert "\n" not in str(error.value)
