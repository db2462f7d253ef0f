"""Files of the static state, and motions about it, against closed forms."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import ROD, Ended
from written_fields import arrays_of, frames

from fenics_nnm.results.stored_branch import read_stored_branch

#: Speed of the rod over its wave speed in 1/m, and Young's modulus in Pa.
K, YOUNG = 1e-2, 2.1e11

DISPLACEMENT, TOTAL = "displacement (m)", "displacement from the unloaded body (m)"
MISES, STRESS = "von Mises stress (Pa)", "stress (Pa)"


def test_a_rod_at_speed(
    study_file: Callable[..., Path], command: Callable[..., Ended], tmp_path: Path
) -> None:
    """sigma = E k^2 (L^2 - x^2) / 2 and u = k^2 (L^2 x - x^3 / 3) / 2 from the axis at x = 0."""
    study = study_file(
        ROD,
        body={"degree": 2},
        mesh={"elements": 8},
        rotation={"axis": "z", "speed": float(K * np.sqrt(YOUNG / 7800.0))},
        output={"fields": ["displacement", "total_displacement", "von_mises", "stress"]},
    )
    assert command("run", study, "--output", "out").code == 0
    folder = tmp_path / "out" / "fields"
    state = arrays_of(folder / "static_state.vtu")
    x = state["Points"][:, 0]
    exact = YOUNG * K**2 * (1 - x**2) / 2
    assert state[STRESS][:, 0] == pytest.approx(exact, abs=2e-3 * exact.max())
    assert state[MISES] == pytest.approx(exact, abs=2e-3 * exact.max())
    moved = K**2 * (x - x**3 / 3) / 2
    assert state[DISPLACEMENT][:, 0] == pytest.approx(moved, rel=2e-4, abs=1e-12)
    branch = read_stored_branch(tmp_path / "out" / "branch.h5")
    assert branch.header.model.gap == pytest.approx([1e-3 - K**2 / 3], rel=1e-5)
    # a motion and its opposite, half a period later: their mean is the static state
    below = [arrays for _, arrays in frames(folder / "motion_1.1.pvd")]
    for arrays in below:
        by_state = arrays[TOTAL] - arrays[DISPLACEMENT]
        assert by_state == pytest.approx(state[DISPLACEMENT], abs=1e-15)
        assert np.abs(arrays[STRESS][:, 0]) == pytest.approx(arrays[MISES], rel=1e-6)
    strain = below[0][DISPLACEMENT][:, 0] @ np.eye(len(x))[np.argmax(x)]
    root = np.argmin(x)
    change = below[0][STRESS][root, 0] - state[STRESS][root, 0]
    assert change * strain > 0


def test_a_bar_that_is_hotter_at_its_end(
    study_file: Callable[..., Path], command: Callable[..., Ended], tmp_path: Path
) -> None:
    """u = alpha g x^2 / 2 without stress; temperature, displacement and gap are those."""
    linear = {"shape": "linear", "temperature": 293.15, "gradient": [20.0]}
    study = study_file(
        ROD,
        body={"degree": 2},
        material={"expansion": 1e-6},
        load={"temperature_field": linear},
    )
    assert command("run", study, "--output", "out").code == 0
    state = arrays_of(tmp_path / "out" / "fields" / "static_state.vtu")
    x = state["Points"][:, 0]
    assert state["temperature above that without stress (K)"] == pytest.approx(20 * x, abs=1e-9)
    assert state[DISPLACEMENT][:, 0] == pytest.approx(1e-5 * x**2, abs=2e-10)
    assert np.abs(state[MISES]).max() < 2e-5 * 2.1e11 * 20e-6
    branch = read_stored_branch(tmp_path / "out" / "branch.h5")
    assert branch.header.model.gap == pytest.approx([1e-3 - 1e-5], rel=1e-6)
