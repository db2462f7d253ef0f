"""Pictures of a results folder: their list, their files, and the numbers behind them."""

import json
import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import matplotlib.image
import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed, toml
from PIL import Image

from fenics_nnm.backbone.point import FloquetStability
from fenics_nnm.cli import main
from fenics_nnm.files.cache import VARIABLE
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.output.gallery import MANIFEST, _all_saved, make_pictures
from fenics_nnm.output.motion_measures import harmonic_shares, kinetic_shares
from fenics_nnm.output.picture import Picture
from fenics_nnm.output.pictures.amplitude import amplitude_of
from fenics_nnm.output.pictures.animation import FRAMES
from fenics_nnm.output.pictures.contact import contact_order, contact_pressure, touching_shares
from fenics_nnm.output.pictures.multipliers import multiplier_plots
from fenics_nnm.output.pictures.results import Results, read_results
from fenics_nnm.output.pictures.shares import share_plots
from fenics_nnm.output.pictures.space_time import cross_sections
from fenics_nnm.output.pictures.style import Plot, colours_of_parts, save, unit_for
from fenics_nnm.results.branch_file import BranchHeader


def ran(folder: Path, base: dict, **changes: object) -> Path:
    """Results of a study with some keys changed."""
    (folder / "study.toml").write_text(toml(changed(base, changes)))
    assert main(["run", str(folder / "study.toml"), "--output", str(folder / "out")]) == 0
    return folder / "out"


