"""Masters that the program chooses: a slender cantilever whose contact drives its second mode."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import changed
from mpi4py import MPI
from test_kinematics import SLENDER

from fenics_nnm.structure.analysis import Linear, linear_analysis
from fenics_nnm.structure.kinematics_lines import kinematics_words
from fenics_nnm.structure.masters import with_masters
from fenics_nnm.study import study_from


def body(to: float, masters: list[int] | None = None, modes: int = 4) -> Linear:
    asked: dict[str, Any] = {
        "reduction": {"modes": modes},
        "body": {"masters": masters} if masters else {},
        "continuation": {"energies": {"to": to}},
    }
    study = study_from(changed(SLENDER, asked), Path("study.toml"))
    return linear_analysis(study, MPI.COMM_SELF)


@pytest.mark.parametrize(("to", "masters"), [(0.9, [0]), (1.2, [0, 1]), (4.0, [0, 1, 2])])
def test_masters_are_those_that_the_largest_energy_asks_for(to: float, masters: list[int]) -> None:
    """Harmonic balance with mode 2 as a master differs by 0.7 % at 1.2, by 2.3 % at 4.

    With mode 3 too it does by 0.05 % and 0.18 %; 6 modes and 12 harmonics.
    """
    reduction = body(to).reduction
    assert reduction.model.kinematics.masters.tolist() == masters
    words = kinematics_words(reduction)
    assert ("mode 2 would change the frequency by " in words) == (len(masters) > 1)
    assert ("mode 3 would change the frequency by " in words) == (len(masters) > 2)


def test_some_masters_alone_are_those_made_alone() -> None:
    some = with_masters(body(0.9, [1, 2, 6], 6).reduction, np.array([0, 2]))
    alone = body(0.9, [1, 6], 6).reduction
    assert some.model.kinematics.masters.tolist() == [0, 5]
    for name, tensor in alone.model.kinematics.tensors.items():
        found = some.model.kinematics.tensors[name]
        np.testing.assert_allclose(found, tensor, rtol=1e-6, atol=1e-9 * np.abs(tensor).max())
    scale = np.abs(alone.bent_shapes).max()
    np.testing.assert_allclose(some.bent_shapes, alone.bent_shapes, atol=1e-9 * scale)
