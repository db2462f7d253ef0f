"""Pictures of bodies: where they are seen from, what is drawn where, and groups before a run."""

from collections.abc import Callable
from pathlib import Path

import matplotlib.text
import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended
from mpi4py import MPI
from PIL import Image

from fenics_nnm.casing import Cone, Frame, LobedRadius, Plane, RadialSurface, Reversed, Surface
from fenics_nnm.fem.mesh_groups import gathered_groups
from fenics_nnm.output.pictures.body import factor_for, plan_mesh
from fenics_nnm.output.pictures.casing_sheet import casing_layers
from fenics_nnm.output.pictures.groups import seen_areas, unhidden
from fenics_nnm.output.pictures.panels import round_below
from fenics_nnm.output.pictures.renderer import render
from fenics_nnm.output.pictures.scene import PLANE, Arrows, Balls, Camera, Faces, Lines, Scene, View
from fenics_nnm.output.pictures.sight import Sight
from fenics_nnm.output.pictures.skin import best_view, skin_around
from fenics_nnm.results.stored_branch import read_stored_branch
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.structure.meshing import tagged_mesh
from fenics_nnm.study import read_study, study_from

#: The beam of tetrahedra.
TETRAHEDRA = {**BEAM, "mesh": {**BEAM["mesh"], "cells": "tetrahedron"}}


def test_view_turns_the_body_without_changing_lengths() -> None:
    for up, upwards in zip("xyz", np.eye(3), strict=True):
        frame = View(elevation=0, azimuth=-90, up=up).frame
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(frame) == pytest.approx(1)
        np.testing.assert_allclose(frame[1], upwards, atol=1e-15)
    np.testing.assert_allclose(PLANE.frame[:2], np.eye(3)[:2], atol=1e-15)
    view = View(25, 40, "y")
    np.testing.assert_allclose(view.opposite.frame[2], -view.frame[2], atol=1e-15)


def red(image: np.ndarray) -> np.ndarray:
    """Where a picture is red."""
    parts = image.astype(int)
    return (parts[:, :, 0] - parts[:, :, 1:].max(axis=2)) > 60


def test_drawn_balls_are_where_the_camera_says() -> None:
    places = np.array([[0.0, 0.0, 0.0], [3.0, 1.0, 0.5]])
    corner = np.array([[-1.0, -2.0, -1.0], [4.0, 2.0, 1.0]])
    views = [PLANE, View(25, -50, "z"), View(-25, 130, "y")]
    cameras = [Camera.around(corner, view, pixels=200) for view in views]
    radius = np.array([0.4])
    asked = [(place, camera) for camera in cameras for place in places]
    scenes = [Scene([Balls(place[None], radius, "red")], camera) for place, camera in asked]
    for (place, camera), image in zip(asked, render(scenes), strict=True):
        width, height = camera.pixels
        assert image.shape == (height, width, 3)
        row, column = np.argwhere(red(image)).mean(axis=0)
        left, right, bottom, top = camera.extent
        found = (
            left + (column + 0.5) / width * (right - left),
            top - (row + 0.5) / height * (top - bottom),
        )
        pixel = (right - left) / width
        np.testing.assert_allclose(found, camera.seen(place[None])[0], atol=1.5 * pixel)
        area = red(image).sum() * pixel**2
        assert area == pytest.approx(np.pi * 0.4**2, rel=0.1)


def test_layers_hide_each_other_as_they_should() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    ring = np.array([[0, 1, 2, 3]])
    camera = Camera.around(square, PLANE, pixels=60)
    plain = {"lit": False}
    white, red_one = Faces(square, ring, "white", **plain), Faces(square, ring, "red", **plain)
    behind = Faces(square - [0, 0, 0.5], ring, "red", **plain)
    line = Lines(np.array([[[0, 0.5, 0], [1, 0.5, 0]]]), "red", 4.0)
    arrow = Arrows(np.array([[0.5, 0.1, 0.2]]), np.array([[0.0, 0.8, 0.0]]), "red")
    layers = [[white, red_one], [red_one, white], [white, behind], [white, line], [white, arrow]]
    shares = [red(image).mean() for image in render([Scene(one, camera) for one in layers])]
    assert shares[0] > 0.8
    assert shares[1] == shares[2] == 0
    assert 0.01 < shares[3] < 0.2
    assert 0.01 < shares[4] < 0.2


def box() -> tuple[np.ndarray, np.ndarray]:
    """Nodes and outward faces of a box of 4 x 1 x 1."""
    nodes = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 4)], dtype=float)
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return nodes, np.array(faces)


