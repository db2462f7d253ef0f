"""Converged motions against an independent method: integration in time over one period."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.model import ReducedModel

#: A structure with incommensurate frequencies and two contact points that interact.
MODEL = ReducedModel(
    omega=[1.0, 2.62, 6.31],
    Phi=[[1.0, -0.6, 0.5], [0.7, 0.4, -0.8]],
    R=[[0.06, 0.02], [0.02, 0.05]],
    gap=[1.0, 0.9],
)


def energy(state: Array) -> float:
    q, velocity = np.split(state, 2)
    force = Complementarity(MODEL.R, MODEL.gap)((MODEL.Phi @ q)[None, :]).force[0]
    return float(
        velocity @ velocity + (MODEL.omega * q) @ (MODEL.omega * q) + force @ MODEL.R @ force
    )


def after_one_period(q: Array, period: float) -> Array:
    law = Complementarity(MODEL.R, MODEL.gap)

    def rate(time: float, state: Array) -> Array:
        position, velocity = np.split(state, 2)
        force = law((MODEL.Phi @ position)[None, :]).force[0]
        return np.concatenate([velocity, -(MODEL.omega**2) * position - MODEL.Phi.T @ force])

    start = np.concatenate([q, np.zeros_like(q)])
    flow = solve_ivp(rate, (0, period), start, method="DOP853", rtol=1e-9, atol=1e-11)
    return flow.y[:, -1] - start


def return_error(harmonics: int, gamma_ratio: float) -> float:
    """Distance of the state after a period from its start, in the energy norm."""
    continuation = EnergyContinuation(0.9, gamma_ratio, 0.1)
    branch = follow(MODEL, continuation, HarmonicBalance(harmonics, 512), mode=0)
    assert branch.complete
    point = branch.points[-1]
    assert point.motion.contact_fraction > 0.05
    start = point.motion.q.sum(axis=0)  # all cosines are 1 at t = 0, at rest
    gap = after_one_period(start, 1 / point.motion.frequency)
    modal = np.concatenate([MODEL.omega * gap[:3], gap[3:]])
    whole = energy(np.concatenate([start, np.zeros(3)]))
    return float(np.linalg.norm(modal) / np.sqrt(whole))


@pytest.mark.parametrize("gamma_ratio", [1.3, 2.0])
def test_state_returns_after_one_period(gamma_ratio: float) -> None:
    errors = [return_error(harmonics, gamma_ratio) for harmonics in (5, 10, 20)]
    assert errors[2] < 3e-3
    assert errors[2] < errors[1] / 5 < errors[0] / 25


def test_return_errors_of_the_program_agree_with_this_integration() -> None:
    continuation = EnergyContinuation(0.9, 2.0, 0.1)
    branch = follow(MODEL, continuation, HarmonicBalance(5, 512), mode=0)
    assert branch.points[-1].returned.after_one == pytest.approx(return_error(5, 2.0), rel=0.05)
    assert branch.points[-1].status == "converged"  # and not verified: five are too few
    assert branch.points[0].returned.after_one < 1e-10  # below grazing the motion is exact


def test_motion_with_too_few_harmonics_is_marked() -> None:
    # stiff contact in the middle of a mode that must stop at once: two harmonics cannot do that
    model = ReducedModel([1.0, 3.3], [[1.0, 1.0]], [[1e-3]], [1.0])
    branch = follow(model, EnergyContinuation(0.9, 2.0, 0.1), HarmonicBalance(2, 64), mode=0)
    assert {point.status for point in branch.points if point.gamma_ratio > 1.5} == {"failed"}


def test_energy_of_the_point_is_that_of_its_initial_state() -> None:
    branch = follow(MODEL, EnergyContinuation(0.9, 2.0, 0.1), HarmonicBalance(20, 512), mode=0)
    point = branch.points[-1]
    state = np.concatenate([point.motion.q.sum(axis=0), np.zeros(3)])
    assert point.motion.energy == pytest.approx(energy(state) / 2, rel=1e-3)
