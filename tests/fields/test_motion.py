"""Motions rebuilt from branch.h5, and the numbers and pictures made of them."""

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest
from conftest import BEAM, PLATE, Ended
from matplotlib.figure import Figure

from fenics_nnm.arrays import Array
from fenics_nnm.errors import OutputError
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries
from fenics_nnm.output.motion_measures import kinetic_shares, section_motion, standing
from fenics_nnm.output.surface import face_normals, feature_edges, surface_faces
from fenics_nnm.results.stored_branch import StoredBranch, read_stored_branch

PHASE = np.linspace(-np.pi, np.pi, 41)

Run = Callable[..., StoredBranch]


@pytest.fixture
def run(command: Callable[..., Ended], study_file: Callable[..., Path], tmp_path: Path) -> Run:
    """A function that runs a study with some keys changed and reads its branch."""

    def ran(**changes: Any) -> StoredBranch:
        ended = command("run", study_file(**changes), "--output", tmp_path / "out")
        assert ended.code == 0, ended.err
        return read_stored_branch(tmp_path / "out" / "branch.h5")

    return ran


def test_below_grazing_every_node_moves_as_the_linear_mode_of_a_rod(run: Run) -> None:
    branch = run()
    point = branch.point(0.8)
    # linear elements of equal length have the exact mode at their nodes
    shape = np.sin(np.pi / 2 * branch.nodes[:, 0])
    amplitude = 1e-3 * np.sqrt(0.8)
    omega = 2 * np.pi * point.motion.frequency
    wanted = amplitude * np.outer(np.cos(PHASE), shape)
    np.testing.assert_allclose(branch.displacement(point, PHASE)[:, :, 0], wanted, atol=1e-12)
    wanted = -omega * amplitude * np.outer(np.sin(PHASE), shape)
    np.testing.assert_allclose(branch.velocity(point, PHASE)[:, :, 0], wanted, atol=1e-7)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"mode": {"series": "general"}},
        {"reduction": {"method": "craig-bampton"}, "mode": {"harmonics": 2}},
        {"base": PLATE},
    ],
)
def test_velocity_is_the_derivative_of_the_displacement(run: Run, changes: Any) -> None:
    branch = run(**changes)
    point = branch.point(1.1)
    assert point.motion.force.max() > 0
    step = 1e-5
    change = branch.displacement(point, PHASE + step) - branch.displacement(point, PHASE - step)
    rate = 2 * np.pi * point.motion.frequency * change / (2 * step)
    velocity = branch.velocity(point, PHASE)
    # between two phases at which contact begins or ends
    np.testing.assert_allclose(velocity, rate, atol=1e-5 * np.abs(velocity).max())


def test_tip_rests_on_the_obstacle_and_never_passes_it(run: Run) -> None:
    branch = run()
    tip = branch.contact_nodes
    assert branch.nodes[tip[0], 0] == 1.0
    u = branch.displacement(branch.point(1.1), np.linspace(-np.pi, np.pi, 2001), tip)[:, 0, 0]
    assert u.max() == pytest.approx(1e-3, rel=1e-9)
    assert 0.01 < np.mean(u > 1e-3 * (1 - 1e-9)) < 0.5
    assert u[1000] == pytest.approx(1e-3, rel=1e-9)


def test_general_series_gives_the_same_motion(run: Run) -> None:
    reversible = run()
    general = run(mode={"series": "general"})
    assert isinstance(reversible.series, CosineSeries)
    assert isinstance(general.series, FourierSeries)
    wanted = reversible.displacement(reversible.point(1.1), PHASE)
    found = general.displacement(general.point(1.1), PHASE)
    np.testing.assert_allclose(found, wanted, atol=1e-6 * np.abs(wanted).max())


def test_an_energy_without_a_point_is_named(run: Run) -> None:
    with pytest.raises(OutputError, match=r"1\.05.*report_at"):
        run().point(1.05)


TIME = 2 * np.pi * np.arange(64) / 64
PLACE = 2 * np.pi * np.arange(48) / 48


@pytest.mark.parametrize("travelling", [0.0, 0.25, 1.0])
def test_travelling_ratio_is_the_amplitude_share_of_a_travelling_sine(travelling: float) -> None:
    sines = np.cos(3 * (PLACE - TIME[:, None]))
    field = (1 - travelling) * np.outer(np.cos(3 * TIME), np.cos(3 * PLACE)) + travelling * sines
    found = standing(field, np.ones(48))
    assert found.travelling_ratio == pytest.approx(travelling, abs=1e-12)
    assert found.remainder == pytest.approx(travelling**2 / (1 + travelling**2), abs=1e-12)


