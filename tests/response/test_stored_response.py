"""Stored responses: ParaView files of their motions, going on, and starting in time from them."""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROD, Ended
from written_fields import frames

from fenics_nnm.errors import StudyError
from fenics_nnm.response import levels
from fenics_nnm.response.point import Judgement, Status
from fenics_nnm.response.reported import absent
from fenics_nnm.results import response_file
from fenics_nnm.results.response_start import _chosen

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

DRIVEN: dict[str, Any] = {
    **ROD,
    "mode": {"harmonics": 6, "samples": 64},
    "damping": {"ratio": 0.02},
    "excitation": {"at": [0.5], "force": [2e4]},
    "response": {
        "frequencies": {"from": 1250.0, "to": 1400.0, "step": 50.0},
        "levels": [0.5, 1.0],
        "backbone": False,
    },
    "output": {"fields": ["displacement", "stress", "contact_pressure", "gap", "peak_stress"]},
}

STOP: dict[str, Any] = {
    "title": "Oscillator with an elastic stop",
    "matrices": {"file": "stop.npz"},
    "contact": {"gap": 1.0},
    "reduction": {"modes": 1},
    "mode": {"harmonics": 6, "samples": 32},
    "damping": {"ratio": 0.02},
    "excitation": {"unknown": 1, "force": 0.05},
    "response": {
        "frequencies": {"from": 0.155, "to": 0.165, "step": 0.005},
        "levels": [0.5, 1.0],
        "backbone": False,
    },
}


@pytest.fixture
def stop(tmp_path: Path, study_file: StudyFile) -> Callable[..., Path]:
    """A mass with a spring of 1 N/m, and a massless point before it on a spring of 4 N/m."""
    K, M = [[5.0, -4.0], [-4.0, 4.0]], [[1.0, 0.0], [0.0, 0.0]]
    np.savez(tmp_path / "stop.npz", K=K, M=M, B=[[0.0, 1.0]])
    return lambda **changes: study_file(STOP, **changes)


def rows_of(folder: str, monitor: str) -> list[dict[str, str]]:
    with (Path(folder) / "response.csv").open() as file:
        return [row for row in csv.DictReader(file) if row["monitor"] == monitor]


def first_harmonic(values: np.ndarray) -> float:
    return float(2 * np.abs(np.fft.rfft(values)[1]) / len(values))


def test_files_show_the_motions_of_the_table(study_file: StudyFile, command: Command) -> None:
    """Displacements, forces and gaps of the files are those of response.csv and of statics."""
    assert command("response", study_file(DRIVEN), "--output", "out").code == 0
    peak = next(row for row in rows_of("out", "contact 1") if "amplitude" in row["event"])
    name = f"motion_level1_{float(peak['frequency_Hz']):.6g}Hz"
    written = frames(Path("out/fields") / f"{name}.pvd")
    tip = int(np.argmax(written[0][1]["Points"][:, 0]))
    moved = np.array([arrays["displacement (m)"][tip, 0] for _, arrays in written])
    assert first_harmonic(moved) == pytest.approx(float(peak["amplitude_m"]), rel=5e-4)
    assert moved.max() <= 1e-3 + 1e-12
    surface = [arrays for _, arrays in frames(Path("out/fields") / f"{name}_contact.pvd")]
    pressure = np.array([each["contact pressure (Pa)"].max() for each in surface])
    gap = np.array([each["gap (m)"].min() for each in surface])
    assert pressure.max() > 1e6 and np.all(np.minimum(pressure / 1e6, gap / 1e-3) < 1e-9)
    np.testing.assert_allclose(gap, 1e-3 - moved, atol=1e-12)
    assert len(list(Path("out/fields").glob("motion_level0.5_*Hz.pvd"))) == 1

    ended = command("export", "out", "--at", "1400", "--level", "1", "--frames", "64")
    assert ended.code == 0 and "level 1, 1400 Hz" in ended.out
    chosen = [row for row in rows_of("out", "excitation") if row["frequency_Hz"] == "1400"]
    (row,) = [each for each in chosen if each["level"] == "1"]
    (listing,) = Path("out/export").glob("motion_level1_1400Hz.pvd")
    middle = [arrays["displacement (m)"] for _, arrays in frames(listing)]
    places = frames(listing)[0][1]["Points"][:, 0]
    node = int(np.argmin(abs(places - 0.5)))
    assert first_harmonic(np.array([each[node, 0] for each in middle])) == pytest.approx(
        float(row["amplitude_m"]), rel=1e-9
    )
    far = command("export", "out", "--at", "3000", "--output", "far")
    assert far.code == 1 and "--at 3000: no such motion, the nearest has" in far.out
    command("export", "out", "--gamma", "1").assert_one_line(2, "--gamma", "--at")


