"""Points at given amplitudes, stresses, energies and frequencies."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

COLUMN = {
    "amplitude": "displacement_m",
    "stress": "von_mises_Pa",
    "energy": "energy_J",
    "frequency": "frequency_Hz",
}

#: Quadratic elements, of which the stress at the clamp is smooth over the energy.
FINER = {"body": {"degree": 2}, "reduction": {"modes": 4}}


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "backbone.csv").open() as file:
        return list(csv.DictReader(file))


def test_values_are_met_within_and_beyond_the_energies_and_can_be_exported(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(
        ROD,
        **FINER,
        continuation={
            "energies": {"from": 0.8, "to": 1.1, "step": 0.1},
            "amplitudes": ["0.5 mm", 1.2e-3],
            "stresses": ["320 MPa"],
            "report_at": [0.9, "1350 Hz", "150 J"],
        },
    )
    assert command("run", study, "--output", "out").code == 0
    rows = rows_of(tmp_path / "out")
    asked = [row for row in rows if row["asked_for"]]
    names = [row["asked_for"] for row in asked]
    assert {"amplitude 0.0005 m", "amplitude 0.0012 m", "energy 150 J"} <= set(names)
    assert any(name.startswith("stress 3.2e+08 Pa") for name in names)
    for row in asked:
        quantity, value, _ = re.split(r" |,", row["asked_for"])[:3]
        assert float(row[COLUMN[quantity]]) == pytest.approx(float(value), rel=1e-4)
    # the first is linear, where the energy grows with the square of the amplitude
    assert float(rows[0]["gamma_ratio"]) < float(asked[0]["gamma_ratio"]) or len(rows) > 6
    assert float(asked[0]["gamma_ratio"]) == pytest.approx(0.25, rel=1e-6)
    ratios = [float(row["gamma_ratio"]) for row in rows]
    assert ratios == sorted(ratios) and ratios[-1] > 1.1
    files = {path.name for path in (tmp_path / "out" / "fields").glob("motion_*.pvd")}
    assert {"motion_0.25.pvd", "motion_0.9.pvd"} <= files
    assert command("run", study, "--output", "out", "--resume").code == 0
    assert [row["asked_for"] for row in rows_of(tmp_path / "out")] == [r["asked_for"] for r in rows]

    ended = command("export", "out", "--stress", "0.32GPa", "--output", "exported")
    assert ended.code == 0, ended.err
    crossings = re.findall(r"crossing (\d) of (\d)", ended.out)
    stresses = np.array([float(row["von_mises_Pa"]) for row in rows]) - 3.2e8 * (1 + 1e-6)
    assert len(crossings) == np.count_nonzero(np.diff(np.sign(stresses)))
    far = command("export", "out", "--amplitude", "9 mm", "--output", "far")
    assert far.code == 1 and "amplitude 0.009 m (not crossed)" in far.out
    small = command("export", "out", "--amplitude", "1e-12 mm", "--output", "small")
    assert small.code == 1 and "amplitude 1e-15 m (not crossed)" in small.out
    assert "%" in far.out and "%" not in small.out
    command("export", "out", "--energy", "1 mm").assert_one_line(2, "--energy 1 mm", "uJ or kJ")
    both = command("export", "out", "--energy", "1J", "--gamma", "1")
    both.assert_one_line(2, "--gamma", "--energy")


def test_energies_in_joules(study_file: StudyFile, command: Command, tmp_path: Path) -> None:
    continuation = {"energies": {"from": "100 J", "to": "0.14 kJ", "step": "20 J"}, "report_at": []}
    assert command("run", study_file(ROD, continuation=continuation), "--output", "out").code == 0
    energies = np.array([float(row["energy_J"]) for row in rows_of(tmp_path / "out")])
    for value in (100.0, 120.0, 140.0):
        assert np.abs(energies / value - 1).min() < 1e-4
    assert not any(row["asked_for"] for row in rows_of(tmp_path / "out"))


def test_a_value_that_the_branch_never_has_is_reported(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    ended = command(
        "run", study_file(ROD, continuation={"report_at": ["5 kHz"]}), "--output", "out"
    )
    assert ended.code == 1
    assert "frequency 5000 Hz: has no motion: the branch that was found has 13" in ended.err


def test_sweep_has_columns_at_an_amplitude(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """Of a linear motion of half a millimetre the gamma ratio goes with the gap to the power -2."""
    study = study_file(ROD, continuation={"report_at": ["0.5 mm"]})
    assert command("sweep", study, "--set", "contact.gap=1e-3,8e-4", "--output", "out").code == 0
    with (tmp_path / "out" / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    ratios = [float(row["gamma_ratio_at_amplitude_0.0005_m"]) for row in rows]
    assert ratios == pytest.approx([0.25, (0.5 / 0.8) ** 2], rel=1e-4)
    for row in rows:
        assert float(row["displacement_m_at_amplitude_0.0005_m"]) == pytest.approx(5e-4, rel=1e-4)
        assert row["frequency_Hz_at_amplitude_0.0005_m"] == rows[0]["linear_frequency_Hz"]


def test_what_is_no_amount_is_refused(study_file: StudyFile, command: Command) -> None:
    for continuation, words in (
        ({"energies": [1.2, 1.4]}, "must be energies in J"),
        ({"energies": ["1.2 m"]}, 'the unit "m" is not known: must be J'),
        ({"energies": {"from": "1 J", "to": "2 J"}}, "must have from, to and step"),
        ({"energies": {"from": "3 J", "to": "2 J", "step": "1 J"}}, "from must be below to"),
        ({"report_at": ["2 furlongs"]}, '"furlongs" is not known'),
        ({"stresses": ["3 mm"]}, "must be Pa"),
        ({"amplitudes": [-1.0]}, "continuation.amplitudes"),
        ({"parameter": "arc-length", "amplitudes": [1e-3]}, "amplitudes"),
    ):
        study = study_file(ROD, continuation={"=": continuation})
        command("check", study).assert_one_line(2, "continuation", words)


def test_points_of_craig_bampton_keep_their_contact_forces(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """Those at asked values lie between their neighbours, and so do their expected errors."""
    study = study_file(
        PLATE,
        reduction={"method": "craig-bampton"},
        continuation={"energies": {"from": 1.1, "to": 1.3, "step": 0.2}, "report_at": ["1.2 mm"]},
    )
    assert command("run", study, "--output", "out").code == 0
    forces = [float(row["contact_force_N"]) for row in rows_of(tmp_path / "out")]
    assert len(forces) == 3 and forces[0] < forces[1] < forces[2]