def test_best_view_shows_the_contact_surface_and_the_motion() -> None:
    skin = skin_around(*box(), 3)
    up = np.array([[0.0, 0.0, 1.0]])
    sideways = np.zeros((8, 3))
    sideways[:, 0] = 1.0
    view = best_view(skin, up, sideways)
    assert view.up == "z"
    assert view.frame[2] @ up[0] > 0.3  # from the side of the obstacle
    assert abs(view.frame[2][0]) < 0.5  # not along the motion
    assert best_view(skin, -up, sideways).frame[2] @ -up[0] > 0.3
    assert best_view(skin, np.array([[0.0, 1.0, 0.0]])).up == "y"
    facing = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    assert best_view(skin, facing, sideways).up == "z"


def test_clamp_is_seen_in_the_picture_of_the_mesh(
    study_file: Callable[..., Path], command: Callable[..., Ended], tmp_path: Path
) -> None:
    """Clamped at x = 0: from x > 0 a second view is needed, from x < 0 none."""
    energies = {"=": {"energies": {"from": 0.8, "to": 0.9, "step": 0.1}, "report_at": [0.8]}}
    study = study_file(base=BEAM, continuation=energies)
    assert command("run", study, "--output", "out").code == 0
    body = read_stored_branch(tmp_path / "out" / "branch.h5")
    for azimuth, views in ((20, 2), (200, 1)):
        plan = plan_mesh(body, View(20, azimuth))
        assert len(plan.scenes) == views
        assert min(scene.camera.frame[2][0] for scene in plan.scenes) < 0
        plot = plan.finish(render(plan.scenes))
        told = [text.get_text() for text in plot.figure.findobj(matplotlib.text.Text)]
        assert "clamped" in told
        scale = next(text for text in told if text.endswith("m\n")).strip()
        assert f"the scale below it, of {scale}." in plot.caption


def test_enlarged_displacements_are_round_and_seen() -> None:
    assert [round_below(value) for value in (1.0, 1.99, 2.0, 4.9, 7.3, 0.06, 1200.0)] == [
        pytest.approx(value) for value in (1, 1, 2, 2, 5, 0.05, 1000)
    ]
    skin = skin_around(*box(), 3)
    small = np.zeros((8, 3))
    small[0, 1] = 1e-3
    factor = factor_for(skin, [small, 0 * small])
    assert factor == 500  # 0.12 sqrt(18) / 1e-3 = 509
    assert factor_for(skin, [1e4 * small]) == 1
    moved = skin.moved(small, factor)
    assert moved[0, 1] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("base", "measures"),
    [
        (BEAM, {"right": 0.15 * 0.1, "top": 0.15, "front": 0.1}),
        (TETRAHEDRA, {"right": 0.15 * 0.1, "top": 0.15, "front": 0.1}),
        (PLATE, {"right": 0.25, "bottom": 1.0}),
        (ROD, {"right": 1, "left": 1}),
    ],
)
def test_gathered_groups_have_the_area_of_the_body(base: dict, measures: dict) -> None:
    parsed = study_from(dict(base), Path("study.toml"))
    groups = gathered_groups(tagged_mesh(parsed, MPI.COMM_SELF))
    assert groups is not None
    found = {name: measure(groups.nodes[groups.facets[name]]) for name in measures}
    assert found == pytest.approx(measures)
    if groups.dim == 3:
        assert measure(groups.nodes[groups.faces]) == pytest.approx(2 * (0.015 + 0.15 + 0.1))
        corners = groups.nodes[groups.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
        away = corners.mean(axis=1) - groups.nodes.mean(axis=0)
        assert np.all(np.sum(normals * away, axis=1) > 0)
    assert MeshStructure(parsed).outline.roles == {"left": "clamped", "right": "contact"}


@pytest.mark.parametrize("order", [1, 2])
def test_gathered_groups_have_the_corners_of_curved_elements(tmp_path: Path, order: int) -> None:
    """Middle nodes are left out: faces of a box cover it once, whatever the order."""
    box = 'SetFactory("OpenCASCADE"); Box(1) = {0, 0, 0, 2, 1, 0.5};'
    (tmp_path / "box.geo").write_text(box)
    mesh = {"file": "box.geo", "length_unit": "m", "element_size": 0.4, "order": order}
    base = {name: section for name, section in BEAM.items() if name != "mesh"}
    groups = {"left": {"x": 0.0}, "right": {"x": 2.0}}
    parsed = study_from({**base, "mesh": mesh, "groups": groups}, tmp_path / "study.toml")
    found = gathered_groups(tagged_mesh(parsed, MPI.COMM_SELF))
    assert found is not None
    assert found.faces.shape[1] == 3
    assert measure(found.nodes[found.faces]) == pytest.approx(2 * (2 + 1 + 0.5))
    assert measure(found.nodes[found.facets["right"]]) == pytest.approx(0.5)


def measure(corners: np.ndarray) -> float:
    """Area, length or number of facets with corners of shape (f, 1 to 4, 3)."""
    if corners.shape[1] == 1:
        return len(corners)
    if corners.shape[1] == 2:
        return float(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).sum())
    diagonals = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    return float(np.linalg.norm(np.cross(*diagonals), axis=1).sum() / 2)


