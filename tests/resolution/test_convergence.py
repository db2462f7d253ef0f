"""The convergence study: rates and differences that are known otherwise."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROD, Ended

from fenics_nnm.resolution.convergence import Convergence, Row
from fenics_nnm.study.resolution import Resolution

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: The bilinear oscillator as matrices.
BILINEAR: dict[str, Any] = {
    "title": "Bilinear oscillator",
    "matrices": {"file": "oscillator.npz"},
    "contact": {"gap": 0.01},
    "reduction": {"modes": 1},
    "mode": {"harmonics": 8, "samples": 256},
    "continuation": {"report_at": [1.1, 1.5, 2.5]},
}


@pytest.fixture
def oscillator(tmp_path: Path) -> None:
    np.savez(
        tmp_path / "oscillator.npz",
        K=np.array([[60.0, -50.0], [-50.0, 50.0]]),
        M=np.diag([1.0, 0.0]),
        B=np.array([[0.0, 1.0]]),
    )


@pytest.mark.usefixtures("oscillator")
def test_oscillator(study_file: StudyFile, command: Command, tmp_path: Path) -> None:
    ended = command("convergence", study_file(BILINEAR), "--output", tmp_path / "out")
    assert ended.code == 0 and ended.err == ""
    assert "around harmonics = 8, samples = 256, modes = 1" in ended.out
    assert (tmp_path / "out" / "convergence.png").stat().st_size > 10_000
    with (tmp_path / "out" / "convergence.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["varied"] for row in rows} == {"harmonics", "samples"}  # there is one mode
    assert {float(row["gamma_ratio"]) for row in rows} == {1.1, 1.5, 2.5}

    def errors(varied: str, number: int, name: str) -> Any:
        chosen = [r for r in rows if r["varied"] == varied and int(r["number"]) == number]
        assert len(chosen) == 3
        return np.array([float(row[name]) for row in chosen])

    for number in (64, 128):
        true, expected = (errors("samples", number, name) for name in ("error", "expected_error"))
        assert np.abs(true - expected).max() < 0.2 * np.abs(true).max()
    coarse, fine = (np.median(np.abs(errors("samples", m, "error"))) for m in (64, 256))
    assert 4 < coarse / fine < 60  # of the order of m^-2
    true, expected = (errors("harmonics", 6, name) for name in ("error", "expected_error"))
    assert np.abs(true - expected).max() < 0.3 * np.abs(true).max()


def test_rate_is_the_slope_of_the_medians() -> None:
    def row(number: int, ratio: float, factor: float) -> Row:
        return Row("modes", number, ratio, 1.0, 0.0, factor * number**-3.0, "converged")

    rows = [row(n, r, f) for n in (4, 8, 16) for r, f in ((1.2, 1.0), (1.4, -2.0), (1.6, 90.0))]
    found = Convergence(Resolution(5, 64, 8), {"modes": 32}, tuple(rows))
    assert found.rate("modes") == pytest.approx(3.0)
    assert found.medians("modes")[0] == (4, pytest.approx(2 * 4**-3.0), 0.0)
    assert np.isnan(found.rate("harmonics"))
    assert found.complete


def test_refusals(study_file: StudyFile, command: Command) -> None:
    below = {"energies": {"from": 0.3, "to": 0.9, "step": 0.1}, "report_at": []}
    study = study_file(ROD, continuation={"=": below})
    command("convergence", study).assert_one_line(2, "continuation.energies", "below first contact")
    study = study_file(ROD, reduction={"method": "none"})
    command("convergence", study).assert_one_line(2, 'reduction.method = "none"', "reduced models")
