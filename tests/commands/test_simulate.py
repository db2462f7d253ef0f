"""The simulate command: constant frequency, sweeps, stored states, what it refuses."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest
from conftest import Ended

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: w = 0.99769287 of tests/reference/b_bilinear_forced_frf.csv.
FREQUENCY = 0.99769287 / (2 * np.pi)

STOP: dict[str, Any] = {
    "title": "Oscillator with an elastic stop",
    "matrices": {"file": "stop.npz"},
    "contact": {"gap": 1.0},
    "reduction": {"modes": 1},
    "mode": {"harmonics": 3, "samples": 32},
    "damping": {"ratio": 0.01},
    "excitation": {"unknown": 1, "force": 0.05},
    "response": {"frequencies": {"from": 0.15, "to": 0.21, "step": 0.004}},
}


@pytest.fixture
def stop(tmp_path: Path, study_file: StudyFile) -> Callable[..., Path]:
    """A mass with a spring of 1 N/m, and a massless point before it on a spring of 4 N/m."""
    K, M = [[5.0, -4.0], [-4.0, 4.0]], [[1.0, 0.0], [0.0, 0.0]]
    np.savez(tmp_path / "stop.npz", K=K, M=M, B=[[0.0, 1.0]])
    return lambda **changes: study_file(STOP, **changes)


def table(folder: Path, monitor: str) -> list[dict[str, str]]:
    with (folder / "simulation.csv").open() as file:
        return [row for row in csv.DictReader(file) if row["monitor"] == monitor]


def test_a_start_from_rest_settles_on_the_reference(stop: StudyFile, command: Command) -> None:
    study = stop()
    ended = command("simulate", f"--frequency={FREQUENCY:.12f}", "--periods=180", study)
    assert ended.code == 0 and ended.err == ""
    assert "has settled on a stable motion that repeats after a period of the force" in ended.out
    assert "(largest multiplier 0.9390)" in ended.out
    folder = Path("results/study-simulation")
    assert sorted(each.name for each in folder.iterdir()) == [
        "simulation.csv", "simulation.png", "state.npz"
    ]  # fmt: skip
    rows = table(folder, "excitation")
    assert len(rows) == 180 and {row["way"] for row in rows} == {"constant"}
    first, last = rows[0], rows[-1]
    assert float(first["time_s"]) == float(first["poincare_m"]) == float(first["energy_J"]) == 0
    np.testing.assert_allclose(
        [float(last[key]) for key in ("poincare_m", "poincare_m_s", "max_m", "min_m")],
        [0.95325796, 0.50054986, 1.0717555, -1.0795690],
        atol=2e-4,
    )
    assert float(last["contact_fraction"]) == pytest.approx(0.1075, abs=1e-4)
    assert float(last["time_s"]) == pytest.approx(179 / FREQUENCY, rel=1e-10)
    point = table(folder, "contact 1")[-1]
    assert float(point["max_m"]) == pytest.approx(1.0, abs=1e-12)
    picture = matplotlib.image.imread(folder / "simulation.png")
    assert picture[:, :, :3].std() > 0.03

    again = ["--periods=1", f"--start={folder}", "--output=more", study]
    assert command("simulate", f"--frequency={FREQUENCY:.12f}", *again).code == 0
    (row,) = table(Path("more"), "excitation")
    assert float(row["poincare_m"]) == pytest.approx(0.953258, abs=1e-4)


def test_sweeps_go_up_and_down(stop: StudyFile, command: Command) -> None:
    """Upwards the large motion lasts to the fold at w = 1.2003, downwards it comes later."""
    ended = command("simulate", "--periods=12", stop())
    assert ended.code == 0
    rows = [line.split() for line in ended.out.splitlines() if " excitation " in line]
    assert [row[0] for row in rows] == ["up", "down"]
    up, down = (float(row[2]) for row in rows)
    assert up > 1.5 > down > 1.0
    found = table(Path("results/study-simulation"), "excitation")
    assert len(found) == 2 * 16 * 12
    frequencies = np.array([float(row["frequency_Hz"]) for row in found])
    np.testing.assert_allclose(frequencies, np.r_[frequencies[:192], frequencies[191::-1]])
    one = command("simulate", "--way=down", "--periods=1", "--level=0.1", stop())
    assert "down" in one.out and " up " not in one.out


@pytest.mark.parametrize(
    ("arguments", "changes", "message"),
    [
        (["--frequency=0"], {}, "--frequency 0: must be positive"),
        (["--level=-1"], {}, "--level -1: must be positive"),
        (["--periods=0"], {}, "--periods 0: must be from 1 to 10000000"),
        (["--frequency=1e-30"], {}, "simulation at 1e-30 Hz: must be at 1.59e-06 Hz or more"),
        (["--start=out", f"--point={'9' * 5000}:1"], {}, "must be BRANCH:POINT"),
        (["--frequency=1", "--way=up"], {}, "--way up: has no effect with --frequency"),
        (["--start=nowhere"], {}, "nowhere/state.npz: cannot be read as the last state"),
        ([], {"excitation": None}, "excitation: is missing: fenics-nnm simulate needs"),
        ([], {"damping": {"=": {"loss_factor": 0.01}}}, "has no equation in time"),
        (["--frequency=1"], {"reduction": {"modes": "auto"}}, "fenics-nnm simulate needs a number"),
    ],
)
def test_what_it_refuses_ends_with_one_line(
    stop: StudyFile, command: Command, arguments: list[str], changes: dict[str, Any], message: str
) -> None:
    ended = command("simulate", *arguments, stop(**changes))
    assert ended.code == 2 and message in ended.err and ended.err.count("\n") == 1


def test_states_of_other_structures_are_refused(
    stop: StudyFile, command: Command, tmp_path: Path
) -> None:
    for omega, message in (([2.0], "another structure"), ([1.0, 2.0], "has 2 modal coordinates")):
        np.savez(tmp_path / "state.npz", q=0 * np.array(omega), velocity=omega, omega=omega)
        ended = command("simulate", "--frequency=1", f"--start={tmp_path}", stop())
        assert ended.code == 2 and message in ended.err
