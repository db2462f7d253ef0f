"""Files of a run: what they hold, and that they agree with each other."""

import csv
import json
import re
from pathlib import Path

import h5py
import matplotlib.image
import numpy as np
import pytest
from written_fields import arrays_of, frames

from fenics_nnm.cli import main
from fenics_nnm.commands.place import place_line
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.results import branch_file

STUDY = """
title = "Plate in the plane that meets a wall with its free edge"
[mesh]
model = "plate"
length_unit = "mm"
length = 200.0
height = 20.0
elements = [20, 2]
[body]
theory = "plane-stress"
thickness = 0.005
[material]
young = 2.1e11
poisson = 0.3
density = 7800.0
[clamp]
facets = "left"
[contact]
facets = "right"
direction = [0.0, 1.0]
gap = 1e-3
[reduction]
modes = 8
[mode]
harmonics = 5
samples = 64
[continuation]
energies = { from = 0.8, to = 1.6, step = 0.2 }
report_at = [1.5]
"""

HEADER = (
    "point,gamma_ratio,frequency_Hz,frequency_ratio,rayleigh_frequency_Hz,energy_J,"
    "penetration_m,virial_error,contact_fraction,status,"
    "reduction_residual,reduction_error,return_error,shot_frequency_Hz,largest_multiplier,"
    "harmonics_error,samples_error,error_remainder,resonance,skipped,event,"
    "return_error_10,energy_variation,energy_drift,tension_m,complementarity,"
    "shot_distance,shot_return_error,stability,reason,slope_ratio,"
    "family,confirmed,damping_needed,damping_ratio,resonance_force_N,damped,"
    "displacement_m,displacement_node,displacement_place_m,patch_displacement_m,"
    "contact_force_N,contact_impulse_Ns,von_mises_Pa,von_mises_place_m,von_mises_quantile_Pa,"
    "von_mises_anywhere_Pa,von_mises_anywhere_place_m,von_mises_anywhere_kind,"
    "principal_Pa,principal_place_m,principal_quantile_Pa,principal_anywhere_Pa,"
    "principal_anywhere_place_m,principal_anywhere_kind,yield_margin,goodman_margin,beyond,asked_for"
)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plate")
    (folder / "plate.toml").write_text(STUDY)
    assert main(["run", str(folder / "plate.toml"), "--output", str(folder / "out")]) == 0
    return folder / "out"


def rows(results: Path) -> list[dict[str, str]]:
    with (results / "backbone.csv").open() as file:
        return list(csv.DictReader(file))


def test_only_the_promised_files_are_there(results: Path) -> None:
    names = {path.name for path in results.iterdir()}
    assert names == {"backbone.csv", "backbone.png", "branch.h5", "fields", "summary.json"}


def test_table_has_the_fixed_columns_and_ascending_energies(results: Path) -> None:
    assert (results / "backbone.csv").read_text().splitlines()[0] == HEADER
    ratios = [float(row["gamma_ratio"]) for row in rows(results)]
    np.testing.assert_allclose(ratios, [0.8, 1.0, 1.2, 1.4, 1.5, 1.6])
    # five harmonics do not resolve the short contact of a stiff edge
    assert [row["status"] for row in rows(results)[:2]] == ["verified"] * 2
    assert {row["status"] for row in rows(results)[2:]} == {"failed"}


def test_frequency_rises_from_the_linear_one(results: Path) -> None:
    summary = json.loads((results / "summary.json").read_text())
    frequency = np.array([float(row["frequency_Hz"]) for row in rows(results)])
    linear = summary["linear_frequencies_Hz"][0]
    np.testing.assert_allclose(frequency[:2], linear, rtol=1e-9)
    assert np.all(np.diff(frequency[1:]) > 0)
    assert frequency[-1] > 1.005 * linear
    ratio = [float(row["frequency_ratio"]) for row in rows(results)]
    np.testing.assert_allclose(frequency / linear, ratio, rtol=1e-9)


def test_summary_says_how_large_and_how_long(results: Path) -> None:
    summary = json.loads((results / "summary.json").read_text())
    assert summary["dofs"] == 2 * 41 * 5
    assert summary["contact_points"] == 3
    assert summary["contact_area_m2"] == pytest.approx(0.02 * 0.005)
    assert len(summary["linear_frequencies_Hz"]) == 8
    assert summary["points"] == 6
    assert summary["reason"] == "reached gamma ratio 1.6"
    parts = {"mesh", "assembly", "factors", "modes", "attachments", "second order"}
    parts |= {"backbone", "stress", "output"}
    assert parts == set(summary["timings"])
    assert all(seconds > 0 for seconds in summary["timings"].values())
    # 0.8 + 0.2 + 0.2 + 0.2 is 1.4 and not 1.4000000000000001
    said = [each["gamma_ratio"] for each in summary["not_verified"]]
    assert said == [1.2, 1.4, 1.5, 1.6]
    # a plane frequency known from elsewhere: Euler-Bernoulli within 1 %
    beam = 3.51602 * np.sqrt(2.1e11 / 7800 / 12) * 0.02 / 0.2**2 / (2 * np.pi)
    assert summary["linear_frequencies_Hz"][0] == pytest.approx(beam, rel=0.02)


