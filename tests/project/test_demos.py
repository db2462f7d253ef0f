"""Key numbers of the demos."""

import csv
import json
import runpy
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from conftest import Ended

from fenics_nnm.output.motion_measures import first_torsion_mode, kinetic_shares, standing
from fenics_nnm.results import branch_file
from fenics_nnm.results.stored_branch import read_stored_branch
from fenics_nnm.study import read_study

DEMOS = Path(__file__).parents[2] / "demos"


def run_demo(monkeypatch: pytest.MonkeyPatch, name: str) -> Path:
    """Run a demo, whose own assertions count too, and return its results."""
    monkeypatch.syspath_prepend(str(DEMOS / name))
    runpy.run_path(str(DEMOS / name / f"{name}.py"))
    return DEMOS / name / "results"


def table(folder: Path) -> dict[str, np.ndarray]:
    with (folder / "backbone.csv").open() as file:
        rows = list(csv.DictReader(file))
    texts = (
        "status",
        "resonance",
        "skipped",
        "event",
        "stability",
        "reason",
        "confirmed",
        "family",
        "damped",
        "beyond",
    )
    numbers = [
        key for key in rows[0] if key not in texts and not key.endswith(("_place_m", "_kind"))
    ]
    return {key: np.array([float(row[key] or "nan") for row in rows]) for key in numbers}


def statuses(folder: Path) -> np.ndarray:
    with (folder / "backbone.csv").open() as file:
        return np.array([row["status"] for row in csv.DictReader(file)])


def assert_pictures(folder: Path, *names: str) -> None:
    for name in names:
        assert matplotlib.image.imread(folder / f"{name}.png")[:, :, :3].std() > 0.03, name


def travelling_ratio(folder: Path, gamma_ratio: float) -> float:
    """Of the velocity of a rod with uniform nodes."""
    branch = read_stored_branch(folder / "branch.h5")
    phase = 2 * np.pi * np.arange(240) / 240
    velocity = branch.velocity(branch.point(gamma_ratio), phase)[:, :, 0]
    weight = np.where(np.isin(branch.nodes[:, 0], (0, 1)), 0.5, 1.0)
    return standing(velocity, weight).travelling_ratio


def test_exact_rod_reproduces_the_reference_table() -> None:
    # reference values of the exact rod: T, omega / omega_1, contact force 2 a, and gamma of the
    # grazing sine mode (1/8) from below as T -> 4
    sys.path.insert(0, str(DEMOS / "rod"))
    try:
        import exact_rod
    finally:
        sys.path.pop(0)
    for period, ratio in ((3.9, 1.025641), (3.7, 1.081081), (3.3, 1.212121), (3.1, 1.290323)):
        gamma = exact_rod.gamma(period) / exact_rod.GRAZING_GAMMA
        assert float(exact_rod.frequency_ratio(gamma)) == pytest.approx(ratio, rel=1e-5)
    # at T = 4 the motion is a triangular wave: gamma = <v^2> / 2 omega^2 with v = 0 or 2 a
    assert exact_rod.gamma(4.0) == pytest.approx((2 / np.pi) ** 2 / 4, rel=1e-3)


def test_exact_motion_of_the_rod_keeps_its_energy_and_its_obstacle() -> None:
    sys.path.insert(0, str(DEMOS / "rod"))
    try:
        import exact_rod
    finally:
        sys.path.pop(0)
    period, intervals = 3.6, 1800
    time = np.arange(intervals) / intervals + 0.4 / intervals
    place = np.linspace(0, 1, 401)
    u, v = exact_rod.motion(period, time, place)
    np.testing.assert_allclose(u[:, 0], 0, atol=1e-12)
    assert u[:, -1].max() == pytest.approx(1, abs=1e-12)
    contact = np.mean(u[:, -1] > 1 - 1e-12) * period
    assert contact == pytest.approx(4 - period, abs=2e-3)
    middle = (place[1:] + place[:-1]) / 2
    energy = exact_rod.motion(period, time, middle)[1] ** 2 / 2 + (np.diff(u) * 400) ** 2 / 2
    np.testing.assert_allclose(energy.mean(axis=1), 1 / (2 * (period - 3) ** 2), rtol=1e-2)
    assert float(exact_rod.energy(4 / period)) == pytest.approx(1 / (2 * (period - 3) ** 2))
    step = period / intervals
    np.testing.assert_allclose(np.cumsum(v, axis=0)[-1] * step, 0, atol=0.02)  # it comes back
    gamma = (v**2).mean() / 2 / (2 * np.pi / period) ** 2
    assert gamma == pytest.approx(exact_rod.gamma(period), rel=1e-2)
    assert exact_rod.period_at(gamma / exact_rod.GRAZING_GAMMA) == pytest.approx(period, rel=1e-2)


