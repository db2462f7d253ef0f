"""A sweep of responses: peaks against closed forms, going on, pictures and refusals."""

from __future__ import annotations

import csv
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Ended
from matplotlib.figure import Figure

import fenics_nnm.sweep.pictures

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: A mass of 1 kg on a spring of 1 N/m; a massless point before it that touches nothing.
OPEN: dict[str, Any] = {
    "title": "Oscillator before a stop",
    "matrices": {"file": "stop.npz"},
    "contact": {"gap": 100.0},
    "reduction": {"modes": 1},
    "mode": {"harmonics": 4, "samples": 32},
    "damping": {"ratio": 0.02},
    "excitation": {"unknown": 1, "force": 0.05},
    "response": {
        "frequencies": {"from": 0.14, "to": 0.18, "step": 0.005},
        "levels": [0.5, 1.0],
    },
}

SWEEP = ("sweep", "study.toml", "--response", "--set", "damping.ratio=0.02,0.05", "--output", "s")


@pytest.fixture
def study(tmp_path: Path, study_file: StudyFile) -> Callable[..., Path]:
    K, M = [[5.0, -4.0], [-4.0, 4.0]], [[1.0, 0.0], [0.0, 0.0]]
    np.savez(tmp_path / "stop.npz", K=K, M=M, B=[[0.0, 1.0]])
    return lambda **changes: study_file(OPEN, **changes)


@pytest.fixture(autouse=True)
def drawn(monkeypatch: pytest.MonkeyPatch) -> dict[str, Figure]:
    """Pictures by name, which are not written."""
    figures: dict[str, Figure] = {}

    def keep(figure: Figure, folder: Path, name: str, formats: Any) -> tuple[str, ...]:
        figures[name] = figure
        return ()

    monkeypatch.setattr(fenics_nnm.sweep.pictures, "save", keep)
    return figures


def rows(folder: str = "s") -> list[dict[str, str]]:
    with Path(folder, "sweep.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_peaks_are_those_of_the_closed_form(
    study: Callable[..., Path], command: Command, drawn: dict[str, Figure]
) -> None:
    """Peak of an oscillator: F / (2 k zeta sqrt(1 - zeta^2)) at sqrt(1 - 2 zeta^2) omega_1."""
    study()
    ended = command(*SWEEP)
    assert (ended.code, ended.err) == (0, "")
    for row, zeta in zip(rows(), (0.02, 0.05), strict=True):
        assert row["status"] == "complete"
        assert float(row["damping.ratio"]) == zeta
        assert (row["points"], row["points_unstable"]) == (row["points_exact"], "0")
        for level in (0.5, 1.0):
            peak = {
                name: float(row[f"{name}_level_{level:g}"])
                for name in ("peak_frequency_Hz", "peak_amplitude_m")
            }
            top = level * 0.05 / (2 * zeta * np.sqrt(1 - zeta**2))
            assert peak["peak_amplitude_m"] == pytest.approx(top, rel=1e-6)
            place = np.sqrt(1 - 2 * zeta**2) / (2 * np.pi)
            assert peak["peak_frequency_Hz"] == pytest.approx(place, rel=1e-6)
            resonance = float(row[f"resonance_frequency_Hz_level_{level:g}"])
            assert resonance == pytest.approx(1 / (2 * np.pi), rel=1e-9)
            assert float(row[f"damping_ratio_level_{level:g}"]) == pytest.approx(zeta, rel=1e-9)
    titles = [axes.get_title() for axes in drawn["sweep"].axes]
    assert titles == ["level 0.5", "level 1"]
    above, below = drawn["sweep_values"].axes
    assert below.get_xlabel() == "damping.ratio"
    assert [list(line.get_xdata()) for line in above.lines] == [[0.02, 0.05]] * 2


def test_it_goes_on_and_lists_what_is_left(study: Callable[..., Path], command: Command) -> None:
    study()
    listed = command(*SWEEP, "--list").out.splitlines()
    assert len(listed) == 2
    assert listed[0].startswith("fenics-nnm response study.toml --set damping.ratio=0.02")
    assert command(*shlex.split(listed[0])[1:]).code == 0
    assert "2 studies: 1 done, 1 to run" in command(*SWEEP).out
    before = [row["peak_amplitude_m_level_1"] for row in rows()]
    study(response={**OPEN["response"], "levels": [0.5, 1.0, 2.0]})
    assert "2 of them from points of an earlier run" in command(*SWEEP).out
    assert [row["peak_amplitude_m_level_1"] for row in rows()] == before
    assert float(rows()[0]["peak_amplitude_m_level_2"]) == pytest.approx(2 * float(before[0]))
    study(contact={"gap": 50.0})
    command(*SWEEP).assert_one_line(2, "contact.gap was 100.0", "another --output")


def test_bad_input(study: Callable[..., Path], command: Command) -> None:
    study()
    command(*SWEEP, "--gamma", "1.2").assert_one_line(2, "--gamma 1.2", "responses have levels")
    command(*SWEEP, "--stress", "1MPa").assert_one_line(2, "1MPa", "responses have levels")
    study(excitation=None)
    command(*SWEEP).assert_one_line(2, "excitation: is missing", "sweep --response")
    assert not Path("s").exists()


def test_a_failure_does_not_stop_the_others(study: Callable[..., Path], command: Command) -> None:
    study()
    ended = command(
        "sweep", "study.toml", "--response", "--set", "excitation.unknown=7,1", "--output", "s"
    )
    assert ended.code == 1
    assert "excitation.unknown = 7: failed" in ended.err
    assert [row["status"] for row in rows()] == ["failed", "complete"]
    assert rows()[0]["points"] == ""
