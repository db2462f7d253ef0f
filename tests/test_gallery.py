"""Pictures of a results folder: their list, their files, and the numbers behind them."""

import json
from collections.abc import Callable
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed, toml

from fenics_nnm.cli import main
from fenics_nnm.output.gallery import MANIFEST, make_pictures
from fenics_nnm.output.pictures.amplitude import amplitude_of, tip_of
from fenics_nnm.output.pictures.results import Results, read_results


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
    return ran(tmp_path_factory.mktemp("plate"), PLATE)


def listed(folder: Path) -> list[dict]:
    return json.loads((folder / MANIFEST).read_text())["pictures"]


def test_list_names_each_file_with_a_caption_and_its_units(plate: Path, tmp_path: Path) -> None:
    pictures = make_pictures(plate, tmp_path / "new" / "folder")
    found = listed(tmp_path / "new" / "folder")
    assert [each["file"] for each in found] == [picture.file for picture in pictures]
    files = [name for each in found for name in (each["file"], *each["also"])]
    names = {path.name for path in (tmp_path / "new" / "folder").iterdir()}
    assert sorted(files) == sorted(names - {MANIFEST})
    for each in found:
        assert each["title"] and each["caption"].endswith(".")
        assert any(unit in each["caption"] for unit in ("Hz", "mm", "MPa", "(%)", "no unit", " N "))
        if each["file"].endswith(".png"):
            pixels = matplotlib.image.imread(tmp_path / "new" / "folder" / each["file"])[:, :, :3]
            assert pixels.std() > 0.03, each["file"]


def test_plot_writes_the_formats_asked_for(
    rod: Path, tmp_path: Path, command: Callable[..., Ended]
) -> None:
    ended = command("plot", rod, "--output", tmp_path / "drawn", "--formats", "svg,pdf")
    assert ended.code == 0, ended.err
    (line,) = ended.out.splitlines()
    assert MANIFEST in line
    first = listed(tmp_path / "drawn")[0]
    assert first["file"] == "frequency_gamma.svg" and first["also"] == ["frequency_gamma.pdf"]
    assert (tmp_path / "drawn" / "frequency_gamma.svg").read_text().startswith("<?xml")
    assert (tmp_path / "drawn" / "frequency_gamma.pdf").read_bytes().startswith(b"%PDF")


def test_same_results_give_the_same_bytes(rod: Path, tmp_path: Path) -> None:
    for folder in ("a", "b"):
        make_pictures(rod, tmp_path / folder, formats=("svg", "pdf"))
    names = [picture.file for picture in make_pictures(rod, tmp_path / "a", formats=("svg", "pdf"))]
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_bad_requests_are_one_line(
    tmp_path: Path, rod: Path, command: Callable[..., Ended]
) -> None:
    command("plot", rod, "--formats", "png,jpg").assert_one_line(2, "jpg", "png, svg, pdf")
    command("plot", tmp_path / "none").assert_one_line(1, "branch.h5", "results folder")


def test_amplitude_of_a_rod_is_that_of_its_tip(rod: Path) -> None:
    results = read_results(rod)
    assert results.body is not None
    assert results.body.nodes[tip_of(results.body), 0] == 1.0
    amplitude = amplitude_of(results).values
    # the linear mode: gamma goes with the square of the amplitude, which at grazing is the gap
    below = results.ratios <= 1
    np.testing.assert_allclose(amplitude[below], 1e-3 * np.sqrt(results.ratios[below]), rtol=1e-9)


def test_contact_displacement_is_that_of_the_mesh(plate: Path) -> None:
    results = read_results(plate)
    body, phase = results.body, np.linspace(0, 6, 13)
    assert body is not None
    point = results.points[-1]
    assert point.force.max() > 0
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
