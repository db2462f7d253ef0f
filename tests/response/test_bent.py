"""Responses with second-order kinematics: a mass on a spring that stiffens, against its motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bent_body import BentBody, dense_operators
from mpi4py import MPI
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.reduction.attached import AttachedPoints
from fenics_nnm.reduction.driven import BentModes, DrivenPlaces, driven_basis
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.response.in_time import state_at
from fenics_nnm.response.levels import Response
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.structure.driven import driven_motions, driven_structure
from fenics_nnm.study import study_from

#: x'' + 0.04 x' + x + 0.3 x^2 + 0.5 x^3 + (1 + 0.4 x) lambda = 0.05 cos(omega t) with
#: lambda = 8 (x + 0.2 x^2 - gap)_+
DAMPING, QUADRATIC, CUBIC, CLOSING, STOP, FORCE = 0.04, 0.3, 0.5, 0.2, 8.0, 0.05
SERIES = FourierSeries(12, 64)


def found(
    folder: Path, gap: float, frequencies: tuple[float, float, float], *, backbone: bool
) -> Response:
    """Its response."""
    np.savez(
        folder / "mass.npz",
        K=[[1 + STOP, -STOP], [-STOP, STOP]],
        M=np.diag([1.0, 0.0]),
        B=[[0.0, 1.0]],
        K2=[[1, 1, 1, QUADRATIC]],
        K3=[[1, 1, 1, 1, CUBIC]],
        B2=[[1, 1, 1, CLOSING]],
    )
    terms = {"quadratic_stiffness": "K2", "cubic_stiffness": "K3", "quadratic_rows": "B2"}
    wanted = dict(zip(("from", "to", "step"), frequencies, strict=True))
    study = study_from(
        {
            "matrices": {"file": "mass.npz", **terms},
            "contact": {"gap": gap},
            "reduction": {"modes": 1},
            "mode": {"number": 1, "harmonics": 12, "samples": 64},
            "damping": {"ratio": DAMPING / 2},
            "excitation": [{"unknown": 1, "force": FORCE}],
            "response": {"frequencies": wanted, "backbone": backbone},
        },
        folder / "study.toml",
    )
    return driven_motions(study, driven_structure(study, MPI.COMM_SELF))


def period(state: Array, omega: float, gap: float) -> Array:
    """The state after a period of the force."""

    def rates(time: float, at: Array) -> list[float]:
        x, v = at
        force = STOP * max(0.0, x + CLOSING * x * x - gap) * (1 + 2 * CLOSING * x)
        own = DAMPING * v + x + QUADRATIC * x * x + CUBIC * x**3
        return [v, FORCE * np.cos(omega * time) - own - force]

    end = 2 * np.pi / omega
    found = solve_ivp(rates, (0, end), state, "DOP853", rtol=1e-11, atol=1e-13, max_step=0.1)
    return found.y[:, -1]


def exact_near(point: ResponsePoint, gap: float) -> tuple[Array, float]:
    """The periodic motion near a point at phase 0, by shooting, and its largest multiplier."""
    start, step = state_at(SERIES, point.q, point.omega, 0.0), 1e-5
    state = np.concatenate(start)
    for _ in range(3):
        changes = step * np.array([[1.0, 0.0], [0.0, 1.0]])
        ahead, behind = (
            np.array([period(state + sign * d, point.omega, gap) for d in changes])
            for sign in (1, -1)
        )
        slopes = (ahead - behind).T / (2 * step)
        missed = period(state, point.omega, gap) - state
        state = state - np.linalg.solve(slopes - np.eye(2), missed)
    return state, float(np.abs(np.linalg.eigvals(slopes)).max())


def test_motions_without_contact_are_exact(tmp_path: Path) -> None:
    """All through both folds; the peak is on the damped backbone, and on the undamped one."""
    response = found(tmp_path, 100.0, (0.14, 0.24, 0.1), backbone=True)
    assert not response.reasons and not response.missing
    events = {point.event: point for point in response.points if "fold" not in point.event}
    assert [point.event for point in response.points].count("fold in omega") == 2
    unstable = [p for p in response.points if p.judgement.stability != "stable"]
    assert {str(point.status) for point in response.points} == {"verified"}
    assert max(point.imbalance for point in response.points) < 1e-10
    peak, highest = events["peak of the amplitude"], events["peak of the largest displacement"]
    middle = unstable[len(unstable) // 2]
    for point in (peak, highest, middle, response.points[0]):
        state, multiplier = exact_near(point, 100.0)
        start = np.concatenate(state_at(SERIES, point.q, point.omega, 0.0))
        assert np.abs(state - start).max() < 1e-6
        assert multiplier == pytest.approx(point.judgement.largest_multiplier, rel=1e-5)
    (resonance,) = [each for each in response.backbone.points if each.point.level == 1.0]
    assert peak.frequency == pytest.approx(resonance.point.frequency, rel=1e-3)
    assert peak.omega == pytest.approx(undamped(highest.displacements.highest[0]), rel=1e-3)


def undamped(top: float) -> float:
    """Circular frequency of the free motion of the mass up to a displacement, by quadrature."""

    def potential(x: float) -> float:
        return x**2 / 2 + QUADRATIC * x**3 / 3 + CUBIC * x**4 / 4

    energy = potential(top)
    low = brentq(lambda x: potential(x) - energy, -3.0 * top, 0.0, xtol=1e-14)
    middle, half = (top + low) / 2, (top - low) / 2

    def slowness(angle: float) -> float:
        x = middle + half * np.sin(angle)
        return half * np.cos(angle) / np.sqrt(max(2 * (energy - potential(x)), 1e-300))

    ends = np.pi / 2 * np.array([-1 + 1e-7, 1 - 1e-7])
    return float(np.pi / quad(slowness, *ends, epsabs=1e-9)[0])


def test_motions_in_contact_have_the_exact_multipliers(tmp_path: Path) -> None:
    response = found(tmp_path, 0.5, (0.16, 0.24, 0.08), backbone=False)
    assert not response.reasons and not response.missing
    assert max(point.imbalance for point in response.points) < 1e-10
    assert {str(point.status) for point in response.points} == {"verified"}
    touching = [point for point in response.points if point.displacements.contact[-1] > 0.1]
    stable = [point for point in touching if point.judgement.stability == "stable"]
    (peak,) = [point for point in stable if point.event == "peak of the amplitude"]
    unstable = next(point for point in touching if point not in stable and not point.event)
    for point in (peak, unstable):
        state, multiplier = exact_near(point, 0.5)
        start = np.concatenate(state_at(SERIES, point.q, point.omega, 0.0))
        assert np.abs(state - start).max() < 3e-3
        assert multiplier == pytest.approx(point.judgement.largest_multiplier, rel=1e-3)


def test_shapes_added_for_a_force_take_their_part_of_the_second_order_displacement() -> None:
    """Left out again they follow statically: the kinematics are those of the free modes."""
    body, masters = BentBody.random(6, 2, seed=3), np.array([0, 2])
    reduction = body.reduction(3, masters)
    rng, modes = np.random.default_rng(4), LinearModes(body.omega[:3], reduction.shapes, 0.0)
    excited, monitored = rng.normal(size=(6, 1)), rng.normal(size=(6, 1))
    none = np.zeros((6, 0))
    places = DrivenPlaces(
        AttachedPoints.none(6), excited, np.ones(1), monitored, none, body.B.T, np.ones(2)
    )
    operators = dense_operators(np.diag(body.omega**2), np.eye(6), body.B)
    basis = driven_basis(BentModes.of(modes, reduction), places, operators)
    model, own = basis.model, reduction.model.kinematics
    assert model.modes == 4
    shared = basis.shapes.T @ basis.bent_shapes
    assert np.abs(shared).max() < 1e-12
    back = model.kinematics.without_modes(np.arange(3), model)
    for name, tensor in own.tensors.items():
        np.testing.assert_allclose(back.tensors[name], tensor, atol=1e-12, err_msg=name)
    assert np.abs(model.kinematics.tensors["D"] - own.tensors["D"]).max() > 1e-4
    rows = np.hstack([excited, monitored]).T @ basis.bent_shapes
    np.testing.assert_allclose(basis.bent[:, [0, 0, 1], [0, 1, 1]], rows, atol=1e-14)
