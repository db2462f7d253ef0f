"""A tongue of an internal resonance, 3 omega = omega_2, is traced in and out."""

import numpy as np
import pytest

from fenics_nnm.backbone.continuity import Continuity, kinetic_shares
from fenics_nnm.backbone.harmonic_copy import linear_motion
from fenics_nnm.backbone.mode_trace import FOLD_IN_GAMMA, GAMMA_UP, mode_trace
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.continuation.events import Event
from fenics_nnm.continuation.trace import TracePoint
from fenics_nnm.continuation.trace_options import ArcLength, Range
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.conditions import FixedEnergy
from fenics_nnm.nonlinear.equations import harmonic_equations
from fenics_nnm.nonlinear.newton import solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

GRAZING = 0.25

MODEL = ReducedModel(omega=[1.0, 3.73], Phi=[[1.0, 1.1]], R=[[0.03]], gap=[1.0])

NEWTON = ArcLength().newton
EQUATIONS = harmonic_equations(MODEL, CosineSeries(6, 128), Complementarity(MODEL.R, MODEL.gap))


@pytest.fixture(scope="module")
def points() -> list[TracePoint]:
    wanted = Range(high=8 * GRAZING, targets=(3.8 * GRAZING, 4.1 * GRAZING))
    branch = mode_trace(
        Problem.of(EQUATIONS, NEWTON), linear_motion(EQUATIONS, 0), GAMMA_UP, gamma=wanted
    )
    found = list(branch)
    assert branch.reason == "gamma leaves its range at 2"
    return found


def folds(points: list[TracePoint], *, at_kink: bool) -> list[Event]:
    """Folds in gamma, in the order of the branch."""
    events = [point.event for point in points if point.event is not None]
    return [e for e in events if e.kind == FOLD_IN_GAMMA.kind and e.at_kink == at_kink]


def test_in_and_out(points: list[TracePoint]) -> None:
    followed = np.array([kinetic_shares(EQUATIONS, p.solution.q)[1, 0] for p in points])
    inside = int(np.argmin(followed))
    assert followed[inside] < 0.7
    assert kinetic_shares(EQUATIONS, points[inside].solution.q)[3, 1] > 0.25  # 3 omega = omega_2
    assert followed[-1] > 0.85  # and on along the main branch
    (top,), (bottom,) = folds(points, at_kink=True), folds(points, at_kink=False)
    assert top.solution.energies.gamma / GRAZING == pytest.approx(4.24, abs=0.02)
    assert bottom.solution.energies.gamma / GRAZING == pytest.approx(3.527, abs=0.002)
    assert max(top.bracket, bottom.bracket) <= 1e-8
    lengths = np.array([point.length for point in points])
    assert np.all(np.diff(lengths) >= 0)


def test_the_finest_sweep_over_energy_ends_at_the_fold(points: list[TracePoint]) -> None:
    """Continuation at fixed energies from below stops where the fold is located."""
    fold = folds(points, at_kink=True)[0].point
    gamma = fold.solution.energies.gamma
    for part, exists in ((1 - 1e-4, True), (1 + 1e-4, False)):
        found = at_energy(fold.solution, part * gamma)
        near = found.converged and np.linalg.norm(fold.metric.between(fold.at, found.at)) < 0.05
        assert near == exists


def at_energy(start: Solution, gamma: float) -> Solution:
    return solve(EQUATIONS, FixedEnergy(gamma), Unknowns.of(start.q, start.omega))


def test_two_motions_on_one_side_of_a_fold_and_none_on_the_other(
    points: list[TracePoint],
) -> None:
    fold = folds(points, at_kink=False)[-1].point
    lowest = fold.solution.energies.gamma

    def beside(part: float) -> tuple[Solution, ...]:
        """Motions at a slightly larger energy, from guesses to both sides along the tangent."""
        guesses = (
            fold.at.moved(fold.metric.unscaled(sign * fold.tangent), np.sqrt(part))
            for sign in (-1, 1)
        )
        constraint = FixedEnergy(lowest * (1 + part))
        return tuple(solve(EQUATIONS, constraint, g) for g in guesses)

    distances = []
    for part in (1e-6, 4e-6):
        pair = beside(part)
        assert all(found.converged for found in pair)
        way = fold.metric.between(pair[0].at, pair[1].at)
        distances.append(float(np.linalg.norm(way)))
    assert distances[1] / distances[0] == pytest.approx(2, rel=0.02)  # a quadratic fold
    below = at_energy(fold.solution, lowest * (1 - 1e-6))
    if below.converged:  # then it is far away
        assert np.linalg.norm(fold.metric.between(fold.at, below.at)) > 0.1


def test_targets_are_hit_on_each_way(points: list[TracePoint]) -> None:
    hits = [point.solution for point in points if point.target][:-1]
    for ratio in (3.8, 4.1):
        here = [s for s in hits if abs(s.energies.gamma / (ratio * GRAZING) - 1) < 1e-10]
        assert len(here) == 3  # up the tongue, down again, and on the main branch
        assert np.all(np.diff([solution.omega for solution in here]) > 1e-4)
        for solution in here:
            again = at_energy(solution, ratio * GRAZING)
            assert again.iterations <= 1
            assert again.omega == pytest.approx(solution.omega, rel=1e-9)


def test_branch_turns_back_at_the_first_contact() -> None:
    """At grazing the tangent beyond the kink leads down: contact begins below grazing."""
    model = ReducedModel(omega=[1.0, 3.99], Phi=[[1.0, -2.1]], R=[[0.1]], gap=[1.0])
    of = harmonic_equations(model, CosineSeries(6, 128), Complementarity(model.R, model.gap))
    branch = mode_trace(
        Problem.of(of, NEWTON),
        linear_motion(of, 0),
        GAMMA_UP,
        gamma=Range(high=2 * GRAZING, targets=(0.9 * GRAZING,)),
    )
    found = list(branch)
    assert branch.reason == "gamma leaves its range at 0.5"
    kink, smooth = folds(found, at_kink=True), folds(found, at_kink=False)
    assert kink[0].solution.energies.gamma == pytest.approx(GRAZING, rel=1e-3)
    assert smooth[0].solution.energies.gamma < 0.85 * GRAZING
    hits = [point.solution for point in found if point.target][:-1]
    assert [bool(s.forces.force.any()) for s in hits] == [False, True, True]
    for solution in hits[1:]:
        assert solution.omega > 1.0005
        assert solution.energies.virial_error(solution.omega) < 1e-9


def test_jumps_are_refused() -> None:
    continuity = Continuity()
    touching = at_energy(linear_motion(EQUATIONS, 0, amplitude=0.99), 1.2 * GRAZING)
    assert touching.forces.force.any()
    assert not continuity.refusal(EQUATIONS, touching, touching)
    free = linear_motion(EQUATIONS, 1, harmonic=3, amplitude=0.9)
    assert free.energies.gamma > GRAZING
    assert "one harmonic jumps by" in continuity.refusal(EQUATIONS, touching, free)
    loose = Continuity(largest_change=1.0)
    assert "contact is lost" in loose.refusal(EQUATIONS, touching, free)
    assert not Continuity(largest_change=1.0, grazing_gamma=np.inf).refusal(
        EQUATIONS, touching, free
    )
    assert not loose.refusal(EQUATIONS, touching, linear_motion(EQUATIONS, 0, amplitude=0.99))
