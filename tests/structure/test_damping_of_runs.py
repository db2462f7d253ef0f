"""Damping of a study in the modes of an undamped run, and backbone.csv with it."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROD
from mpi4py import MPI
from scipy.linalg import eigh

from fenics_nnm.results.resume import difference
from fenics_nnm.run import run_study
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.damped_choice import damped_run
from fenics_nnm.structure.light_damping import light_damping
from fenics_nnm.study import Study, study_from

StudyFile = Callable[..., Path]

A, RHO, L = 9e-4, 7800.0, 1.0


def test_dashpot_and_force_at_the_tip_of_a_rod() -> None:
    """The shape of each mode at the tip is sqrt(2 / (rho A L)), of either sign."""
    study = study_from(
        {
            **ROD,
            "mesh": {**ROD["mesh"], "elements": 40},
            "body": {**ROD["body"], "degree": 2},
            "reduction": {"modes": 3},
            "damping": {"loss_factor": 0.02},
            "dashpot": {"facets": "right", "damping": [40.0]},
            "excitation": {"at": [L], "force": [-300.0], "phase_deg": 90.0},
        },
        Path("study.toml"),
    )
    linear = linear_analysis(study, MPI.COMM_SELF)
    found = light_damping(study, linear)
    assert found is not None
    square = 2 / (RHO * A * L)
    assert np.abs(found.rate) == pytest.approx(np.full((3, 3), 40.0 * square), rel=1e-3)
    assert found.loss == pytest.approx(np.diag(0.02 * linear.model.omega**2))
    assert np.abs(found.push) == pytest.approx(np.full(3, 300 * np.sqrt(square)), rel=1e-3)
    assert np.abs(found.push.real).max() < 1e-9 and found.size == pytest.approx(300)


#: Two masses, of which the second meets a stop; a dashpot and a force on each.
TWO: dict[str, Any] = {
    "matrices": {"file": "two.npz"},
    "contact": {"gap": 0.01},
    "reduction": {"modes": 1},
    "mode": {"harmonics": 6, "samples": 64},
    "continuation": {"energies": {"from": 0.5, "to": 1.2, "step": 0.7}},
    "damping": {"ratio": [0.02]},
    "dashpot": {"unknown": 1, "damping": 1.5},
    "excitation": {"unknown": 2, "force": 7.0},
}
K, M = np.array([[3000.0, -1000.0], [-1000.0, 2000.0]]), np.diag([1.0, 0.5])


@pytest.fixture
def _two(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("two.npz", K=K, M=M, B=np.array([[0.0, 1.0]]), Q=np.array([[1.0, 1, 1, 10]]))


def study_of(**sections: Any) -> Study:
    return study_from({**TWO, **sections}, Path("study.toml"))


def objection_to(**sections: Any) -> str:
    study = study_of(**sections)
    return damped_run(study, linear_analysis(study, MPI.COMM_SELF)).objection


@pytest.mark.parametrize("damped", [True, False])
@pytest.mark.usefixtures("_two")
def test_run_has_damping_ratio_and_force_of_each_point(tmp_path: Path, damped: bool) -> None:
    study = study_of(continuation={**TWO["continuation"], "damped": damped})
    result = run_study(study, "", tmp_path / "results")
    with (tmp_path / "results/backbone.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["damped"] for row in rows} == {"yes" if damped else "no"}
    said = "followed" if damped else "to first order: continuation.damped = false"
    assert result.summary["damping"] == said
    (square, _), shapes = eigh(K, M)
    first, second = shapes[:, 0]
    rate = 2 * 0.02 * np.sqrt(square) + 1.5 * first**2
    free = rows[0]
    assert float(free["damping_ratio"]) == pytest.approx(rate / (2 * np.sqrt(square)), rel=1e-9)
    amplitude = np.sqrt(2 * float(free["energy_J"]) / square)
    force = rate * np.sqrt(square) * amplitude / abs(second)
    assert float(free["resonance_force_N"]) == pytest.approx(force, rel=1e-9)
    grown = np.sqrt(float(rows[-1]["energy_J"]) / float(free["energy_J"]))
    last = float(rows[-1]["resonance_force_N"]) / force
    assert last == pytest.approx(grown * float(rows[-1]["frequency_ratio"]), rel=0.05)
    largest = float(free["largest_multiplier"])
    expected = np.exp(-np.pi * rate / np.sqrt(square)) if damped else 1.0
    assert largest == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("kept", ["damping", "dashpot"])
@pytest.mark.usefixtures("_two")
def test_damping_that_a_reduction_ignores_is_named(
    kept: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    continuation = {"energies": {"from": 0.5, "to": 0.6}, "damped": kept == "damping"}
    given = {
        **TWO,
        "continuation": continuation,
        "reduction": {"method": "craig-bampton", "modes": 1},
    }
    del given["dashpot" if kept == "damping" else "damping"]
    study = study_from(given, Path("study.toml"))
    result = run_study(study, "", tmp_path / "results")
    why = 'reduction.method = "craig-bampton": damping needs "massless"'
    warning = f"the damping of the study is ignored: {why}"
    assert not study.damped and caplog.messages.count(warning) == 1
    assert result.summary["damping"] == f"ignored: {why}"
    assert result.summary["warnings"] == [warning]


@pytest.mark.usefixtures("_two")
def test_what_stays_undamped_is_named() -> None:
    assert objection_to() == ""
    assert objection_to(damping={"loss_factor": 0.02}).startswith("damping.loss_factor")
    third = {"unknown": 2, "force": 7.0, "harmonic": 3}
    assert objection_to(excitation=third).startswith("excitation.harmonic")
    assert objection_to(contact={"gap": -0.01}).startswith("contact.gap = -0.01")
    bent = {"file": "two.npz", "quadratic_stiffness": "Q"}
    assert objection_to(matrices=bent).startswith("second-order kinematics: damped")
    arc = {"parameter": "arc-length", "energies": {"from": 1.1, "to": 1.2}}
    assert objection_to(continuation=arc).startswith("continuation.parameter")


@pytest.mark.usefixtures("_two")
def test_forces_of_two_phases_keep_no_motion_of_two_modes_up() -> None:
    np.savez("three.npz", K=np.diag([1e3, 2e3, 3e3]) + 200.0, M=np.eye(3), B=np.ones((1, 3)))
    modes = {
        "matrices": {"file": "three.npz"},
        "reduction": {"modes": 2},
        "damping": {"ratio": 0.1},
    }
    both = [{"unknown": 1, "force": 1.0}, {"unknown": 2, "force": 7.0, "phase_deg": 90.0}]
    assert objection_to(**modes, excitation=both).startswith("excitation.phase_deg")


@pytest.mark.usefixtures("_two")
def test_opposite_phases_are_one_phase() -> None:
    both = [{"unknown": 1, "force": 1.0}, {"unknown": 2, "force": 7.0, "phase_deg": 180.0}]
    study = study_of(excitation=both)
    linear = linear_analysis(study, MPI.COMM_SELF)
    found = damped_run(study, linear)
    assert found.maker is not None and found.maker.size == pytest.approx(1.0)
    _, shapes = eigh(K, M)
    assert abs(found.maker.damped.push[0]) == pytest.approx(abs(shapes[0, 0] - 7 * shapes[1, 0]))


def test_points_of_a_run_depend_on_damping_where_they_are_damped() -> None:
    text = """
matrices.file = "two.npz"
contact.gap = 0.01
damping.ratio = 0.02
continuation.damped = {damped}
"""
    damped, undamped = (text.format(damped=word) for word in ("true", "false"))
    assert difference(damped, damped.replace("0.02", "0.03")).startswith("damping.ratio was")
    assert difference(undamped, undamped.replace("0.02", "0.03")) == ""
    assert difference(undamped, damped) and difference(damped, damped) == ""