def test_areas_of_groups_as_they_are_seen() -> None:
    """A cube from its right and above: sine and cosine of the elevation, nothing from behind."""
    groups = gathered_groups(tagged_mesh(study_from(dict(BEAM), Path("s.toml")), MPI.COMM_SELF))
    assert groups is not None
    view = View(elevation=30, azimuth=0)
    camera = Camera.around(groups.nodes, view, pixels=100, slenderness=0.3)
    seen = {n: seen_areas(groups, c, camera).sum() for n, c in groups.facets.items()}
    whole = {name: measure(groups.nodes[corners]) for name, corners in groups.facets.items()}
    assert seen["right"] == pytest.approx(np.cos(np.pi / 6) * whole["right"])
    assert seen["top"] == pytest.approx(np.sin(np.pi / 6) * whole["top"])
    assert seen["left"] == seen["bottom"] == 0


def test_what_another_part_of_the_body_hides_is_not_seen() -> None:
    """Two squares that look upwards, the smaller one 1 m above the middle of the other."""
    square = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    faces = np.stack([2 * square, square + np.array([0.0, 0.0, 1.0])])
    places = np.array([[0.9, 0.3, 0.0], [1.1, 0.3, 0.0], [0.9, 0.3, 1.0]])
    above, beside = PLANE.frame, View(elevation=30, azimuth=-90).frame
    assert [Sight.of(faces, above).hides(place) for place in places] == [True, False, False]
    # a line of sight through the upper square meets the lower one 1.732 m farther back
    rows = np.array([[0.0, y, 0.0] for y in (0.7, 0.75, 1.9)])
    assert [Sight.of(faces, beside).hides(place) for place in rows] == [False, True, True]
    assert not Sight.of(np.empty((0, 3, 3)), above).hides(places[0])
    seen = unhidden(Sight.of(faces, above), np.array([2.0, 2.0, 0.0]), places)
    np.testing.assert_array_equal(seen, [0.0, 2.0, 0.0])


def sheet(surface: Surface, points: np.ndarray, dim: int = 3) -> np.ndarray:
    """Places of a drawn casing, which has an edge."""
    layers = casing_layers(surface, points[:, :dim], 1.0, dim)
    (edge,) = (layer for layer in layers if isinstance(layer, Lines))
    faces = [layer.nodes for layer in layers if isinstance(layer, Faces)]
    assert len(faces) == (1 if dim == 3 else 0)
    assert np.abs(edge.ends[1:, 0] - edge.ends[:-1, 1]).max() == 0
    return np.concatenate([edge.ends.reshape(-1, 3), *faces])


