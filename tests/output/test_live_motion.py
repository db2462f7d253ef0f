"""The motion to turn and to play in a report: its numbers, its scene, and what may run there."""

from __future__ import annotations

import base64
import gzip
import hashlib
import io
import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from web_page import Element, read_page

from fenics_nnm.output.html_report.page import Section, page
from fenics_nnm.output.live_motion import figure, library
from fenics_nnm.output.live_motion.coarser import coarser
from fenics_nnm.output.live_motion.figure import live_figure
from fenics_nnm.output.live_motion.library import Library
from fenics_nnm.output.live_motion.motion import INSTANTS, live_motion, written
from fenics_nnm.output.live_motion.scene import Part, scene_file
from fenics_nnm.output.live_motion.waves import waves_of
from fenics_nnm.output.pictures.obstacle import obstacle_sheets
from fenics_nnm.output.pictures.results import Results, read_results

#: A finished run of a rod whose right end can touch.
ROD = Path(__file__).parents[1] / "reference" / "branch_6" / "finished"

#: What stands for vtk.js.
SHORT = Library("window.OfflineLocalView={}", "vtk.js --> of a test")


@pytest.fixture(scope="module")
def rod() -> Results:
    return read_results(ROD)


def test_few_shapes_give_the_motion_at_any_time() -> None:
    """Two shapes, one of them with a third harmonic; between the instants as well."""
    rng = np.random.default_rng(1)
    first, second = rng.normal(size=(2, 7, 3))

    def moved(phase: np.ndarray) -> np.ndarray:
        course = np.cos(phase), 0.2 + 0.3 * np.sin(3 * phase)
        return course[0][:, None, None] * first + course[1][:, None, None] * second

    waves = waves_of(moved(2 * np.pi * np.arange(16) / 16))
    phase = np.array([0.1, 1.0, 4.5])
    assert len(waves.shapes) == 2
    np.testing.assert_allclose(waves.at(phase), moved(phase), atol=1e-12)


def test_shapes_that_nobody_sees_are_left_out() -> None:
    rng = np.random.default_rng(2)
    phase = 2 * np.pi * np.arange(32) / 32
    large, small = rng.normal(size=(2, 20, 3))
    moved = np.cos(phase)[:, None, None] * large + 1e-5 * np.sin(phase)[:, None, None] * small
    waves = waves_of(moved)
    assert len(waves.shapes) == 1
    assert np.abs(waves.at(phase) - moved).max() < 2e-3 * np.abs(moved).max()


def test_a_body_at_rest_has_a_motion_of_zeros() -> None:
    waves = waves_of(np.zeros((8, 3, 3)))
    assert not waves.at(np.array([0.0, 1.0])).any()


def square(count: int) -> tuple[np.ndarray, np.ndarray]:
    """A square of 1 m in quadrangles."""
    side = np.linspace(0, 1, count + 1)
    places = np.stack([*np.meshgrid(side, side, indexing="ij"), np.zeros((count + 1,) * 2)], axis=2)
    number = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    corners = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    return places.reshape(-1, 3), np.stack([each.ravel() for each in corners], axis=1)


def test_a_coarser_surface_has_few_nodes_and_still_covers_the_body() -> None:
    places, faces = square(40)
    kept, fewer = coarser(places, faces, 200)
    assert len(kept) <= 200 and len(np.unique(kept)) == len(kept)
    corners = places[kept][fewer]
    assert np.ptp(corners.reshape(-1, 3), axis=0)[:2].min() > 0.9
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    areas = np.linalg.norm(np.cross(*diagonals), axis=1) / 2
    assert areas.sum() == pytest.approx(1.0, rel=0.15)
    same, all_faces = coarser(places, faces, 2000)
    assert len(same) == len(places) and all_faces is faces


