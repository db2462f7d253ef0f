"""Pictures of bodies: where they are seen from, what is drawn where, and groups before a run."""

from collections.abc import Callable
from pathlib import Path

import matplotlib.text
import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended
from mpi4py import MPI
from PIL import Image

from fenics_nnm.analysis import tagged_mesh
from fenics_nnm.fem.mesh_groups import gathered_groups
from fenics_nnm.output.pictures.body import factor_for, plan_mesh
from fenics_nnm.output.pictures.groups import roles_of
from fenics_nnm.output.pictures.panels import round_below
from fenics_nnm.output.pictures.renderer import render
from fenics_nnm.output.pictures.scene import PLANE, Arrows, Balls, Camera, Faces, Lines, Scene, View
from fenics_nnm.output.pictures.skin import best_view, skin_around
from fenics_nnm.output.stored_branch import read_stored_branch
from fenics_nnm.study import study_from

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
    assert roles_of(parsed) == {"left": "clamped", "right": "contact"}


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
