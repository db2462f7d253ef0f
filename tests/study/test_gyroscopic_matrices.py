"""Matrices of another code with Coriolis forces: the two-axis oscillator, and what is refused."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Ended, changed, toml
from mpi4py import MPI

from fenics_nnm.errors import ModelError
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.coriolis import coriolis_change
from fenics_nnm.study import study_from

Command = Callable[..., Ended]

#: k1 = 1 N/m, k2 = 1.44 N/m, 1 kg: x'' - 2 Om y' + (k1 - Om^2) x = 0, y'' + 2 Om x' + ... = 0.
SPEED = 0.3

STUDY: dict[str, Any] = {
    "matrices": {
        "stiffness": "K.npy",
        "mass": "M.npy",
        "contact_rows": "B.npy",
        "speed": SPEED,
        "speed_stiffness": "softening.npy",
        "gyroscopic": "G.npy",
    },
    "contact": {"gap": 1.0},
    "reduction": {"modes": 2},
    "mode": {"number": 1, "harmonics": 7, "samples": 64},
    "continuation": {"energies": {"from": 0.9, "to": 1.1, "step": 0.1}, "shooting": False},
}


def exact(speed: float) -> np.ndarray:
    """w^4 - (k1 + k2 + 2 Om^2) w^2 + (k1 - Om^2) (k2 - Om^2) = 0; circular frequencies."""
    last = (1.0 - speed**2) * (1.44 - speed**2)
    return np.sqrt(np.sort(np.roots([1.0, -(2.44 + 2 * speed**2), last])))


@pytest.fixture
def oscillator(tmp_path: Path) -> Path:
    """The study file of the oscillator, which touches through an unknown without mass.

    It is not in the folder that commands are called in.
    """
    folder = tmp_path / "files"
    folder.mkdir()
    turned = np.zeros((3, 3))
    turned[1, 0], turned[0, 1] = 2.0, -2.0
    arrays = {
        "K": np.array([[51.0, 0.0, -50.0], [0.0, 1.44, 0.0], [-50.0, 0.0, 50.0]]),
        "M": np.diag([1.0, 1.0, 0.0]),
        "B": np.array([[0.0, 0.0, 1.0]]),
        "softening": np.diag([-1.0, -1.0, 0.0]),
        "G": turned,
    }
    for name, values in arrays.items():
        np.save(folder / f"{name}.npy", values)
    (folder / "study.toml").write_text(toml(STUDY))
    return folder / "study.toml"


@pytest.mark.parametrize("modes", [1, 2])
@pytest.mark.parametrize(
    ("speed", "published"), [(0.3, (0.7821230, 1.4171392)), (0.6, (0.4862332, 1.7098472))]
)
def test_two_axis_oscillator(
    oscillator: Path, modes: int, speed: float, published: tuple[float, float]
) -> None:
    """One mode alone has the motion across from the static displacement under its forces."""
    values = changed(STUDY, {"matrices": {"speed": speed}, "reduction": {"modes": modes}})
    linear = linear_analysis(study_from(values, oscillator), MPI.COMM_SELF)
    found = 2 * np.pi * linear.frequencies().gyroscopic
    assert exact(speed) == pytest.approx(published, abs=6e-8)
    assert found == pytest.approx(exact(speed)[:modes], rel=1e-10)
    alone = np.sqrt(1.0 - speed**2)
    assert coriolis_change(linear.coriolis, linear.modes, 0) == pytest.approx(
        exact(speed)[0] / alone - 1, rel=1e-9
    )


def test_the_effect_is_reported_and_lines_have_it_if_asked_for(
    oscillator: Path, command: Command
) -> None:
    ended = command("check", oscillator)
    assert ended.code == 0, ended.err
    change = exact(SPEED)[0] / np.sqrt(1 - SPEED**2) - 1
    assert f"of mode 1 by a part of {abs(change):.1e}" in ended.out
    assert "with Coriolis (Hz)" in ended.out
    assert command("run", oscillator, "--output", "out").code == 0
    told = json.loads(Path("out/summary.json").read_text())["coriolis"]
    assert told == f"left out: they would change the frequency by {change:+.1e} of it"
    speeds = ("--speeds", f"0:{SPEED}:{SPEED}", "--modes", 2)
    for coriolis, frequencies in (("false", np.sqrt([0.91, 1.35])), ("true", exact(SPEED))):
        given = ("--set", f"matrices.coriolis={coriolis}", "--set", f"matrices.speed={SPEED}")
        assert command("campbell", oscillator, *speeds, *given, "--output", "c").code == 0
        rows = list(csv.DictReader(Path("c/campbell.csv").read_text().splitlines()))
        hertz = [float(row["frequency_Hz"]) for row in rows]
        assert 2 * np.pi * np.array(hertz) == pytest.approx([1.0, 1.2, *frequencies], rel=1e-10)


def test_what_makes_no_sense_is_refused(oscillator: Path, command: Command) -> None:
    for matrices, words in (
        ({"speed": None, "speed_stiffness": None}, "matrices.speed: is missing"),
        ({"coriolis": True, "speed": 0.0}, "coriolis = true: has no effect without speed"),
        ({"coriolis": True, "gyroscopic": None}, "no effect without gyroscopic: must be false"),
        ({"gyroscopic": "B.npy"}, "gyroscopic G has shape (1, 3): must be (3, 3)"),
        ({"gyroscopic": "K.npy"}, "gyroscopic G is not skew: entries differ from minus their"),
        ({"gyroscopic": "none.npy"}, "none.npy"),
    ):
        oscillator.write_text(toml(changed(STUDY, {"matrices": matrices})))
        command("check", oscillator).assert_one_line(2, words)
    oscillator.write_text(toml(changed(STUDY, {"matrices": {"coriolis": True}})))
    command("run", oscillator).assert_one_line(2, "matrices.coriolis = true: Coriolis forces are")
    with pytest.raises(ModelError, match="gyroscopic G has entries that are not finite"):
        Matrices(np.eye(2), np.eye(2), [[1.0, 0.0]], 1.0, np.full((2, 2), np.nan))