def test_the_page_has_the_motion_of_the_point(rod: Results) -> None:
    """Rounded shapes times their courses are the displacements; contact is where forces are."""
    assert rod.body is not None
    point = rod.chosen[-1]
    motion = live_motion(rod, rod.body, point)
    told = written(motion)
    shapes = np.frombuffer(base64.b64decode(told["shapes"]), "<i2")
    shapes = shapes.reshape(len(told["scale"]), -1, 3) * np.array(told["scale"])[:, None, None]
    time = 0.137
    angle = 2 * np.pi * time * np.arange(len(told["cos"]))
    course = np.cos(angle) @ told["cos"] + np.sin(angle) @ told["sin"]
    moved = np.tensordot(course, shapes, 1)[-1, 0]  # the contact point at the end of the rod
    phase = np.array([2 * np.pi * time + rod.middle(point) - np.pi])
    node = rod.body.contact_nodes
    exact = rod.body.displacement(point, phase, node)[0, 0, 0]
    assert moved == pytest.approx(exact, abs=3e-3 * told["largest"])
    largest = np.abs(rod.body.largest_displacement(point)).max()
    assert told["largest"] == pytest.approx(largest, rel=1e-2)
    pressed = np.frombuffer(base64.b64decode(told["pressed"]), np.uint8).reshape(INSTANTS, 1) >> 7
    assert pressed.mean() == pytest.approx(point.motion.contact_fraction, abs=2 / INSTANTS)
    assert pressed[INSTANTS // 2, 0]  # the middle of contact


def test_the_obstacle_of_a_rod_is_a_line_across_its_end(rod: Results) -> None:
    assert rod.body is not None
    (sheet,) = obstacle_sheets(rod, rod.body)
    assert sheet.corners.tolist() == [[0, 1]]
    np.testing.assert_allclose(sheet.at(20.0)[:, 0], 1.0 + 20.0 * rod.model.gap[0])
    assert np.ptp(sheet.at(1.0)[:, 1]) > 0.06  # beyond the strip that the rod is drawn as


def test_large_surfaces_are_drawn_coarser_and_say_so(
    rod: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fenics_nnm.output.live_motion.motion.MOST_BYTES", 400)
    assert rod.body is not None
    motion = live_motion(rod, rod.body, rod.chosen[-1])
    assert motion.coarser and motion.surface_nodes < 18
    monkeypatch.setattr(figure, "installed_library", lambda: SHORT)
    assert f"drawn with {motion.surface_nodes} of its nodes" in live_figure(rod)[0]


def test_a_scene_has_its_parts_with_their_arrays() -> None:
    places, faces = square(1)
    parts = [
        Part(places, faces, "polys", {"ambient": 0.5}, coloured=True),
        Part(places, np.array([[0, 1]]), "lines"),
    ]
    with zipfile.ZipFile(io.BytesIO(scene_file(parts))) as file:
        state = json.loads(file.read("index.json"))
    (renderer,) = state["scene"]["dependencies"]
    assert [each["type"] for each in renderer["dependencies"]] == ["vtkActor"] * 2
    mapper, look = renderer["dependencies"][0]["dependencies"]
    assert look["properties"] == {"ambient": 0.5}
    properties = mapper["dependencies"][0]["properties"]

    def read(name: str, kind: str) -> np.ndarray:
        contents = state["hashes"][properties[name]["hash"]]["content"]
        return np.frombuffer(base64.b64decode(contents), kind)

    np.testing.assert_allclose(read("points", "<f4").reshape(-1, 3), places)
    assert read("polys", "<u4").tolist() == [4, *faces[0]]
    assert properties["fields"][0]["registration"] == "setScalars"


def shown(results: Results) -> Element:
    """A page with the live motion alone."""
    live, scripts = live_figure(results)
    section = Section("motion", "Motion", (live,))
    return read_page(
        page(title="", kicker="", generator="", footer="", sections=[section], scripts=scripts)
    )


def test_only_the_scripts_of_the_page_may_run(
    rod: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Browsers compare digests: of the script in the page, and of vtk.js that it unpacks."""
    monkeypatch.setattr(figure, "installed_library", lambda: SHORT)
    found = shown(rod)
    (policy,) = (
        meta.attributes["content"]
        for meta in found.all("meta")
        if meta.attributes.get("http-equiv") == "Content-Security-Policy"
    )
    (allowed,) = re.findall(r"script-src ([^;]*)", policy)
    scripts = found.all("script")
    (own,) = (each.text for each in scripts if "type" not in each.attributes)
    kept = {e.attributes["id"]: e.text for e in scripts if "type" in e.attributes}
    packed = gzip.decompress(base64.b64decode(kept["live-library"])).decode()
    digests = [hashlib.sha256(text.encode()).digest() for text in (own, packed)]
    assert allowed.split() == [f"'sha256-{base64.b64encode(each).decode()}'" for each in digests]
    assert packed == SHORT.script and not any("src" in e.attributes for e in scripts)
    assert json.loads(kept["live-motion"])["surface"] == 18
    (drawing,) = (e for e in found.all("figure"))
    assert "hidden" in drawing.attributes  # until a script shows it


def test_what_the_script_reads_is_in_the_page(
    rod: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(figure, "installed_library", lambda: SHORT)
    found = shown(rod)
    (own,) = (e.text for e in found.all("script") if "type" not in e.attributes)
    (motion,) = (e.text for e in found.all("script") if e.attributes.get("id") == "live-motion")
    everything = [found]
    for element in everything:
        everything += element.inside
    names = {e.attributes.get("id") for e in everything}
    assert {f"live-{name}" for name in re.findall(r'\bat\("(\w+)"\)', own)} <= names
    assert set(re.findall(r"motion\.(\w+)", own)) <= set(json.loads(motion))


def test_without_vtk_js_there_is_no_live_motion(
    rod: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(library, "_PACKAGE", "no-such-package-of-vtk-js")
    assert library.installed_library() is None
    assert live_figure(rod) == ("", ())


def test_a_package_without_what_is_needed_counts_as_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(library, "_PACKAGE", "h5py")  # a package that is there
    for name, text in (("none.html", None), ("other.html", '<script type="module">1</script>')):
        if text is not None:
            (tmp_path / name).write_text(text)
        monkeypatch.setattr(library, "_PAGE", str(tmp_path / name))
        assert library.installed_library() is None
    good = 'x<script type="module">window.OfflineLocalView={};</script>'
    (tmp_path / "good.html").write_text(good)
    monkeypatch.setattr(library, "_PAGE", str(tmp_path / "good.html"))
    found = library.installed_library()
    assert found is not None and found.script == "window.OfflineLocalView={};"
