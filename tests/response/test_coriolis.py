"""Responses with Coriolis forces: the two-axis oscillator, free and at a stop, and a plate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import PLATE, changed
from mpi4py import MPI
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.reduction.gyroscopic import gyroscopic_frequencies
from fenics_nnm.response.in_time import state_at
from fenics_nnm.response.levels import response
from fenics_nnm.response.structure import DrivenStructure
from fenics_nnm.structure.driven import driven_linear, driven_motions, driven_structure
from fenics_nnm.study import Study, study_from

#: x'' + 0.02 x' - 2 Om y' + (1 - Om^2) x + 5 (x - gap)_+ = 0.005 cos(omega t),
#: y'' + 0.02 y' + 2 Om x' + (1.44 - Om^2) y = 0.
SPEED, DAMPING, STOP, FORCE = 0.3, 0.02, 5.0, 0.005
G = np.array([[0.0, -2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def oscillator(folder: Path, gap: float) -> tuple[Study, DrivenStructure]:
    """The oscillator, which touches through an unknown without mass."""
    np.savez(
        folder / "two.npz",
        K=[[1 + STOP, 0.0, -STOP], [0.0, 1.44, 0.0], [-STOP, 0.0, STOP]],
        M=np.diag([1.0, 1.0, 0.0]),
        B=[[0.0, 0.0, 1.0]],
        S=np.diag([-1.0, -1.0, 0.0]),
        G=G,
    )
    terms = {"speed_stiffness": "S", "gyroscopic": "G", "speed": SPEED, "coriolis": True}
    study = study_from(
        {
            "matrices": {"file": "two.npz", **terms},
            "contact": {"gap": gap},
            "reduction": {"modes": 2},
            "mode": {"number": 1, "harmonics": 12, "samples": 96},
            "damping": {"alpha": DAMPING},
            "excitation": [{"unknown": 1, "force": FORCE}],
            "monitor": [{"name": "y", "unknown": 2}],
            "response": {"frequencies": {"from": 0.1, "to": 0.25, "step": 0.01}},
        },
        folder / "study.toml",
    )
    return study, driven_structure(study, MPI.COMM_SELF)


def closed_form(omega: float) -> Complex:
    """Complex amplitudes of x and y."""
    K = np.diag([1.0, 1.44]) - SPEED**2 * np.eye(2)
    rate = DAMPING * np.eye(2) + SPEED * G[:2, :2]
    return np.linalg.solve(K - omega**2 * np.eye(2) + 1j * omega * rate, [FORCE, 0.0])


def test_motions_without_contact_are_the_closed_form(tmp_path: Path) -> None:
    """Of both whirls; resonances are where x is a quarter of a period behind the force."""
    study, structure = oscillator(tmp_path, 10.0)
    found = driven_motions(study, structure)
    for point in found.points:
        exact = closed_form(point.omega)
        first = point.displacements.first[:2]
        assert np.abs(first - exact).max() < 1e-10 * np.abs(exact).max()
        assert str(point.status) == "exact" and point.imbalance < 1e-10
    ends = (0.75, 0.82), (1.35, 1.45)
    omega = [brentq(lambda w: closed_form(w)[0].real, *pair, xtol=1e-14) for pair in ends]
    resonances = [each.point.omega for each in found.backbone.points]
    assert resonances == pytest.approx(omega, rel=1e-9)
    assert structure.natural == pytest.approx(
        np.sort([*np.sqrt([0.91, 1.35]), 0.7821230, 1.4171392]), abs=1e-7
    )


def period(state: Array, omega: float, gap: float) -> Array:
    """The state (x, y, x', y') after a period of the force."""

    def rates(time: float, at: Array) -> list[float]:
        x, y, vx, vy = at
        push = FORCE * np.cos(omega * time) - STOP * max(0.0, x - gap)
        own = [(1 - SPEED**2) * x + DAMPING * vx - 2 * SPEED * vy]
        own.append((1.44 - SPEED**2) * y + DAMPING * vy + 2 * SPEED * vx)
        return [vx, vy, push - own[0], -own[1]]

    span = (0.0, 2 * np.pi / omega)
    return solve_ivp(rates, span, state, "DOP853", rtol=1e-11, atol=1e-13, max_step=0.1).y[:, -1]


def test_motions_at_the_stop_are_periodic_and_lose_no_energy_to_the_speed(tmp_path: Path) -> None:
    _, structure = oscillator(tmp_path, 0.15)
    found = response(structure, FourierSeries(12, 96), np.array([0.115, 0.15]))
    touching = [point for point in found.points if point.touches]
    assert len(touching) > 3 and not found.reasons
    assert {str(point.status) for point in touching} == {"verified"}
    assert max(point.imbalance for point in found.points) < 1e-10
    series, shapes = FourierSeries(12, 96), structure.watched.shapes[:2]
    for point in (touching[0], max(touching, key=lambda each: each.amplitude[0])):
        state = np.concatenate(
            [shapes @ each for each in state_at(series, point.q, point.omega, 0.0)]
        )
        after = period(state, point.omega, 0.15)
        assert np.abs(after - state).max() < 1e-2 * np.abs(state).max()


def test_a_plate_takes_coriolis_forces_with_linear_kinematics_alone() -> None:
    """Frequencies of its rate matrix are those of `check`."""
    values = changed(
        PLATE,
        {
            "rotation": {"axis": "z", "speed": 300.0, "coriolis": True},
            "contact": {"gap": 0.1},
            "damping": {"ratio": 0.01},
            "excitation": {"facets": "right", "force": [0.0, 600.0]},
            "response": {"frequencies": {"from": 15.0, "to": 18.0, "step": 3.0}},
        },
    )
    found = driven_linear(study_from(values, Path("study.toml")), MPI.COMM_SELF).basis
    skew = (found.rate - found.rate.T) / 2
    assert np.abs(found.rate + found.rate.T).max() < 1e-9 * np.abs(found.rate).max()
    turned = gyroscopic_frequencies(found.model.omega, skew)
    assert not len(found.model.kinematics.masters)
    assert turned[0] != pytest.approx(found.model.omega[0], rel=1e-9)
    asked = changed(values, {"body": {"kinematics": "second-order"}})
    with pytest.raises(ModelError, match=r"Coriolis forces .* are those of linear kinematics"):
        driven_linear(study_from(asked, Path("study.toml")), MPI.COMM_SELF)
