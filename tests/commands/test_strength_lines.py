"""What check and run say of stress and strength."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended

from fenics_nnm.materials.library import library
from fenics_nnm.sweep.case import EXTREMES

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]


def test_check_says_that_a_rod_breaks_before_it_touches(
    study_file: StudyFile, command: Command
) -> None:
    """E pi g / 2 L = 330 MPa at a gap of 1 mm, of which the material bears 300 or 400."""
    exact = 2.1e11 * np.pi / 2 * 1e-3 / 1e6
    for strength, broken in (("300 MPa", True), (4e8, False)):
        study = study_file(
            ROD,
            mesh={"elements": 12},
            body={"degree": 2},
            material={"yield_strength": strength},
            reduction={"modes": 4},
        )
        line = command("check", study).out.splitlines()[-1]
        found = re.search(r"at first contact mode 1 has ([\d.]+) MPa at \((.*), 0, 0\) m", line)
        assert found and float(found[1]) == pytest.approx(exact, rel=5e-3), line
        assert float(found[2]) == 0
        assert ("it breaks before it touches" in line) == broken
        assert f"(yield {300 if broken else 400} MPa)" in line


def test_run_warns_of_points_beyond_strength_and_sweep_lists_them(
    study_file: StudyFile, command: Command, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    weak = {"yield_strength": "200 MPa", "fatigue_strength": "100 MPa"}
    study = study_file(ROD, material=weak, continuation={"report_at": []})
    result = command(
        "sweep", study, "--set", "contact.gap=5e-4,1e-3", "--gamma", "1", "-v", "--output", "out"
    )
    assert result.code == 0, result.err
    header, *rows = (tmp_path / "out" / "sweep.csv").read_text().splitlines()
    table = [dict(zip(header.split(","), row.split(","), strict=True)) for row in rows]
    stress = [float(row["von_mises_Pa_at_1"]) for row in table]
    assert stress[1] == pytest.approx(2 * stress[0], rel=1e-9)
    for row, value in zip(table, stress, strict=True):
        assert float(row["yield_margin_at_1"]) == pytest.approx(2e8 / value, rel=1e-5)
        assert float(row["goodman_margin_at_1"]) == pytest.approx(1e8 / value, rel=1e-5)
        assert all(f"{name}_at_1" in row for name in EXTREMES)
    assert "at 4 points of 4 beyond its yield strength" in caplog.text


def test_wrong_strengths_are_refused_with_what_would_be_right(
    study_file: StudyFile, command: Command
) -> None:
    for given, words in (
        ("300 furlong", '"furlong" is not known: must be Pa'),
        ("much", "must be a number with a unit"),
        (-1.0, "must be"),
    ):
        result = command("check", study_file(PLATE, material={"yield_strength": given}))
        result.assert_one_line(2, "material.yield_strength", words)


def test_metals_of_the_library_have_strengths_in_order_with_a_source() -> None:
    for name, material in library().items():
        if name in ("nickel single crystal", "CFRP AS4/3501-6"):
            assert material.yield_strength is None and not material.strength_source
            continue
        assert material.yield_strength and material.tensile_strength and material.fatigue_strength
        assert 0.25 < material.fatigue_strength / material.tensile_strength < 0.5
        assert material.yield_strength < material.tensile_strength
        assert len(material.strength_source) > 20, name
