"""The way down in damping by arc-length: through folds, and what is said where it ends."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.backbone import damped_arc
from fenics_nnm.backbone.damped_arc import arc_walk
from fenics_nnm.backbone.damped_descent import by_arc, largest_share
from fenics_nnm.backbone.damped_model import DampedModel
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.resonant_arc import ResonantArc
from fenics_nnm.time_domain.resonant_map import ResonantMap
from fenics_nnm.time_domain.resonant_motion import (
    ResonantMotion,
    driven_by_push,
    resonant_motion,
)

PUSH = np.array([1.0, 0.0])


def damped(second: float, shape: float, flexibility: float, ratio: float) -> DampedModel:
    omega = np.array([1.0, second])
    model = ReducedModel(omega, np.array([[1.0, shape]]), np.array([[flexibility]]), np.ones(1))
    return DampedModel(model, np.diag(2 * ratio * omega), PUSH, 0)


#: Steps of the damping end at s = 0.4497, where the family turns back.
FOLDED, FOLDED_GAMMA = damped(2.34205, -2.36245, 0.054984, 0.003), 2.79394
BEFORE = [1.5220381, 0.3443141, -0.0456227, 0.0511420, 1.0478743, 0.0193069]


def near(at: DampedModel, s: float, gamma: float, state: list[float]) -> ResonantMotion:
    """The motion near a state, on the way."""
    guess = ResonantMotion.guessed(np.array(state))
    found = resonant_motion(driven_by_push(at.model, at.rate_at(s), PUSH), PUSH, gamma, guess)
    assert not found.failure
    return found


def equations(at: DampedModel, gamma: float, s: float) -> ResonantMap:
    flow = driven_by_push(at.model, at.rate_at(s), PUSH)
    return ResonantMap(flow, PUSH, gamma, 1.05, 0.02)


def test_a_family_is_followed_through_its_folds() -> None:
    gamma, s = FOLDED_GAMMA * FOLDED.grazing_gamma, 0.4496875
    begin = near(FOLDED, s, gamma, BEFORE)
    way = arc_walk(lambda number: equations(FOLDED, gamma, number), (s, begin))
    first, second = way.folds
    assert first.s == pytest.approx(0.4496, abs=2e-4)
    assert second.s == pytest.approx(0.6284, abs=2e-4)
    assert way.motion is not None and not way.failure
    assert way.motion.omega == pytest.approx(1.0382947, rel=1e-6)
    flow = driven_by_push(FOLDED.model, FOLDED.rate, way.motion.level * PUSH)
    period = 2 * np.pi / way.motion.omega
    after = flow.driven_by(flow.drive.at(way.motion.omega)).run(
        way.motion.q, way.motion.velocity, period
    )
    assert after.q == pytest.approx(way.motion.q, abs=1e-8)
    assert after.velocity == pytest.approx(way.motion.velocity, abs=1e-8)


def test_derivatives_are_those_of_differences() -> None:
    gamma, s = FOLDED_GAMMA * FOLDED.grazing_gamma, 0.4496875
    begin = near(FOLDED, s, gamma, BEFORE)
    arc = ResonantArc(lambda number: equations(FOLDED, gamma, number))
    x = np.append(arc.equations(s).unknowns(*_parts(begin)), s)
    _, jacobian, _ = arc._linearised(x)

    def values(at: Array) -> Array:
        return arc.equations(float(at[-1])).missed(at[:-1]).values

    for k in range(len(x)):
        step = np.zeros_like(x)
        step[k] = 1e-6
        slope = (values(x + step) - values(x - step)) / 2e-6
        assert jacobian[:, k] == pytest.approx(slope, abs=3e-5)
    assert jacobian @ arc.first(x, -1.0).tangent == pytest.approx(0.0, abs=1e-6)


def test_a_way_that_leads_back_says_where_and_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(damped_arc, "_BACK", 0.22)
    model = damped(5.71775, -1.53009, 0.033714, 0.001)
    gamma, s = 1.48142 * model.grazing_gamma, 0.1938671875
    state = [1.1514927, 0.0985831, -0.0201748, 0.0229178, 1.0906533, 0.00366368]
    found = by_arc(model, gamma, (s, near(model, s, gamma, state)))
    assert found.failure == (
        "the path of falling damping has a fold at a damping ratio of 0.30 %, where a contact "
        "begins or ends and mode 2 in harmonic 5 has 1.6 % of the kinetic energy: it leads back "
        "to heavy damping"
    )
    assert model.least_other_at(0.193) == pytest.approx(0.001**0.807 * 0.3**0.193)


def test_largest_share_is_that_of_a_linear_motion() -> None:
    """Without contact mode 2 moves by its receptance alone, in the first harmonic."""
    model, push = damped(2.0, 1.0, 0.1, 0.01).model, np.array([1.0, 5.0])
    both = DampedModel(model, np.diag(0.02 * model.omega), push, 0)
    gamma = 0.1 * both.grazing_gamma
    flow = driven_by_push(model, both.rate, push)
    found = resonant_motion(flow, push, gamma, both.linear(gamma))
    omega = found.omega
    moved = np.abs(push / (model.omega**2 - omega**2 + 1j * omega * np.diag(both.rate)))
    share = moved[1] ** 2 / np.sum(moved**2)
    assert largest_share(flow, found, 0) == f"mode 2 in harmonic 1 has {100 * share:.1f} %"


def _parts(motion: ResonantMotion) -> tuple[Array, Array, float, float]:
    return motion.q, motion.velocity, motion.omega, motion.level