def test_driven(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two masses under a force, whose demo compares with the closed form."""
    results = run_demo(monkeypatch, "driven")
    with (results / "response.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["monitor"] == "contact 1"]
    largest = max(rows, key=lambda row: float(row["amplitude_m"]))
    assert len(rows) == 221
    assert float(largest["frequency_Hz"]) == pytest.approx(7.1)
    assert float(largest["amplitude_m"]) == pytest.approx(0.16157, rel=1e-4)
    assert_pictures(results, "response")


def test_rod(monkeypatch: pytest.MonkeyPatch) -> None:
    results = run_demo(monkeypatch, "rod")
    import exact_rod

    summary = json.loads((results / "paper" / "summary.json").read_text())
    assert summary["linear_frequencies_Hz"][0] == pytest.approx(1297.5, abs=0.05)
    fine = table(results / "fine")
    wanted = np.arange(1.2, 4.01, 0.2)
    rows = [int(np.argmin(np.abs(fine["gamma_ratio"] - ratio))) for ratio in wanted]
    np.testing.assert_allclose(fine["gamma_ratio"][rows], wanted, rtol=1e-9)
    error = np.abs(fine["frequency_ratio"] / exact_rod.frequency_ratio(fine["gamma_ratio"]) - 1)
    assert np.count_nonzero(error[rows] < 5e-3) >= 12
    assert error[fine["gamma_ratio"] > 1.01].max() < 3e-2
    assert fine["virial_error"].max() < 1e-8
    status = statuses(results / "fine")
    beyond = fine["gamma_ratio"] > 1.01
    assert error[beyond & (status != "inside resonance")].max() < 3e-3
    assert error[beyond & (status == "inside resonance")].min() > 1.5e-3
    assert set(status[beyond]) == {"converged", "inside resonance"}
    assert set(status[~beyond]) == {"verified"}
    assert set(statuses(results / "paper")) == {"verified", "failed"}
    ratios = exact_rod.frequency_ratio(fine["gamma_ratio"][beyond])
    energies = 189 * exact_rod.energy(ratios)  # E A g^2 / L = 189 J
    np.testing.assert_allclose(fine["energy_J"][beyond], energies, rtol=1e-2)
    assert np.all(fine["rayleigh_frequency_Hz"] <= fine["frequency_Hz"] * (1 + 1e-12))
    assert travelling_ratio(results / "fine", 0.7) < 1e-9
    assert travelling_ratio(results / "fine", 1.8) == pytest.approx(0.317, abs=0.01)  # exact
    names = ("backbone_exact", "phase_space_paper", "phase_space_fine")
    assert_pictures(results, *names, "space_time_paper", "space_time_fine")


@pytest.mark.parametrize("name", ["shroud", "fork"])
def test_geometries_have_their_linear_modes(name: str, command: Callable[..., Ended]) -> None:
    """As `check` shows them; the runs themselves are those of demos/six_geometries.py."""
    listed = runpy.run_path(str(DEMOS / "six_geometries.py"))["GEOMETRIES"]
    geometry = next(each for each in listed if each.name == name)
    study = DEMOS / geometry.study
    ended = command("check", study)
    assert ended.code == 0, ended.err
    assert f"contact          {geometry.points} points" in ended.out
    rows = [line.split() for line in ended.out.split(" mode   frequency")[1].splitlines()[1:]]
    hertz = {row[0]: float(row[1]) for row in rows if len(row) == 3}
    low, high = geometry.first
    assert low < hertz[str(read_study(study).mode.number)] < high


def test_newcomers_studies_are_sound_and_change_by_the_advice() -> None:
    advice = runpy.run_path(str(DEMOS / "newcomer/newcomer.py"))["ADVICE"]
    assert set(advice) == {path.stem for path in (DEMOS / "newcomer").glob("*.toml")}
    for name, changes in advice.items():
        sections = read_study(DEMOS / f"newcomer/{name}.toml").model_dump()
        for change in changes:
            key, _, value = change.partition("=")
            node = sections
            for part in key.split("."):
                node = node[part]
            assert node != float(value), change


def test_rotor37(monkeypatch: pytest.MonkeyPatch) -> None:
    results = run_demo(monkeypatch, "rotor37")
    summary = json.loads((results / "summary.json").read_text())
    # elsewhere 860 Hz to 910 Hz depending on the alloy
    assert 860 < summary["linear_frequencies_Hz"][0] < 910
    assert summary["contact_points"] == 24
    assert len(summary["linear_frequencies_Hz"]) == 40
    assert summary["harmonics"] == 10
    backbone = table(results)
    assert backbone["gamma_ratio"][0] == pytest.approx(0.7)
    assert backbone["gamma_ratio"][-1] == pytest.approx(3.0)
    assert backbone["virial_error"].max() < 1e-8
    # all are confirmed in time, and none is verified as kinematics are linear
    assert set(statuses(results)) == {"converged"}
    (doubt,) = {point["reason"] for point in summary["not_verified"]}
    assert doubt.startswith("kinematics are linear, and second order would change the closing")
    assert summary["largest_return_error"] < 0.05
    assert backbone["energy_drift"].max() < 1e-10
    assert np.nanmax(backbone["shot_return_error"]) < 1e-10
    assert backbone["penetration_m"].max() < 0.01 * 3.56e-4
    touching = backbone["gamma_ratio"] >= 1
    assert np.all(np.diff(backbone["frequency_Hz"][touching]) > 0)
    assert backbone["frequency_ratio"][-1] > 1.01
    _, points = branch_file.read(results / "branch.h5")
    assert all(point.balance.complementarity < 1e-10 for point in points)
    blade = read_stored_branch(results / "branch.h5")
    torsion = first_torsion_mode(blade)
    assert (torsion, summary["linear_frequencies_Hz"][torsion]) == (1, pytest.approx(2559, abs=5))
    share = [
        kinetic_shares(blade.series, blade.point(ratio).motion.q)[torsion]
        for ratio in (0.7, 1.8, 3.0)
    ]
    assert share[0] < 1e-12 < 1e-6 < share[1] < 0.1 * share[2]
    assert_pictures(results, "backbone", "contact_shapes")
    listed = json.loads((results / "pictures" / "pictures.json").read_text())["pictures"]
    assert {"contact_map.png", "mesh.png", "mode_shapes.png", "motion.gif"} <= {
        picture["file"] for picture in listed
    }