#: Points inside a radius of 0.5 about an axis of x, from 0.1 to 0.9 along it and 60 degrees wide.
PATCH = np.array([[0.1, 0.0, 0.48], [0.9, 0.0, 0.47], [0.5, 0.24, 0.4157], [0.5, -0.24, 0.4157]])
ALONG_X = Frame(np.zeros(3), np.array([2.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))


@pytest.mark.parametrize(("slope", "lobe"), [(0.0, 0.0), (-0.2, 0.0), (0.0, 0.02)])
@pytest.mark.parametrize("outside", [False, True])
def test_sheets_lie_on_round_casings_and_beyond_their_patch(
    slope: float, lobe: float, outside: bool
) -> None:
    cone = Cone(ALONG_X, 0.5, slope)
    surface = RadialSurface(ALONG_X, LobedRadius((0.5,), 8, lobe)) if lobe else cone
    places = sheet(Reversed(surface) if outside else surface, PATCH)
    angle = np.arctan2(places[:, 2], places[:, 1])
    radius = 0.5 + slope * places[:, 0] + lobe * np.cos(8 * angle)
    np.testing.assert_allclose(np.hypot(places[:, 1], places[:, 2]), radius, rtol=1e-12)
    assert (places[:, 0].min(), places[:, 0].max()) == pytest.approx((-0.1, 1.1))
    wide = np.degrees(np.ptp(angle))
    assert wide == pytest.approx(1.5 * 60, abs=0.1)


def test_sheets_end_where_a_casing_does_and_go_all_around_it() -> None:
    pointed = sheet(Cone(ALONG_X, 0.5, -0.5), PATCH)
    assert 0.95 < pointed[:, 0].max() < 1
    known = LobedRadius((0.5, 0.5), 3, 0.01, stations=(0.0, 1.0))
    assert np.ptp(sheet(RadialSurface(ALONG_X, known), PATCH)[:, 0]) == pytest.approx(1)
    turns = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    ring = np.column_stack([turns / 10, 0.4 * np.cos(turns), 0.4 * np.sin(turns)])
    around = sheet(Cone(ALONG_X, 0.5), ring)
    np.testing.assert_allclose(np.ptp(around[:, 1:], axis=0), 1, rtol=1e-3)


def test_sheets_of_planes_and_lines_in_the_plane() -> None:
    slanted = Plane(np.array([0.0, 0.0, 0.6]), np.array([0.0, 3.0, 4.0]))
    places = sheet(slanted, PATCH)
    np.testing.assert_allclose(places @ [0, 0.6, 0.8], 0.48, rtol=1e-12)
    assert (places[:, 0].min(), places[:, 0].max()) == pytest.approx((-0.1, 1.1), abs=0.05)
    wall = sheet(Plane(np.array([0.0, 0.6, 0.0]), np.array([0.0, 1.0, 0.0])), PATCH, dim=2)
    np.testing.assert_allclose(wall[:, 1:], [[0.6, 0]] * len(wall), atol=1e-15)
    assert np.ptp(wall[:, 0]) == pytest.approx(1.2)
    upright = Frame(np.array([0.5, 0.0, 0.3]), np.array([0.0, 0.0, -1.0]))
    arc = sheet(Cone(upright, 2.0, 0.1), PATCH + np.array([0, 1.0, 0]), dim=2)
    np.testing.assert_allclose(arc[:, 2], 0, atol=1e-15)
    np.testing.assert_allclose(np.hypot(arc[:, 0] - 0.5, arc[:, 1]), 2.0 + 0.1 * 0.3, rtol=1e-12)


def test_check_draws_the_casing(
    tmp_path: Path, study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    """A wall beside the tip is seen around the patch, and told in the legend."""
    contact = {name: value for name, value in BEAM["contact"].items() if name != "gap"}
    contact["casing"] = {"shape": "plane", "origin": [0, 0, 0.2], "normal": [0, 0, 1]}
    contact["direction"] = [0.0, 0.0, 1.0]
    path = study_file(base={**BEAM, "contact": contact})
    told = command("check", path, "--picture", tmp_path / "mesh.svg")
    assert told.code == 0, told.err
    parsed = read_study(path)
    assert list(MeshStructure(parsed).outline.casings) == [0]
    command("check", path, "--picture", tmp_path / "mesh.png")
    with Image.open(tmp_path / "mesh.png") as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    brown = (pixels[:, :, 0] - pixels[:, :, 2] > 10) & (pixels[:, :, 0] > 180)
    assert brown.mean() > 0.02


def test_check_draws_the_groups(
    tmp_path: Path, study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    picture = tmp_path / "mesh.png"
    ended = command("check", study_file(base=BEAM), "--picture", picture)
    assert ended.code == 0, ended.err
    assert str(picture) in ended.out.splitlines()[-1]
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    # the group in contact has its own colour, vermilion as in the legend
    vermilion = np.abs(pixels - [213, 94, 0]).max(axis=2) < 12
    assert vermilion.mean() > 2e-4


def test_check_shows_the_groups_of_a_study_that_cannot_be_run(
    tmp_path: Path, study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    path = study_file(base=PLATE, contact={"facets": "top"})  # its corner is clamped
    ended = command("check", path, "--picture", tmp_path / "mesh.png")
    ended.assert_one_line(2, "clamped", "mesh.png shows its groups")
    assert (tmp_path / "mesh.png").stat().st_size > 10_000


def test_bad_pictures_are_one_line(
    tmp_path: Path, study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    path = study_file()
    command("check", path, "--picture", "mesh.jpg").assert_one_line(2, "mesh.jpg", ".png")
    ended = command("check", path, "--picture", tmp_path / "none" / "mesh.png")
    assert ended.code == 1
    assert "cannot be written" in ended.err and len(ended.err.splitlines()) == 1
