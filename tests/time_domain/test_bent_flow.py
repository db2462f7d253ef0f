"""Damped, driven motion with second-order kinematics in time against the equations themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from bent_body import BentBody
from scipy.integrate import solve_ivp

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.time_domain.bent_flow import BentFlow
from fenics_nnm.time_domain.damped_flow import DampedFlow

RNG = np.random.default_rng(5)
MASTERS, OMEGA, SPAN = np.array([0, 2]), 1.13, 12.0
BODY = BentBody.random(6, 2, seed=3)
MODEL = replace(BODY.reduction(3, MASTERS).model, gap=np.array([0.05, 0.04]))
C = np.diag([0.1, 0.2, 0.3]) + 0.05 * RNG.normal(size=(3, 3))
TURNING = np.array([np.diag([0.3, -0.2]), [[0.1, 0.2], [0.2, 0.0]]])
PUSH = Excitation(1, np.array([0.06, 0.03, 0.0]), np.array([0.0, 0.05, 0.02]), TURNING)
GAPS = GapMotion((2,), np.array([[0.02 + 0.01j, -0.01j]]))
START = np.array([0.05, -0.01, 0.02]), np.array([0.02, 0.05, 0.01])


def mechanics(model: ReducedModel = MODEL, gaps: GapMotion = GAPS) -> Mechanics:
    linear, forces = RatedPart(model.omega, C), model.kinematics.forces
    return Mechanics(model, model.at_rest(), linear, forces, (PUSH,), gaps)


def rates(time: float, state: Array) -> Array:
    """The equations of motion, written down once more."""
    q, v, m = state[:3], state[3:], MASTERS
    order = MODEL.kinematics.tensors
    Theta, alpha, beta, D = (order[name] for name in ("Theta", "alpha", "beta", "D"))
    x, y, angle = q[m], v[m], OMEGA * time
    shapes = MODEL.Phi.copy()
    shapes[:, m] += np.einsum("cjk,k->cj", Theta, x)
    p = MODEL.Phi @ q + np.einsum("cjk,j,k->c", Theta, x, x) / 2
    gap = MODEL.gap + GAPS.at(angle)
    force = Complementarity(MODEL.R, np.zeros(2))((p - gap)[None]).force[0]
    right = PUSH.cosine * np.cos(angle) + PUSH.sine * np.sin(angle)
    right -= MODEL.omega**2 * q + C @ v + shapes.T @ force
    right -= np.einsum("ajk,j,k->a", alpha, x, x)
    own = np.einsum("ijkl,j,k,l->i", beta, x, x, x)
    free = np.delete(np.arange(3), m)
    own += 2 * np.einsum("ajk,a,k->j", alpha[free], q[free], x)
    own += np.einsum("ikjl,k,j,l->i", D, x, y, y)
    own -= (TURNING[0] * np.cos(angle) + TURNING[1] * np.sin(angle)) @ x
    right[m] -= own
    mass = np.eye(3)
    mass[np.ix_(m, m)] += np.einsum("ikjl,k,l->ij", D, x, x)
    return np.concatenate([v, np.linalg.solve(mass, right)])


def test_motion_is_that_of_the_equations() -> None:
    flow, times = BentFlow.of(mechanics(), OMEGA), np.linspace(0, SPAN, 7)
    found = flow.run(*START, SPAN, times=times)
    assert found.changes >= 8
    start = np.concatenate(START)
    exact = solve_ivp(
        rates, (0, SPAN), start, "DOP853", times, rtol=1e-11, atol=1e-13, max_step=0.02
    )
    size = np.abs(exact.y).max()
    assert np.abs(found.q_at - exact.y[:3].T).max() < 1e-8 * size
    assert np.abs(found.velocity_at - exact.y[3:].T).max() < 1e-8 * size


def test_derivative_by_the_first_state_against_differences() -> None:
    flow, start, step = BentFlow.of(mechanics(), OMEGA), np.concatenate(START), 1e-6
    found = flow.run(*START, SPAN, along=np.eye(6)).transition
    assert found is not None
    columns = []
    for change in step * np.eye(6):
        ends = [flow.run(*np.split(start + sign * change, 2), SPAN) for sign in (1, -1)]
        columns.append(np.concatenate([e.q, e.velocity]) for e in ends)
    difference = np.array([(a - b) / (2 * step) for a, b in columns]).T
    assert np.abs(found - difference).max() < 1e-6 * np.abs(found).max()


def test_without_second_order_terms_it_is_the_linear_flow() -> None:
    tensors = {name: 0 * each for name, each in MODEL.kinematics.tensors.items()}
    nothing = replace(MODEL, kinematics=SecondOrder(MASTERS, **tensors))
    push = replace(PUSH, turning=np.zeros((2, 2, 2)))
    bent = replace(mechanics(nothing), excitations=(push,))
    straight = replace(bent, model=MODEL.linearised, forces=())
    flows = BentFlow.of(bent, OMEGA), DampedFlow.of(straight, OMEGA)
    one, other = (each.run(*START, SPAN, along=np.eye(6)) for each in flows)
    assert one.changes == other.changes > 0
    np.testing.assert_allclose(one.q, other.q, atol=1e-11)
    np.testing.assert_allclose(one.transition, other.transition, atol=1e-9)


def test_work_put_in_is_energy_gained_and_lost() -> None:
    still = mechanics(gaps=STILL)
    flow, times = BentFlow.of(still, OMEGA), np.linspace(0, SPAN, 19201)
    found = flow.run(*START, SPAN, times=times)
    q, v, m = found.q_at, found.velocity_at, MASTERS
    wave = np.cos(OMEGA * times)[:, None], np.sin(OMEGA * times)[:, None]
    push = wave[0] * PUSH.cosine + wave[1] * PUSH.sine
    turned = sum(w * (q[:, m] @ t) for w, t in zip(wave, TURNING, strict=True))
    power = np.sum(push * v, axis=1) + np.sum(turned * v[:, m], axis=1)
    power -= np.einsum("si,ij,sj->s", v, C, v)
    gained = flow.energy(q[-1], v[-1], OMEGA * SPAN) - flow.energy(q[0], v[0])
    step, weights = times[1], np.full(len(times), 2.0)
    weights[1::2], weights[[0, -1]] = 4.0, 1.0
    assert abs(step / 3 * weights @ power - gained) < 1e-8 * np.abs(power).sum() * step
