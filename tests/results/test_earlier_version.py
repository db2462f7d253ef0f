"""Files of an earlier version are read: by resume, export, plot and report, with its values."""

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Ended

from fenics_nnm.backbone.point import CONVERGED, FAILED, VERIFIED, BranchPoint
from fenics_nnm.results import branch_file, stored_point
from fenics_nnm.results.staging import running_folders
from fenics_nnm.results.tables import write_backbone

Command = Callable[..., Ended]

EARLIER = Path(__file__).parents[1] / "reference" / "branch_6"

#: Folder of the file, and of the backbone.csv that was written of the same points.
FILES = [
    ("finished", "finished"),
    ("with_mass", "with_mass"),
    ("stopped", "stopped"),
    ("killed", "stopped"),
]


def points_of(name: str) -> tuple[BranchPoint, ...]:
    return branch_file.read(EARLIER / name / "branch.h5")[1]


def rows_of(table: Path) -> list[dict[str, str]]:
    with table.open(newline="") as file:
        return list(csv.DictReader(file))


def status_now(row: dict[str, str]) -> str:
    """What the earlier version called converged fails where a large error is expected."""
    expected = abs(float(row["harmonics_error"])) + abs(float(row["samples_error"]))
    largest = 0.01 if float(row["error_remainder"]) <= 0.5 else 0.1
    return FAILED if row["status"] == CONVERGED and expected > largest else row["status"]


@pytest.mark.parametrize(("name", "table"), FILES)
def test_values_are_those_that_the_earlier_version_wrote(
    name: str, table: str, tmp_path: Path
) -> None:
    write_backbone(tmp_path / "backbone.csv", points_of(name))
    earlier, now = rows_of(EARLIER / table / "backbone.csv"), rows_of(tmp_path / "backbone.csv")
    assert [{column: row[column] for column in earlier[0]} for row in now] == earlier
    assert list(now[0])[: len(earlier[0])] == list(earlier[0])
    for row in now:  # what the earlier version did not know
        assert row["family"] == ""
        assert row["confirmed"] == ("yes" if row["status"] == VERIFIED else "no")


def test_parts_that_are_known_and_parts_that_are_not() -> None:
    finished = points_of("finished")
    assert [point.status for point in finished] == [VERIFIED] * 4 + [CONVERGED] * 6 + [FAILED] * 2
    assert all(point.verdict and point.returned for point in finished)
    with_orbit = [0, 1, 2, 3, 10, 11]
    assert [i for i, point in enumerate(finished) if point.orbit] == with_orbit
    assert [i for i, point in enumerate(finished) if point.stability] == with_orbit
    assert finished[2].orbit and finished[2].orbit.frequency == pytest.approx(1301.34421, rel=1e-8)
    for point in points_of("with_mass"):
        assert point.returned is None and point.expected.series is None
        assert point.verdict is not None
    for point in (*points_of("stopped"), *points_of("killed")):
        assert point.verdict is None and point.returned is None
        assert point.orbit is None and point.stability is None
        assert point.expected.series is not None


@pytest.mark.parametrize("name", ["finished", "with_mass", "stopped", "killed"])
def test_points_come_back_from_what_is_stored_of_them(name: str) -> None:
    for point in points_of(name):
        scalars, arrays = stored_point.scalars_of(point), stored_point.arrays_of(point)
        again = stored_point.point_from(scalars, arrays)
        for part in ("returned", "orbit", "verdict", "balance", "expected"):
            assert getattr(again, part) == getattr(point, part)
        np.testing.assert_array_equal(again.motion.q, point.motion.q)
        assert (again.stability is None) == (point.stability is None)


@pytest.mark.parametrize(
    ("name", "place", "taken_over"),
    [
        ("finished", "out", 12),
        ("stopped", "out", 3),
        ("killed", "out/.running-1", 3),
    ],
)
def test_resume_goes_on_from_its_points(
    name: str,
    place: str,
    taken_over: int,
    command: Command,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    shutil.copytree(EARLIER / name, tmp_path / place)
    study = EARLIER / "finished" / "study.toml"
    ended = command("run", study, "--output", "out", "--resume", "--verbose")
    assert ended.code == 1 and "no point at gamma ratio 1.1:" in ended.err  # as in the earlier run
    assert f"{taken_over} points taken over" in caplog.messages
    assert running_folders(tmp_path / "out") == []
    all_found, earlier = (
        rows_of(folder / "backbone.csv") for folder in (tmp_path / "out", EARLIER / "finished")
    )
    known = {row["gamma_ratio"] for row in earlier}
    found = [row for row in all_found if row["gamma_ratio"] in known]
    assert len(all_found) - len(found) <= 1  # steps near the miss get longer again by now
    assert [row["status"] for row in found] == [status_now(row) for row in earlier]
    assert [row["stability"] for row in found] == [row["stability"] for row in earlier]
    for column in ("gamma_ratio", "frequency_Hz", "energy_J", "shot_frequency_Hz"):
        np.testing.assert_allclose(
            [float(row[column]) for row in found],
            [float(row[column]) for row in earlier],
            rtol=1e-8,
        )
    misses = [[float(row["return_error"]) for row in rows] for rows in (found, earlier)]
    np.testing.assert_allclose(*misses, rtol=1e-3, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "ratio", "line"),
    [
        ("finished", "1.5", "gamma ratio 1.5: 1417.74 Hz, failed"),
        ("with_mass", "1.1", "gamma ratio 1.1: 1304.11 Hz, converged"),
        ("stopped", "1.05", "gamma ratio 1.05: 1301.31 Hz, converged"),
    ],
)
def test_export_of_its_points(
    name: str, ratio: str, line: str, command: Command, tmp_path: Path
) -> None:
    file = EARLIER / name / "branch.h5"
    ended = command("export", file, "--gamma", ratio, "--output", "files")
    assert ended.code == 0, ended.err
    assert ended.out.splitlines()[0] == line
    assert [path.name for path in (tmp_path / "files").glob("*.pvd")]


def test_plot_of_its_results(command: Command, tmp_path: Path) -> None:
    shutil.copytree(EARLIER / "with_mass", tmp_path / "out")
    ended = command("plot", "out", "--formats", "svg")
    assert ended.code == 0, ended.err
    drawn = {path.name for path in (tmp_path / "out" / "pictures").glob("*.svg")}
    assert {"frequency_gamma.svg", "multipliers.svg"} <= drawn


@pytest.mark.parametrize("name", ["finished", "stopped"])
def test_report_of_its_results(name: str, command: Command, tmp_path: Path) -> None:
    shutil.copytree(EARLIER / name, tmp_path / "out")
    ended = command("report", "out")
    assert ended.code == 0, ended.err
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    for row in rows_of(EARLIER / name / "backbone.csv"):
        assert f"{float(row['frequency_Hz']):.8g}" in page
    if name == "finished":
        assert "Stability is known of 6: all of them are stable." in page
    summary = EARLIER / name / "summary.json"
    if summary.exists():
        for status, count in json.loads(summary.read_text())["statuses"].items():
            assert f"{count} {status}" in page
