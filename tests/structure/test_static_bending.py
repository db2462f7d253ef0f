"""Exact static bending in a mode: a slender cantilever, against second-order kinematics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, changed
from mpi4py import MPI

from fenics_nnm.errors import ModelError
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.mesh_structure import MeshLinear
from fenics_nnm.structure.static_bending import BentModel, statically_bent
from fenics_nnm.study import study_from


def body(kinematics: str, **keys: Any) -> MeshLinear:
    """A cantilever whose tip can touch beyond its end, where it is when it does not bend."""
    changes = {
        "mesh": {"height": 0.02, "elements": [8, 1]},
        "contact": {"direction": [0.985, 0.174], "points": 1, "gap": 6e-3},
        "reduction": {"modes": 4},
        "body": {"kinematics": kinematics, **keys},
        "mode": {"harmonics": 5, "samples": 64},
    }
    study = study_from(changed(PLATE, changes), Path("study.toml"))
    linear = linear_analysis(study, MPI.COMM_SELF)
    assert isinstance(linear, MeshLinear)
    return linear


def test_second_order_is_the_exact_bending_to_third_order() -> None:
    linear = body("second-order", masters=[1])
    model, direction = BentModel(linear.model), linear.interface.directions[0]
    unit = 0.02 / float(np.abs(linear.model.Phi[0, 0]))  # the tip closes by 20 mm, of 0.5 m
    errors = []
    for state in statically_bent(linear, 0, [unit / 4, unit / 2]):
        q, moved = state.coordinate, state.displacement[:, None]
        closing = float(linear.interface.displacements(moved)[0, :, 0] @ direction)
        first, second = (float(each(q)[0]) for each in (model.linear_closing, model.closing))
        errors.append((abs(first - closing), abs(second - closing)))
        assert model.load(q) == pytest.approx(state.load, rel=1e-5)
        assert abs(state.load / (float(linear.model.omega[0]) ** 2 * q) - 1) > 6e-4
    (linear_small, small), (linear_large, large) = errors
    assert linear_large == pytest.approx(4 * linear_small, rel=0.01)  # second order, 1.6 mm of 8
    assert large < 3e-6 and large > 6 * small


def test_one_master_alone() -> None:
    with pytest.raises(ModelError, match="0 masters: must have one"):
        BentModel(body("linear").model)