def test_report_at_names_the_motions(study_file: StudyFile, command: Command) -> None:
    study = study_file(DRIVEN, response={"report_at": [1250.0], "levels": [0.5]})
    assert command("response", study, "--output", "out").code == 0
    assert [each.name for each in Path("out/fields").glob("*Hz.pvd")] == [
        "motion_level0.5_1250Hz.pvd"
    ]
    assert "1250" in {row["frequency_Hz"] for row in rows_of("out", "excitation")}
    other = study_file(DRIVEN, response={"report_at": [1300.0], "levels": [0.5]})
    command("response", other, "--output", "out", "--resume").assert_one_line(
        2, "response.report_at was [1250.0] and is [1300.0] now"
    )
    found = response_file.read(Path("out/response.h5")).found
    assert list(absent(found, (1250.0, 1260.0))) == ["level 0.5 has no motion at 1260 Hz to report"]
    bad = study_file(DRIVEN, response={"report_at": [900.0]})
    command("response", bad).assert_one_line(2, "response", "report_at = 900", "1250", "1400")


def test_matrices_have_no_files(stop: StudyFile, command: Command) -> None:
    bad = stop(response={"report_at": [0.16]})
    command("response", bad).assert_one_line(2, "response.report_at", "matrices")
    study = stop(response={"levels": [0.1]})
    assert command("response", study, "--output", "out").code == 0
    assert not Path("out/fields").exists()
    command("export", "out", "--at", "0.16").assert_one_line(2, "out/response.h5", "no mesh")


def test_stored_motion_goes_on_in_time(stop: StudyFile, command: Command) -> None:
    """From a motion of the table, followed for one period, to where it began."""
    study = stop()
    assert command("response", study, "--output", "out").code == 0
    motions = [row for row in rows_of("out", "excitation") if row["level"] == "1"]
    touching = [row for row in motions if float(row["contact_fraction"]) > 0.1]
    chosen = next(row for row in touching if row["status"] == "verified")
    place = f"{chosen['branch']}:{chosen['point']}"
    options = ["--start", "out", "--point", place, "--periods", "2", "--output", "in-time"]
    ended = command("simulate", study, "--frequency", chosen["frequency_Hz"], *options)
    assert ended.code == 0 and f"branch 1, point {chosen['point']}" in ended.out
    with Path("in-time/simulation.csv").open() as file:
        first, second = (r for r in csv.DictReader(file) if r["monitor"] == "excitation")
    assert float(first["max_m"]) == pytest.approx(float(chosen["max_m"]), rel=2e-3)
    assert float(second["poincare_m"]) == pytest.approx(float(first["poincare_m"]), rel=2e-2)
    nearest = command("simulate", study, "--frequency", "0.16", "--start", "out", "--periods", "1")
    assert nearest.code == 0 and "starts from level 1, branch 1, point" in nearest.out
    for options, words in (
        (["--start", "out", "--point", "9:1"], ["--point 9:1", "0 motions"]),
        (["--start", "out", "--level", "3"], ["--level 3", "0.5, 1"]),
        (["--point", "1:1"], ["--point 1:1", "--start"]),
        (["--start", "out", "--point", "x"], ["--point x", "BRANCH:POINT"]),
    ):
        command("simulate", study, "--frequency", "0.16", *options).assert_one_line(2, *words)