def test_travelling_ratio_of_a_pulse_and_of_any_standing_shape() -> None:
    pulse = np.exp(5 * np.cos(PLACE - TIME[:, None]))
    assert standing(pulse - pulse.mean(), np.ones(48)).travelling_ratio == pytest.approx(1)
    weight = np.linspace(1, 2, 48)
    fixed = np.outer(np.sign(np.sin(TIME + 0.1)), np.exp(PLACE))
    assert standing(fixed, weight).travelling_ratio < 1e-12


def test_rod_stands_before_contact_and_travels_after(run: Run) -> None:
    branch = run(
        mesh={"elements": 20},
        reduction={"modes": 10},
        mode={"harmonics": 5, "samples": 128},
        continuation={"energies": {"from": 0.8, "to": 1.3, "step": 0.5}, "report_at": []},
    )
    weight = np.ones(len(branch.nodes))
    velocities = [branch.velocity(branch.point(ratio), TIME)[:, :, 0] for ratio in (0.8, 1.3)]
    before, after = (standing(velocity, weight).travelling_ratio for velocity in velocities)
    assert before < 1e-12
    assert 0.2 < after < 0.5


def test_kinetic_shares_weigh_harmonics_by_their_order() -> None:
    q = np.zeros((3, 2))
    q[0] = 5.0  # the mean has no kinetic energy
    q[1, 0] = q[2, 1] = 1.0
    np.testing.assert_allclose(kinetic_shares(CosineSeries(2, 8), q), [0.2, 0.8])


def test_section_motion_takes_rotation_and_translation_apart() -> None:
    places = np.array([[0, 0, 7], [4, 0, 7], [4, 2, 7], [0, 2, 7]], dtype=float)
    axis = np.array([0.0, 0.0, 1.0])
    turn = 1e-3 * np.cross(axis, places - places.mean(axis=0))
    alone = section_motion(places, turn, axis)
    assert alone.angle == pytest.approx(1e-3)
    assert alone.rotation_share == pytest.approx(1)
    both = section_motion(places, turn + np.array([2e-3, 0, 0]), axis)
    assert both.angle == pytest.approx(1e-3)
    np.testing.assert_allclose(both.translation, [2e-3, 0, 0], atol=1e-15)
    assert both.rotation_share == pytest.approx(5 / 9)  # radius of gyration sqrt(5)


@pytest.mark.parametrize(
    ("cells", "faces", "edges"), [("hexahedron", 14, 20), ("tetrahedron", 28, 20)]
)
def test_surface_of_a_beam_is_that_of_its_box(run: Run, cells: str, faces: int, edges: int) -> None:
    branch = run(base=BEAM, mesh={"cells": cells})
    found = surface_faces(branch.cells, branch.cell_type)
    assert len(found) == faces
    corners = branch.nodes[found]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    area *= 1 if cells == "hexahedron" else 0.5
    assert area.sum() == pytest.approx(2 * (0.15 * 0.1 + 0.15 + 0.1))
    np.testing.assert_allclose(np.abs(face_normals(corners)).max(axis=1), 1)
    assert len(feature_edges(branch.nodes, found)) == edges


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """Figures saved since, besides being written."""
    figures: list[Figure] = []
    save = Figure.savefig

    def keep(self: Figure, *arguments: Any, **options: Any) -> None:
        save(self, *arguments, **options)
        figures.append(self)

    monkeypatch.setattr(Figure, "savefig", keep)
    return figures


def assert_good(path: Path, figure: Figure, panels: int) -> None:
    """Not empty, all inside the picture, a caption, and a unit at every axis with numbers."""
    pixels: Array = matplotlib.image.imread(path)[:, :, :3]
    assert pixels.std() > 0.03
    box, size = figure.get_tightbbox(), figure.get_size_inches()
    assert min(box.x0, box.y0) > -0.01
    assert box.x1 < size[0] + 0.01 and box.y1 < size[1] + 0.01
    assert figure.get_supxlabel()
    assert len(figure.axes) == panels
    for axes in figure.axes:
        for axis in axes._axis_map.values():
            numbers = [label.get_visible() and label.get_text() for label in axis.get_ticklabels()]
            assert not any(numbers) or "(" in axis.get_label_text()


def test_pictures_of_a_rod(
    run: Run, tmp_path: Path, drawn: list[Figure], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "demos" / "rod")
    plots = importlib.import_module("motion_plots")
    branch = run()
    drawn.clear()
    stations = {name: branch.node_at(np.array([x, 0, 0])) for name, x in (("a", 0.5), ("b", 1))}
    plots.plot_phase_space(tmp_path / "phase.png", branch, (0.8, 1.1), stations, title="Rod")
    assert_good(tmp_path / "phase.png", drawn[0], 3)
    maps = [plots.space_time(branch, branch.point(ratio), name=f"{ratio}") for ratio in (0.8, 1.1)]
    assert np.all(np.diff(maps[0].place) > 0)
    plots.plot_space_time(tmp_path / "maps.png", maps, title="Rod", caption="Maps")
    assert_good(tmp_path / "maps.png", drawn[1], 6)
