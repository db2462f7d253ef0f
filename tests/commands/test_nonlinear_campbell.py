"""Nonlinear lines of fenics-nnm campbell: closed form, a run of the same study, and failures."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed, toml
from mpi4py import MPI
from scipy.optimize import brentq

from fenics_nnm.commands.campbell_targets import targets_of
from fenics_nnm.errors import StudyError
from fenics_nnm.resolution.auto import choice
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import read_study

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

REFERENCE = Path(__file__).parents[1] / "reference" / "nonlinear_campbell_1dof.csv"
STOP = 50.0

#: A mass whose spring and gap change with speed; it touches through a massless unknown.
MASS: dict[str, Any] = {
    "matrices": {"file": "mass.npz", "speed": 0.0, "speed_stiffness": "softening"},
    "contact": {"gap": 1.0, "gap_growth": -0.5},
    "reduction": {"modes": 1},
    "mode": {"number": 1, "harmonics": 20, "samples": 256},
}


def rows(path: str) -> list[dict[str, str]]:
    return list(csv.DictReader(Path(path).read_text().splitlines()))


def closed_form(speed: float, energy: float) -> float:
    """Frequency in Hz in contact with a stop of stiffness 50, of the head of the reference."""
    k, e = 1 + 1.17 * speed**2, 1 - 0.5 * speed**2
    open_ = 2 / np.sqrt(k) * np.arccos(-e * np.sqrt(k / (2 * energy)))
    root = np.sqrt(2 * energy * (k + STOP) - STOP * k * e**2)
    return float(1 / (open_ + 2 / np.sqrt(k + STOP) * np.arccos(e * k / root)))


@pytest.fixture
def mass(tmp_path: Path) -> Path:
    """The study of the mass, beside its matrices."""
    np.savez(
        tmp_path / "mass.npz",
        K=[[1 + STOP, -STOP], [-STOP, STOP]],
        M=np.diag([1.0, 0.0]),
        B=[[0.0, 1.0]],
        softening=np.diag([1.17, 0.0]),
    )
    study = tmp_path / "mass.toml"
    study.write_text(toml(MASS))
    return study


def test_lines_of_a_mass_are_the_closed_form(mass: Path, command: Command) -> None:
    """Rows are those of the reference; engine order 4 meets each line where its formula says."""
    ended = command(
        *("campbell", mass, "--speeds", "0.2:0.4:0.1", "--modes", 1, "--orders", 4),
        *("--energies", "2,0.25", "--amplitudes", "150 cm", "--output", "out"),
    )
    assert ended.code == 0, ended.err
    found = rows("out/campbell.csv")
    assert [row["speed_rad_s"] for row in found[::4]] == ["0.2", "0.3", "0.4"]
    assert {row["status"] for row in found} <= {"linear", "verified", "converged"}
    reference = np.loadtxt(REFERENCE, delimiter=",", skiprows=4)
    elastic = {(speed, energy): hertz for speed, _, _, energy, _, hertz in reference}
    for linear, low, high, large in zip(*(found[i::4] for i in range(4)), strict=True):
        speed, hertz = float(linear["speed_rad_s"]), float(linear["frequency_Hz"])
        k = 1 + 1.17 * speed**2
        assert hertz == pytest.approx(np.sqrt(k) / 2 / np.pi, rel=1e-8)
        assert (linear["energy_J"], linear["amplitude_m"]) == ("0", "0")
        for row, energy, exact in (
            (low, 0.25, elastic.get((speed, 0.25), hertz)),
            (high, 2.0, elastic.get((speed, 2.0), closed_form(speed, 2.0))),
        ):
            assert float(row["energy_J"]) == pytest.approx(energy, rel=1e-7)
            # on its open side the mass turns where all energy is in its spring
            assert float(row["amplitude_m"]) == pytest.approx(np.sqrt(2 * energy / k), rel=1e-4)
            assert float(row["frequency_Hz"]) == pytest.approx(exact, rel=1e-4)
        assert float(large["amplitude_m"]) == pytest.approx(1.5, rel=1e-7)
        exact = closed_form(speed, k * 1.5**2 / 2)
        assert float(large["frequency_Hz"]) == pytest.approx(exact, rel=2e-4)
    crossed = rows("out/crossings.csv")
    at = {row["energy_J"]: float(row["speed_rad_s"]) for row in crossed}
    assert at["0"] == pytest.approx(0.259675, abs=1e-6)
    in_contact = brentq(lambda s: closed_form(s, 2.0) - 4 * s / (2 * np.pi), 0.3, 0.5)
    assert at["2"] == pytest.approx(in_contact, rel=2e-4)
    assert "engine order 4 meets mode 1 of 2 J at 0.3" in ended.out


def test_energies_far_below_contact_have_the_linear_frequency(mass: Path, command: Command) -> None:
    ended = command(
        *("campbell", mass, "--speeds", "0.2:0.3:0.1", "--modes", 1, "--energies", "1e-4"),
        *("--output", "out"),
    )
    assert ended.code == 0, ended.err
    found = rows("out/campbell.csv")
    assert len(found) == 4
    for linear, low in zip(found[::2], found[1::2], strict=True):
        assert float(low["energy_J"]) == pytest.approx(1e-4, rel=1e-7)
        hertz = float(linear["frequency_Hz"])
        assert float(low["frequency_Hz"]) == pytest.approx(hertz, rel=1e-9)


def test_line_of_a_body_is_its_run_at_that_speed(study_file: StudyFile, command: Command) -> None:
    """The same point by a run of the study at 100 rad/s; a rod grows towards its stop by that."""
    rotation = {"axis": "z", "speed": 100.0, "origin": [-0.5, 0.0, 0.0]}
    study = study_file(ROD, rotation=rotation, mode={"harmonics": 7})
    asked = read_study(study)
    point = nonlinear_mode(asked, linear_analysis(asked, MPI.COMM_SELF)).points[-1]
    ended = command(
        *("campbell", study, "--speeds", "0:100:100", "--modes", 1, "--output", "out"),
        *("--energies", repr(float(point.motion.energy))),
    )
    assert ended.code == 0, ended.err
    linear, at_rest, _, at_speed = rows("out/campbell.csv")
    assert at_speed["status"] == point.status
    assert float(at_speed["frequency_Hz"]) == pytest.approx(point.motion.frequency, rel=1e-7)
    assert float(at_speed["frequency_Hz"]) > 1.005 * float(at_rest["frequency_Hz"])
    # at rest this energy does not reach the stop: E = m (w A)^2 / 4
    omega, mass = 2 * np.pi * float(linear["frequency_Hz"]), 7.02
    amplitude = np.sqrt(4 * point.motion.energy / mass) / omega
    assert float(at_rest["amplitude_m"]) == pytest.approx(amplitude, rel=0.02)  # four elements


def test_speeds_that_are_done_are_taken_over(
    mass: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two of three speeds are there, one with a line cut off behind it; another gap is new."""
    arguments = ("campbell", mass, "--modes", 1, "--energies", 0.2, "--output", "out")
    assert command(*arguments, "--speeds", "0:0.1:0.1").code == 0
    before = rows("out/campbell.csv")
    with Path("out/motions.jsonl").open("a") as file:
        file.write('{"key": "cut')
    solved: list[float] = []

    def counted(study: Any, *given: Any, **named: Any) -> Any:
        solved.append(study.speed)
        return choice(study, *given, **named)

    monkeypatch.setattr("fenics_nnm.running.nonlinear_lines.choice", counted)
    assert command(*arguments, "--speeds", "0:0.2:0.1", "--resume").code == 0
    assert solved == [pytest.approx(0.2)]
    assert rows("out/campbell.csv")[:4] == before
    gap = ("--set", "contact.gap=0.9")
    assert command(*arguments, "--speeds", "0:0.1:0.1", "--resume", *gap).code == 0
    assert len(solved) == 3


