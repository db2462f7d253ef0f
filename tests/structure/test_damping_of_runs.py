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

from fenics_nnm.run import run_study
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.light_damping import light_damping
from fenics_nnm.study import study_from

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


def test_run_has_damping_ratio_and_force_of_each_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    K, M = np.array([[3000.0, -1000.0], [-1000.0, 2000.0]]), np.diag([1.0, 0.5])
    np.savez("two.npz", K=K, M=M, B=np.array([[0.0, 1.0]]))
    values: dict[str, Any] = {
        "matrices": {"file": "two.npz"},
        "contact": {"gap": 0.01},
        "reduction": {"modes": 1},
        "mode": {"harmonics": 6, "samples": 64},
        "continuation": {"energies": {"from": 0.5, "to": 1.2, "step": 0.7}},
        "damping": {"ratio": [0.02]},
        "dashpot": {"unknown": 1, "damping": 1.5},
        "excitation": {"unknown": 2, "force": 7.0},
    }
    run_study(study_from(values, Path("study.toml")), "", tmp_path / "results")
    with (tmp_path / "results/backbone.csv").open() as file:
        rows = list(csv.DictReader(file))
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
