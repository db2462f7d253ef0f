"""Campbell diagrams, sweeps and simulations in Python; what has no mesh; names of one line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Ended

import fenics_nnm as nnm
from fenics_nnm.errors import StudyError
from fenics_nnm.study import study_from
from fenics_nnm.study.error_keys import one_line

#: A mass on a spring of 4 N/m, with a massless contact point before it, that turns.
STOP: dict[str, Any] = {
    "matrices": {"file": "stop.npz", "speed": 1.0, "speed_stiffness": "S"},
    "contact": {"gap": 1.0},
    "reduction": {"modes": 1},
    "mode": {"harmonics": 3, "samples": 32},
    "continuation": {"energies": {"from": 0.8, "to": 0.9, "step": 0.1}},
    "damping": {"ratio": 0.01},
    "excitation": {"unknown": 1, "force": 0.05},
    "monitor": [{"name": "mass", "unknown": 1}],
    "response": {"frequencies": {"from": 0.15, "to": 0.21, "step": 0.06}, "backbone": False},
}


@pytest.fixture(autouse=True)
def _stop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    K, M = [[5.0, -4.0], [-4.0, 4.0]], [[1.0, 0.0], [0.0, 0.0]]
    np.savez("stop.npz", K=K, M=M, B=[[0.0, 1.0]], S=[[2.0, 0.0], [0.0, 0.0]])


def test_a_diagram_has_the_closed_form() -> None:
    """omega^2 = 1 + 2 speed^2 of the mass with its spring of 1 N/m and the point free."""
    speeds = np.array([0.0, 1.0, 2.0])
    found = nnm.make_study(STOP).campbell(speeds, "lines", modes=1, orders=[1])
    expected = np.sqrt(1 + 2 * speeds**2) / (2 * np.pi)
    np.testing.assert_allclose(found.table["frequency_Hz"], expected, rtol=1e-9)
    with pytest.raises(StudyError, match="must rise"):
        nnm.make_study(STOP).campbell([1.0, 0.5], "wrong")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"speeds_rad_per_s": [0.0, np.nan]}, "speeds_rad_per_s = nan: must be a finite number"),
        ({"speeds_rad_per_s": [0.0, np.inf]}, "speeds_rad_per_s = inf"),
        ({"speeds_rad_per_s": np.zeros((2, 2))}, "speeds_rad_per_s = "),
        ({"speeds_rad_per_s": 1.0}, "must be a list of numbers"),
        ({"speeds_rad_per_s": "12"}, "must be a list of numbers"),
        ({"modes": 1.5}, "modes = 1.5: must be a whole number"),
        ({"modes": True}, "modes = True"),
        ({"orders": [1.5]}, "orders = 1.5"),
        ({"orders": [10**400]}, "must be 1 or more, and 1000000 at most"),
        ({"orders": [2, 2]}, "orders = [2, 2]: must differ"),
        ({"energies_J": [np.nan]}, "energies_J = nan"),
        ({"energies_J": [1.0, 1.0]}, "energies_J = [1.0, 1.0]: must differ"),
        ({"energies_J": 1.0}, "energies_J = 1.0: must be a list"),
        ({"amplitudes_m": ["2 mm"]}, "amplitudes_m = '2 mm': must be a finite number"),
        ({"amplitudes_m": [0.0]}, "amplitudes_m = [0.0]: must be positive"),
    ],
)
def test_a_diagram_of_wrong_numbers_is_refused(wrong: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"speeds_rad_per_s": [0.0, 1.0], **wrong}
    with pytest.raises(ValueError) as error:
        nnm.make_study(STOP).campbell(folder="wrong", **given)
    assert words in str(error.value)
    assert not Path("wrong").exists()


def test_a_diagram_of_misprinted_speeds_is_refused() -> None:
    with pytest.raises(StudyError, match=r"must be 1e\+09 at most"):
        nnm.make_study(STOP).campbell([0.0, 1e308], "wrong")


@pytest.mark.parametrize(
    "wrong", [{"frequency_Hz": "5"}, {"periods": 2.5}, {"level": np.nan}, {"frequency_Hz": True}]
)
def test_a_simulation_of_wrong_numbers_is_refused(wrong: dict[str, Any]) -> None:
    (name,) = wrong
    with pytest.raises(ValueError, match=f"{name} = "):
        nnm.make_study(STOP).simulate("wrong", **wrong)


def test_a_simulation_is_that_of_the_command(
    study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    found = nnm.make_study(STOP).simulate("face", frequency_Hz=0.2, periods=3)
    assert (repr(found), found.failure) == ("Simulation(3 periods)", "")
    file = study_file(STOP)
    command("simulate", file, "--frequency", "0.2", "--periods", "3", "--output", "command")
    assert Path("face/simulation.csv").read_bytes() == Path("command/simulation.csv").read_bytes()
    with pytest.raises(StudyError, match="must be from 1"):
        nnm.make_study(STOP).simulate("wrong", periods=0)


def test_a_sweep_goes_on_where_it_was() -> None:
    """The frequency below contact is the linear one, whatever the gap."""
    study = nnm.make_study(STOP).with_values({"continuation.damped": False})
    found = study.sweep({"contact.gap": [1.0, 2.0]}, "gaps")
    assert list(found.table["status"]) == ["complete", "complete"]
    np.testing.assert_allclose(found.branch(1).frequency_Hz, np.sqrt(3) / (2 * np.pi), rtol=1e-9)
    assert len(study.sweep({"contact.gap": [1.0, 2.0, 3.0]}, "gaps")) == 3
    with pytest.raises(StudyError, match="nothing to sweep"):
        study.sweep({}, "none")


def test_matrices_have_no_fields(
    study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    assert command("response", study_file(STOP), "--output", "driven").code == 0
    ended = command("export", "driven", "--at", "0.15")
    ended.assert_one_line(2, "driven/response.h5", "has no mesh", "[matrices]")
    assert not Path("driven/export").exists()


@pytest.mark.parametrize("name", ["two\nlines", " ", "tab\there"])
def test_a_name_is_one_line(name: str) -> None:
    wrong = {**STOP, "monitor": [{"name": name, "unknown": 1}]}
    with pytest.raises(StudyError) as caught:
        study_from(wrong, Path("study.toml"))
    line = one_line(caught.value)
    assert line.startswith("study.toml: monitor[1].name = ")
    assert "must be one line of text" in line
    assert line.isprintable()
