"""Displacement of all nodes of a body that bends far: that of its reduction, node by node."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import PLATE, changed
from mpi4py import MPI

from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.mechanics.motion import Motion, forces_at
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from


def test_largest_displacement_is_that_of_the_fields() -> None:
    second = {"body": {"kinematics": "second-order"}}
    study = study_from(changed(PLATE, second), Path("study.toml"))
    linear = linear_analysis(study, MPI.COMM_SELF)
    model, series = linear.model, CosineSeries(3, 32)
    rest = model.at_rest()
    q = np.zeros((4, model.modes))
    q[1, 0], q[2, 1] = 2 * rest.amplitude(0), 0.1 * rest.amplitude(0)
    motion = Motion(q, np.zeros((17, model.points)), q @ model.Phi.T, 1.0, 1.0, 1.0, 0.0)
    phase = 2 * np.pi * np.arange(96) / 96
    forces = forces_at(model, series, motion, phase)
    assert forces.max() > 0
    coordinates = series.basis_at(phase) @ q
    each = zip(coordinates, forces, strict=True)
    fields = [linear.reduction.displacement(x, force).reshape(-1, 2) for x, force in each]
    largest = np.linalg.norm(fields, axis=2).max()
    found = linear.displacement_basis().largest(model, series, motion)
    assert found == pytest.approx(largest, rel=1e-12)
    assert found > 1.5e-3  # first contact is at a motion of 1 mm