def test_motions_that_fail_are_rows(tmp_path: Path, command: Command) -> None:
    """A mode that never touches has its linear line alone."""
    np.savez(tmp_path / "two.npz", K=np.diag([1.0, 4.0]), M=np.eye(2), B=[[0.0, 1.0]])
    study = tmp_path / "two.toml"
    matrices = {"file": "two.npz", "speed": 0.0}
    contact = {"gap": 1.0, "gap_growth": -0.1}
    study.write_text(toml({**MASS, "matrices": matrices, "contact": contact}))
    ended = command(
        *("campbell", study, "--speeds", "0:1:1", "--modes", 1, "--energies", 1, "--output", "out")
    )
    assert ended.code == 1
    assert "incomplete: 2 of 2 nonlinear motions failed, the first at 0 rad/s, 1 J:" in ended.err
    found = rows("out/campbell.csv")
    assert [row["status"].split(":")[0] for row in found] == ["linear", "failed"] * 2
    assert [found[3][name] for name in ("energy_J", "frequency_Hz")] == ["1", ""]
    assert float(found[3]["smallest_gap_m"]) == pytest.approx(0.9, rel=1e-12)


def test_lines_that_cannot_be(study_file: StudyFile, command: Command, mass: Path) -> None:
    for energies, amplitudes in (("0", ""), ("1,1", ""), ("x", ""), ("", "1 J"), ("", "-1 mm")):
        with pytest.raises(StudyError, match=r"^--.*must be different positive"):
            targets_of(energies, amplitudes)
    assert [each.value for each in targets_of("2,1", "1 mm, 2", "mm")] == [1, 2, 1e-3, 2e-3]
    spin = {"axis": "y", "speed": 1.0, "coriolis": True}
    arguments = ("--speeds", "0:1:1", "--energies", 1, "--modes", 1)
    turning = study_file(PLATE, rotation=spin)
    command("campbell", turning, *arguments).assert_one_line(2, "rotation.coriolis = true")
    second = study_file(ROD, mode={"number": 2})
    command("campbell", second, *arguments).assert_one_line(2, "--modes 1: must be at least")
    speed, gap = {"speed": None, "speed_stiffness": None}, {"gap_growth": None}
    mass.write_text(toml(changed(MASS, {"matrices": speed, "contact": gap})))
    command("campbell", mass, *arguments).assert_one_line(2, "matrices.speed: is missing")