def test_branch_file_reads_back_as_it_was_written(results: Path) -> None:
    header, points = branch_file.read(results / "branch.h5")
    assert header.study == STUDY
    assert (header.mode, header.harmonics, header.samples) == (1, 5, 64)
    assert isinstance(header.model, ReducedModel)
    assert points[0].motion.q.shape == (6, 8)
    assert points[0].motion.force.shape == (33, 3)
    frequencies = [float(row["frequency_Hz"]) for row in rows(results)]
    np.testing.assert_allclose([point.motion.frequency for point in points], frequencies, rtol=1e-9)
    linear = np.array(header.model.omega[1:]) / points[0].motion.frequency
    np.testing.assert_allclose(points[0].stability.multipliers[:7], np.exp(1j * linear), atol=1e-9)
    known = [point for point in points if point.stability]
    largest = [np.abs(point.stability.multipliers).max() for point in known]
    np.testing.assert_allclose(
        largest, [point.stability.largest_multiplier for point in known], rtol=1e-12
    )


def test_branch_file_gives_the_motion_back_on_the_mesh(results: Path) -> None:
    _, points = branch_file.read(results / "branch.h5")
    last = points[-1]
    with h5py.File(results / "branch.h5") as file:
        shapes, residual = file["basis/shapes"][:], file["basis/residual_shapes"][:]
        nodes, cells = file["mesh/points"][:], file["mesh/cells"][:]
        contact, directions = file["contact/points"][:], file["contact/directions"][:]
    assert cells.max() == len(nodes) - 1
    start = np.einsum("j,jnd->nd", last.motion.q.sum(axis=0), shapes)
    start -= np.einsum("c,cnd->nd", last.motion.force[0], residual)
    for point, direction in zip(contact, directions, strict=True):
        node = int(np.argmin(np.linalg.norm(nodes[:, :2] - point, axis=1)))
        assert start[node] @ direction == pytest.approx(1e-3, rel=1e-6)  # closed gap


def test_a_period_of_motion_never_passes_the_obstacle(results: Path) -> None:
    period = frames(results / "fields" / "motion_1.5.pvd")
    phases = [phase for phase, _ in period]
    np.testing.assert_allclose(phases, np.arange(24) / 24, atol=1e-12)
    edge = [np.abs(a["Points"][:, 0] - 0.2) < 1e-9 for _, a in period]
    # both ends and the middle of the edge are the contact points
    lateral = [a["displacement (m)"][e, 1].max() for (_, a), e in zip(period, edge, strict=True)]
    assert max(lateral) == pytest.approx(1e-3, rel=1e-3)
    assert min(lateral) < -1.1e-3
    still = [np.abs(a["Points"][:, 0]) < 1e-9 for _, a in period]
    assert all(not a["displacement (m)"][s].any() for (_, a), s in zip(period, still, strict=True))


def test_contact_pressure_is_on_the_contact_edge_while_it_touches(results: Path) -> None:
    period = frames(results / "fields" / "motion_1.5_contact.pvd")
    pressure = np.array([a["contact pressure (Pa)"] for _, a in period])
    gap = np.array([a["gap (m)"] for _, a in period])
    assert all(np.abs(a["Points"][:, 0] - 0.2).max() < 1e-9 for _, a in period)
    assert pressure[0].max() > 0
    assert not pressure[12].any()
    assert gap.min() > -1e-9 * 1e-3
    assert np.abs(pressure * gap).max() < 1e-12 * pressure.max() * gap.max()
    assert gap[12].min() > 2e-3


def test_linear_modes_name_their_frequencies(results: Path) -> None:
    arrays = arrays_of(results / "fields" / "linear_modes.vtu")
    names = [name for name in arrays if name.startswith("mode ")]
    summary = json.loads((results / "summary.json").read_text())
    assert len(names) == 8
    hertz = [float(name.split("(")[1].split()[0]) for name in names]
    np.testing.assert_allclose(hertz, summary["linear_frequencies_Hz"], rtol=1e-5)
    assert all(np.abs(arrays[name]).max() == pytest.approx(1.0) for name in names)


def test_picture_is_not_empty(results: Path) -> None:
    picture = matplotlib.image.imread(results / "backbone.png")
    assert picture.shape[0] > 500
    assert np.ptp(picture[..., :3]) > 0.5


def test_size_told_is_that_of_the_results_alone(tmp_path: Path) -> None:
    for name in ("backbone.csv", "fields/linear/a.vtu", "photos/a.raw"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(bytes(1500))
    assert place_line(tmp_path) == f"results in {tmp_path} (3 kB)"


def test_check_shows_frequencies_and_groups(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "plate.toml").write_text(STUDY)
    assert main(["check", str(tmp_path / "plate.toml")]) == 0
    text = capsys.readouterr().out
    assert "410 degrees of freedom" in text
    assert "[0, 0.2] x [0, 0.02] m" in text
    assert re.search(r"right +2 +0.02 +\(0.2, 0.01\), \[0.2, 0.2\] x \[0, 0.02\]", text)
    assert "3 points, 0.0001 m^2" in text
    assert list(tmp_path.iterdir()) == [tmp_path / "plate.toml"]