def test_motions_have_the_numbers_of_the_table(stop: StudyFile, command: Command) -> None:
    """Those without a motion count, and none starts from them."""
    assert command("response", stop(response={"levels": [0.1]}), "--output", "out").code == 0
    stored = response_file.read(Path("out/response.h5"))
    failed = Judgement(Status.FAILED, "stuck")
    first, *others = stored.found.points
    nowhere = replace(first.displacements, first=first.displacements.first * np.nan)
    lost = replace(first, judgement=failed, displacements=nowhere)
    found = replace(stored.found, points=(lost, *others))
    chosen = _chosen(replace(stored, found=found), first.frequency, 0.1, (first.branch, 2))
    assert chosen == (2, others[0])
    with pytest.raises(StudyError, match="--point 1:1: is no motion: stuck"):
        _chosen(replace(stored, found=found), first.frequency, 0.1, (first.branch, 1))


def test_interrupted_response_goes_on(
    stop: StudyFile, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = stop()
    assert command("response", study, "--output", "whole").code == 0
    solved, original = [], levels._at_level

    def at_level(*given: Any) -> levels.Response:
        force = abs(given[0].drive.amplitudes[0])
        if force == 0.05 and not solved[1:]:
            solved.append("interrupted")
            raise KeyboardInterrupt
        solved.append(force)
        return original(*given)

    monkeypatch.setattr(levels, "_at_level", at_level)
    ended = command("response", study, "--output", "out")
    assert ended.code != 0 and "1 level is in out/.response-1; --resume" in ended.err
    assert not Path("out/response.csv").exists()
    other = ("response", stop(damping={"ratio": 0.03}, response={"levels": [0.1]}))
    command(*other, "--output", "out", "--resume").assert_one_line(
        2, "is of another study", "damping.ratio was 0.02 and is 0.03 now"
    )
    for option in ([], ["--resume"]):  # what a response of another study left stays
        assert command(*other, "--output", "out", *option).code == 0
    assert len(list(Path("out/.response-1/response.levels").iterdir())) == 1
    assert command("response", stop(), "--output", "out", "--resume").code == 0
    assert solved == [0.025, "interrupted", pytest.approx(0.005), 0.05]
    for name in ("response.csv", "response.png"):
        assert Path("out", name).read_bytes() == Path("whole", name).read_bytes()
    assert not list(Path("out").glob(".response*"))
    more = stop(response={"levels": [1.0, 0.25, 0.5]})  # of the finished one
    assert command("response", more, "--output", "out", "--resume").code == 0
    assert solved[4:] == [0.0125]
    found = response_file.read(Path("out/response.h5")).found
    assert found.levels == (1.0, 0.25, 0.5)


def test_levels_stay_where_files_cannot_be_written(
    study_file: StudyFile,
    command: Command,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Motions are all there then; going on writes what is missing, and finds none again."""

    def full(*given: Any, **named: Any) -> None:
        raise OSError(28, "No space left on device")

    study = study_file(DRIVEN, response={"levels": [0.5]})
    with monkeypatch.context() as patched:
        patched.setattr("fenics_nnm.running.responding.write_motions", full)
        ended = command("response", study, "--output", "out")
    assert ended.code == 1 and "1 level is in out/.response-1" in ended.err
    assert command("response", study, "--output", "out").code == 0
    assert "interrupted: 1 level is in there; left as it is" in caplog.text
    monkeypatch.setattr(levels, "_at_level", full)
    resumed = command("response", study, "--output", "out", "--resume")
    assert resumed.code == 0 and len(list(Path("out/fields").glob("*Hz.pvd"))) == 1
    assert not list(Path("out").glob(".response*"))


def test_damaged_file_is_refused(stop: StudyFile, command: Command) -> None:
    assert command("response", stop(response={"levels": [0.1]}), "--output", "out").code == 0
    file = Path("out/response.h5")
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    command("export", "out", "--at", "0.16").assert_one_line(1, "response.h5", "damaged")
