"""Linear mode shapes with their frequencies, and the obstacle beside a motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import BEAM, changed, toml
from matplotlib.figure import Figure

from fenics_nnm.cli import main
from fenics_nnm.output.pictures.animation import _size
from fenics_nnm.output.pictures.body import view_of
from fenics_nnm.output.pictures.linear_shapes import plan_linear
from fenics_nnm.output.pictures.obstacle import obstacle_layers, obstacle_sheets
from fenics_nnm.output.pictures.panels import without_bands
from fenics_nnm.output.pictures.results import Results, read_results
from fenics_nnm.output.pictures.scene import Faces
from fenics_nnm.output.pictures.style import new_figure
from fenics_nnm.results.stored_branch import StoredBranch


@pytest.fixture(scope="module")
def beam(tmp_path_factory: pytest.TempPathFactory) -> Results:
    folder = tmp_path_factory.mktemp("beam")
    (folder / "study.toml").write_text(toml(BEAM))
    assert main(["run", str(folder / "study.toml"), "--output", str(folder / "out")]) == 0
    return read_results(folder / "out")


def low_and_high(places: np.ndarray) -> np.ndarray:
    return np.array([places.min(axis=0), places.max(axis=0)])


def body_of(results: Results) -> StoredBranch:
    assert results.body is not None
    return results.body


@pytest.mark.parametrize("factor", [1.0, 20.0])
def test_the_obstacle_is_where_the_gap_ends(beam: Results, factor: float) -> None:
    """The end of the beam can touch above it: its facets moved up by the gap of 1 mm."""
    body = body_of(beam)
    (sheet,) = obstacle_layers(beam, body, factor)
    assert isinstance(sheet, Faces)
    corners = np.unique(sheet.corners)
    assert len(corners) == len(sheet.nodes)
    end = body.nodes[np.isclose(body.nodes[:, 0], 1.0)]
    middle, moved = (low_and_high(each).mean(axis=0) for each in (end, sheet.nodes))
    np.testing.assert_allclose(moved - middle, [0, 0, factor * 1e-3], atol=1e-9)
    widths = [np.ptp(low_and_high(each), axis=0)[1] for each in (end, sheet.nodes)]
    assert widths[0] == pytest.approx(widths[1])
    assert np.ptp(sheet.nodes[:, 2]) > 0.1  # wide enough to be seen


def in_casing(results: Results, casing: dict, gap: np.ndarray) -> Results:
    """The same results with a casing in the study, and other gaps."""
    study = changed(BEAM, {"contact": {"gap": None, "casing": casing}})
    header = replace(results.header, study=toml(study), model=replace(results.model, gap=gap))
    return replace(results, header=header)


def test_a_casing_is_drawn_where_it_is_beyond_its_patch(beam: Results) -> None:
    """A plane above the beam: at true size it is at its place; its gap grows with the factor."""
    body = body_of(beam)
    height = 1.01 * float(body.nodes[:, 2].max())
    gap = height - body.contact_points[:, 2]
    plane = {"shape": "plane", "origin": [0.0, 0.0, height], "normal": [0.0, 0.0, 1.0]}
    results = in_casing(beam, plane, gap)
    (sheet,) = obstacle_sheets(results, body)
    np.testing.assert_allclose(sheet.at(1.0)[:, 2], height, atol=1e-12)
    raised = sheet.at(20.0)[:, 2] - height
    assert raised.min() > 19 * gap.min() - 1e-12 and raised.max() < 19 * gap.max() + 1e-12
    end = np.ptp(body.contact_points, axis=0)
    assert (np.ptp(sheet.at(1.0), axis=0)[:2] > end[:2]).all()
    (layer,) = obstacle_layers(results, body, 1.0)
    assert isinstance(layer, Faces) and layer.corners.shape[1] == 4


def test_of_a_casing_whose_table_is_gone_the_patch_is_drawn(beam: Results) -> None:
    body = body_of(beam)
    table = {"shape": "table", "axis": "x", "file": "gone.csv", "origin": [0.0, 0.0, 1.0]}
    (sheet,) = obstacle_sheets(in_casing(beam, table, beam.model.gap), body)
    (patch,) = obstacle_sheets(beam, body)
    np.testing.assert_array_equal(sheet.at(2.0), patch.at(2.0))


def test_frames_of_slender_bodies_have_no_empty_side() -> None:
    for slenderness in (0.4, 1.0, 2.0, 5.0):
        height, width = _size(slenderness)
        panel = (height - 0.7) / slenderness
        assert width <= max(panel + 1.2, 3.2) + 1e-12
        assert 3.2 <= width <= 4.6 and height < 6


def blank(figure: Figure) -> float:
    """Largest part of the height of a figure that is left blank about a panel."""
    figure.draw_without_rendering()
    panels = [axes for axes in figure.axes if axes.images]
    slots = [axes.get_position(original=True).height for axes in panels]
    return max(slot - axes.get_position().height for slot, axes in zip(slots, panels, strict=True))


@pytest.mark.parametrize("tall", [True, False])
def test_rows_of_panels_have_no_blank_bands_between_them(tall: bool) -> None:
    figure = new_figure(9.0)
    image = np.zeros((60, 40) if tall else (10, 80))
    for axes in figure.subplots(2, 2).flat:
        axes.imshow(image)
        axes.set_title("mode")
    assert blank(figure) > 0.05
    without_bands(figure)
    width, height = figure.get_size_inches()
    assert 0.42 * width <= height < 8.5
    assert blank(figure) < 0.02 or (not tall and height == pytest.approx(0.42 * width))


def test_linear_modes_are_drawn_with_their_frequencies(beam: Results) -> None:
    body = body_of(beam)
    (plan,) = plan_linear(beam, body, view_of(body, beam.shown[-1], beam.tip))
    hertz = beam.summary["linear_frequencies_Hz"]
    assert len(plan.scenes) == len(hertz) > 1
    for scene in plan.scenes:
        (faces,) = (layer for layer in scene.layers if isinstance(layer, Faces))
        assert faces.values is not None
        assert faces.values.max() == pytest.approx(1.0, abs=1e-3) and faces.values.min() >= 0.0
    plot = plan.finish([np.zeros((60, 80, 3), dtype=np.uint8)] * len(hertz))
    titles = [axes.get_title() for axes in plot.figure.axes]
    assert titles[: len(hertz)] == [f"mode {n + 1}\n{f:.5g} Hz" for n, f in enumerate(hertz)]


def test_shapes_of_other_reductions_are_no_linear_modes(beam: Results, tmp_path: Path) -> None:
    body = body_of(beam)
    view = view_of(body, beam.shown[-1], beam.tip)
    unknown = Results(beam.header, beam.points, {}, body, beam.areas, beam.tip)
    assert plan_linear(unknown, body, view) == []
