"""How far levels of a response move a body: closed forms, and the peak of a mass at a stop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, changed
from mpi4py import MPI

from fenics_nnm.mechanics.along import Bounce
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.structure.driven import driven_linear
from fenics_nnm.structure.driven_reach import ModalForces
from fenics_nnm.study import study_from

#: x'' + 0.02 x' + x + 4 (x - 1)_+ = 0.05 cos(omega t), whose peak is 1.779182 at 1.199978.
MASS = ReducedModel(omega=[1.0], Phi=[[1.0]], R=[[0.25]], gap=[1.0])

BEAM: dict[str, Any] = changed(
    PLATE,
    {
        "mesh": {"height": 0.02, "elements": [8, 1]},
        "contact": {"direction": [0.985, 0.174], "points": 1, "gap": 6e-3},
        "reduction": {"modes": 2},
        "mode": {"harmonics": 4, "samples": 32},
        "damping": {"ratio": 0.01},
        "excitation": {"facets": "right", "force": [0.0, 2.0]},
        "response": {"frequencies": {"from": 16.0, "to": 18.0, "step": 1.0}},
    },
)


def forces(force: float, low: float, high: float) -> ModalForces:
    return ModalForces(1.0, (1,), np.array([[force]]), np.array([0.02]), (low, high))


@pytest.mark.parametrize(("low", "high", "at"), [(0.8, 1.3, 1.0), (0.5, 0.7, 0.7), (1.2, 2, 1.2)])
def test_without_contact_it_is_the_linear_motion(low: float, high: float, at: float) -> None:
    moved = forces(0.005, low, high).moved(MASS, 0)
    omega = np.linspace(low, high, 20001)
    linear = 0.005 / np.abs(1 - omega**2 + 0.02j * omega)
    assert moved.amplitude == moved.linear == pytest.approx(linear.max(), rel=1e-6)
    assert moved.omega == pytest.approx(at, rel=1e-3)


def test_peak_beyond_contact_is_about_that_of_the_mass() -> None:
    """Within a tenth; where the frequencies end before, contact leaves less of it."""
    moved = forces(0.05, 0.8, 1.3).moved(MASS, 0)
    assert moved.linear == pytest.approx(2.5, rel=1e-3)
    bounce = Bounce.of(MASS, 0, moved.amplitude**2)
    assert bounce.largest == pytest.approx(1.779182, rel=0.1)
    assert moved.omega == pytest.approx(1.199978, rel=0.02)
    cut = forces(0.05, 0.8, 1.1).moved(MASS, 0)
    assert 1.2 < cut.amplitude < 0.8 * moved.amplitude and cut.omega == 1.1


@pytest.mark.parametrize("changes", [{}, {"continuation": {"energies": {"to": 90.0}}}])
def test_levels_of_the_response_decide_about_the_kinematics(changes: dict[str, Any]) -> None:
    """0.718 of the way at level 1, 1.2 at 10: more masters; whatever a branch would ask for."""
    low, high = (
        driven_linear(
            study_from(changed(BEAM, {**changes, "response": {"levels": levels}}), Path("s.toml")),
            MPI.COMM_SELF,
        ).basis
        for levels in ([1.0, 0.5], [10.0])
    )
    assert low.choice.second_order and high.choice.second_order
    assert "level 1 moves mode 1 most: by 0.718 times" in low.choice.reason
    assert "at gamma ratio 1 of" in low.choice.reason
    assert "(by 7.18 times without obstacles): at gamma ratio 1.4" in high.choice.reason
    assert [len(each.model.kinematics.masters) for each in (low, high)] == [1, 2]


def test_gaps_that_are_closed_at_rest_leave_kinematics_linear() -> None:
    closed = changed(BEAM, {"contact": {"gap": 0.0}, "response": {"levels": [1.0]}})
    choice = driven_linear(study_from(closed, Path("s.toml")), MPI.COMM_SELF).basis.choice
    assert not choice.second_order and "gaps are not positive" in choice.reason