def test_a_line_keeps_its_shape_where_points_are_closed_at_rest(
    tmp_path: Path, command: Command
) -> None:
    """From 1.42 rad/s on a mass is pressed on its stop, and is mode 2 of what is held there.

    Its line stays that of this mass, not of the other mass on a spring of 9 N/m; small motions
    have the frequencies of the two masses with the stop at its spring.
    """
    K = np.array([[1.05 + STOP, -0.05, -STOP], [-0.05, 9.05, 0.0], [-STOP, 0.0, STOP]])
    np.savez(
        tmp_path / "two.npz",
        K=K,
        M=np.diag([1.0, 1.0, 0.0]),
        B=[[0.0, 0.0, 1.0]],
        softening=np.diag([1.17, 0.0, 0.0]),
    )
    study = tmp_path / "two.toml"
    matrices = {"file": "two.npz", "speed": 0.0, "speed_stiffness": "softening"}
    study.write_text(toml({**MASS, "matrices": matrices, "reduction": {"modes": 2}}))
    ended = command(
        *("campbell", study, "--speeds", "1.0:1.6:0.6", "--modes", 2, "--energies", "1e-4"),
        *("--output", "out"),
    )
    assert ended.code == 0, ended.err
    low = [float(row["frequency_Hz"]) for row in rows("out/campbell.csv") if row["energy_J"] != "0"]
    for hertz, speed, stop, mode in zip(low, (1.0, 1.6), (0.0, STOP), (0, 1), strict=True):
        k = np.array([[1.05 + 1.17 * speed**2 + stop, -0.05], [-0.05, 9.05]])
        exact = np.sqrt(np.linalg.eigvalsh(k)[mode]) / (2 * np.pi)
        assert hertz == pytest.approx(exact, rel=1e-8)
