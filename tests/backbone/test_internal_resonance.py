"""The rod, whose natural frequencies are all multiples of the first: the main branch is found."""

import importlib
import tomllib
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import study_from

FINE = Path(__file__).parents[2] / "demos" / "rod" / "fine.toml"


def branch(start: float, stop: float, step: float) -> Branch:
    values = tomllib.loads(FINE.read_text())
    values["mesh"]["elements"] = 50
    values["reduction"]["modes"] = 30
    values["continuation"] = {"energies": {"from": start, "to": stop, "step": step}}
    study = study_from(values, FINE)
    return nonlinear_mode(study, linear_analysis(study, MPI.COMM_SELF))


@pytest.mark.parametrize(("start", "stop", "step"), [(1.05, 2.35, 0.1), (0.9, 1.2, 0.1)])
def test_rod_in_one_run(
    start: float, stop: float, step: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also over a short range near grazing, where nothing beyond helps."""
    monkeypatch.syspath_prepend(FINE.parent)
    exact_rod = importlib.import_module("exact_rod")
    found = branch(start, stop, step)
    assert found.complete
    beyond = [point for point in found.points if point.gamma_ratio > 1.01]
    exact = exact_rod.frequency_ratio(np.array([point.gamma_ratio for point in beyond]))
    errors = np.abs([point.frequency_ratio for point in beyond] / exact - 1)
    converged = np.array([point.status in ("verified", "converged") for point in beyond])
    assert np.count_nonzero(~converged) <= len(beyond) / 4
    assert errors[converged].max() < 3e-3
    assert np.median(errors[converged]) < 2e-3