@pytest.fixture(scope="module")
def rod(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return ran(tmp_path_factory.mktemp("rod"), ROD)


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    finer = {"harmonics": 20, "samples": 128}  # with 3 harmonics contact is not believed
    return ran(tmp_path_factory.mktemp("plate"), changed(PLATE, {"mode": finer}))


def listed(folder: Path) -> list[dict]:
    return json.loads((folder / MANIFEST).read_text())["pictures"]


@pytest.fixture(scope="module")
def drawn(plate: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All pictures of the plate, in a folder that was not there."""
    folder = tmp_path_factory.mktemp("drawn") / "new" / "folder"
    pictures = make_pictures(plate, folder, formats=["png", "svg"])
    assert [each["file"] for each in listed(folder)] == [picture.file for picture in pictures]
    return folder


def test_list_names_each_file_with_a_caption_and_its_units(drawn: Path) -> None:
    found = listed(drawn)
    files = [name for each in found for name in (each["file"], *each["also"])]
    assert sorted(files) == sorted({path.name for path in drawn.iterdir()} - {MANIFEST})
    assert {each["group"] for each in found} == {
        "frequency",
        "contact",
        "motion",
        "accuracy",
        "body",
        "linear",
    }
    for each in found:
        assert each["title"] and each["caption"].endswith(".")
        units = ("Hz", "mm", "MPa", "(%)", "no unit", " kN ", " of 0.2 m.")
        assert any(unit in each["caption"] for unit in units), each


def test_no_picture_is_blank(drawn: Path) -> None:
    for each in listed(drawn):
        if each["file"].endswith(".png"):
            pixels = matplotlib.image.imread(drawn / each["file"])[:, :, :3]
            assert pixels.std() > 0.03, each["file"]


def test_animation_has_all_frames_of_one_size_and_moves(drawn: Path) -> None:
    path = drawn / "motion.gif"
    assert path.stat().st_size < 3e6
    with Image.open(path) as gif:
        assert gif.n_frames == FRAMES >= 24
        assert gif.info["loop"] == 0
        frames = []
        for number in range(gif.n_frames):
            gif.seek(number)
            frames.append(np.asarray(gif.convert("RGB"), dtype=float))
    assert len({frame.shape for frame in frames}) == 1
    changes = [np.abs(frame - frames[0]).mean() for frame in frames[1:]]
    assert max(changes) > 2 * changes[-1] > 0
    # the motion is time-reversible, so it comes back the way it went; the written time does not
    back = [np.abs(frames[k] - frames[-k]).mean() for k in range(1, FRAMES // 2)]
    assert max(back) < 0.2 * max(changes)


def test_plots_are_made_without_a_renderer(
    rod: Path,
    tmp_path: Path,
    command: Callable[..., Ended],
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    broken = tmp_path / "broken"
    broken.write_text("#!/bin/sh\necho 'no display' >&2\nkill -ABRT $$\n")
    broken.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(broken))
    ended = command("plot", rod, "--output", tmp_path / "drawn", "--formats", "svg,pdf")
    assert ended.code == 0
    (line,) = caplog.messages
    assert "left out" in line and "signal 6" in line and "no display" in line
    (line,) = ended.out.splitlines()
    assert MANIFEST in line
    found = listed(tmp_path / "drawn")
    assert found[0]["file"] == "frequency_gamma.svg"
    assert found[0]["also"] == ["frequency_gamma.pdf"]
    assert "body" not in {each["group"] for each in found}
    assert (tmp_path / "drawn" / "frequency_gamma.svg").read_text().startswith("<?xml")
    assert (tmp_path / "drawn" / "frequency_gamma.pdf").read_bytes().startswith(b"%PDF")


def test_matrices_have_plots_of_their_own(tmp_path: Path, command: Callable[..., Ended]) -> None:
    folder = tmp_path / "chain"
    folder.mkdir()
    K = 1e6 * (2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1))
    K[2, 2], M = 1e6, np.diag([1.0, 1.0, 0.1])  # so light a mass that two modes will do
    for name, matrix in (("K", K), ("M", M), ("B", np.array([[0.0, 0.0, 1.0]]))):
        np.save(folder / f"{name}.npy", matrix)
    study = {
        "matrices": {"stiffness": "K.npy", "mass": "M.npy", "contact_rows": "B.npy"},
        "contact": {"gap": 1e-3},
        "reduction": {"modes": 2},
        "mode": {"harmonics": 5, "samples": 64},
        "continuation": {"energies": {"from": 0.8, "to": 1.2, "step": 0.2}},
    }
    (folder / "chain.toml").write_text(toml(study))
    ended = command("run", folder / "chain.toml", "--output", tmp_path / "out")
    assert ended.code == 0, ended.err
    names = {picture.file for picture in make_pictures(tmp_path / "out", tmp_path / "drawn")}
    assert {"frequency_amplitude.png", "contact_force.png", "phase_contact.png"} <= names
    assert not names & {"mesh.png", "motion.gif", "orbit.png", "contact_map.png"}


def test_same_results_give_the_same_bytes(rod: Path, tmp_path: Path) -> None:
    for kind in ("svg", "pdf"):
        for folder in ("a", "b"):
            (plot,) = share_plots(read_results(rod))[:1]
            (tmp_path / folder).mkdir(exist_ok=True)
            (name,) = save(plot.figure, tmp_path / folder, plot.name, [kind])
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_bad_requests_are_one_line(
    tmp_path: Path, rod: Path, command: Callable[..., Ended]
) -> None:
    command("plot", rod, "--formats", "png,jpg").assert_one_line(2, "jpg", "png, svg, pdf")
    command("plot", tmp_path / "none").assert_one_line(1, "branch.h5", "results folder")


def test_amplitude_of_a_rod_is_that_of_its_tip(rod: Path) -> None:
    results = read_results(rod)
    assert results.body is not None
    assert results.body.nodes[results.tip, 0] == 1.0
    amplitude = amplitude_of(results).values
    assert "(mm)" in amplitude_of(results).label
    # the linear mode: gamma goes with the square of the amplitude, which at grazing is the gap
    below = results.ratios <= 1
    np.testing.assert_allclose(amplitude[below], np.sqrt(results.ratios[below]), rtol=1e-9)


def test_contact_displacement_is_that_of_the_mesh(plate: Path) -> None:
    results = read_results(plate)
    body, phase = results.body, np.linspace(0, 6, 13)
    assert body is not None
    point = results.points[-1]
    assert point.motion.force.max() > 0
    wanted = body.displacement(point, phase, body.contact_nodes)
    wanted = np.einsum("tcd,cd->tc", wanted, body.contact_directions)
    np.testing.assert_allclose(results.contact_displacement(point, phase), wanted, atol=1e-12)
    velocity = body.velocity(point, phase, body.contact_nodes)
    velocity = np.einsum("tcd,cd->tc", velocity, body.contact_directions)
    np.testing.assert_allclose(results.contact_velocity(point, phase), velocity, atol=1e-8)


def test_chosen_points_are_those_reported(rod: Path) -> None:
    results = read_results(rod)
    assert [point.gamma_ratio for point in results.chosen] == [1.1]
    assert isinstance(results, Results)


def test_multipliers_have_their_places_and_far_ones_their_directions(rod: Path) -> None:
    known = np.array([4j, -0.25j, np.exp(0.5j), np.exp(-0.5j)])
    results = read_results(rod)
    first, second, *_ = results.points
    stability = FloquetStability("unstable", 4.0, known)
    points = (replace(first, stability=stability), replace(second, stability=None))
    plane, _ = multiplier_plots(replace(results, points=points))
    axes, bar = plane.figure.axes
    on, off, beyond = (each.get_offsets() for each in axes.collections)
    np.testing.assert_allclose(on @ [1, 1j], known[2:])
    np.testing.assert_allclose(off @ [1, 1j], known[1:2])
    np.testing.assert_allclose(beyond @ [1, 1j], [2j])
    assert axes.get_ylim()[1] > 2
    (circle,) = axes.lines
    np.testing.assert_allclose(np.hypot(*circle.get_data()), 1)
    assert bar.get_ylabel() == "gamma ratio  (1)"
    assert "moduli from 4 to 4" in plane.caption
    assert "Not known at 1 of 2 points." in plane.caption
    nothing = tuple(replace(point, stability=None) for point in points)
    assert multiplier_plots(replace(results, points=nothing)) == []


def test_parts_have_different_colours() -> None:
    for light in (False, True):
        assert len(set(colours_of_parts(40, light=light))) == 40
        assert len(colours_of_parts(3, light=light)) == 3


def test_shares_are_those_of_the_velocities_in_time(plate: Path) -> None:
    results = read_results(plate)
    point, samples = results.points[-1], 64
    phase = 2 * np.pi * np.arange(samples) / samples
    spectrum = np.abs(np.fft.rfft(results.series.rate_at(phase) @ point.motion.q, axis=0)) ** 2
    wanted = spectrum / spectrum.sum()
    harmonics = harmonic_shares(results.series, point.motion.q)
    assert harmonics.sum() == pytest.approx(1)
    assert 1e-9 < harmonics[2] < 0.5
    np.testing.assert_allclose(harmonics, wanted.sum(axis=1)[: len(harmonics)], atol=1e-12)
    modes = kinetic_shares(results.series, point.motion.q)
    np.testing.assert_allclose(modes, wanted.sum(axis=0), atol=1e-12)


def test_pressures_add_up_to_the_forces_of_the_point(plate: Path) -> None:
    results = read_results(plate)
    point, areas = results.points[-1], results.areas
    assert areas is not None and areas.sum() == pytest.approx(0.25 * 0.01)
    total = contact_pressure(results, point, results.series.phase) @ areas
    np.testing.assert_allclose(total, point.motion.force.sum(axis=1), rtol=1e-9, atol=1e-6)
    found = contact_order(results)
    assert found.words == "along the patch"
    assert results.body is not None
    places = results.body.contact_points[found.order, 1]
    assert np.all(np.diff(places) > 0)
    np.testing.assert_allclose(found.along, places - places[0], atol=1e-12)


def test_duration_is_that_of_the_table(plate: Path) -> None:
    results = read_results(plate)
    anywhere, mean, busiest = touching_shares(results)
    np.testing.assert_array_equal(
        anywhere, [point.motion.contact_fraction for point in results.points]
    )
    assert np.all(mean <= busiest) and np.all(busiest <= anywhere + 1e-12)
    assert anywhere[-1] > 0


@pytest.mark.parametrize("shift", [0.0, 1.0, -2.5])
def test_middle_of_contact_is_found_wherever_the_phase_begins(shift: float) -> None:
    series = FourierSeries(3, 128)
    force = np.maximum(np.cos(series.phase - shift) - 0.5, 0)[:, None]
    model = ReducedModel(np.ones(1), np.ones((1, 1)), np.ones((1, 1)), np.ones(1))
    header = BranchHeader("", {}, 1, 3, 128, 1, "general", model)
    point = Mock(motion=Mock(force=force))
    results = Results(header, (point,), {}, None, None)
    assert results.middle(point) == pytest.approx(shift, abs=1e-3)
    twice = Mock(motion=Mock(force=force + np.roll(force, 64, axis=0)))
    assert results.middle(twice) == 0.0


def test_cross_sections_take_means_of_slender_bodies_alone() -> None:
    x, y = np.meshgrid(np.linspace(0, 1, 11), np.linspace(0, 0.1, 3))
    nodes = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    sections = cross_sections(nodes)
    assert sections is not None and sections.axis == 0
    np.testing.assert_allclose(sections.place, np.linspace(0, 1, 11))
    np.testing.assert_allclose(sections.mean @ nodes[:, 1], 0.05)
    assert cross_sections(nodes * [0.1, 1, 1]) is None
    many = np.column_stack([np.linspace(0, 1, 5000), np.zeros((5000, 2))])
    assert len(cross_sections(many).place) == 80


def test_units_are_easy_numbers() -> None:
    found = [
        unit_for(np.array([value]), base).name
        for value, base in (
            (3.5e8, "Pa"),
            (999.0, "N"),
            (7e5, "N"),
            (4e-4, "m"),
            (2e-5, "m"),
            (1200.0, "m"),
            (3.0, "m/s"),
            (0.04, "m/s"),
            (0.0, "m"),
        )
    ]
    micro = "\N{MICRO SIGN}m"
    assert found == ["MPa", "N", "kN", "mm", micro, "m", "m/s", "mm/s", "m"]


def test_pictures_are_drawn_once_for_plot_and_report(
    plate: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kept"))
    drawn: list[str] = []

    def noted(plots: Callable[[], list[Plot]], folder: Path, kind: str) -> tuple[Picture, ...]:
        drawn.append(kind)
        return _all_saved(lambda: plots()[:2], folder, kind)

    monkeypatch.setattr("fenics_nnm.output.gallery._all_saved", noted)
    monkeypatch.setattr("fenics_nnm.output.gallery.body_plans", lambda results: [])
    first = make_pictures(plate, tmp_path / "a", formats=["svg"])
    both = make_pictures(plate, tmp_path / "b", formats=["png", "svg"])
    assert drawn == ["svg", "png"]
    assert [each.also for each in both] == [(each.file,) for each in first]
    for each in first:
        assert (tmp_path / "a" / each.file).read_bytes() == (
            tmp_path / "b" / each.file
        ).read_bytes()
    other = tmp_path / "other"
    shutil.copytree(plate, other)
    summary = other / "summary.json"
    summary.write_text(summary.read_text().replace('"mode": 1', '"mode": 1 '))
    make_pictures(other, tmp_path / "c", formats=["svg"])
    assert drawn == ["svg", "png", "svg"]  # other results are drawn anew
