"""A tongue of an internal resonance, 3 omega = omega_2, is traced in and out."""

import numpy as np
import pytest

from fenics_nnm.nonlinear.arc_length import unknowns
from fenics_nnm.nonlinear.contact_law import Complementarity
from fenics_nnm.nonlinear.events import Event, EventKind
from fenics_nnm.nonlinear.fourier import CosineSeries
from fenics_nnm.nonlinear.harmonic_copy import linear_motion
from fenics_nnm.nonlinear.mode import HarmonicEquations
from fenics_nnm.nonlinear.newton import FixedEnergy, Solution, solve
from fenics_nnm.nonlinear.step_test import kinetic_shares
from fenics_nnm.nonlinear.trace import TracePoint, trace
from fenics_nnm.nonlinear.trace_options import Heading, Range
from fenics_nnm.reduction.model import ReducedModel

GRAZING = 0.25

MODEL = ReducedModel(omega=[1.0, 3.4], Phi=[[1.0, 1.0]], R=[[0.1]], gap=[1.0])

EQUATIONS = HarmonicEquations(MODEL, CosineSeries(6, 72), Complementarity(MODEL.R, MODEL.gap))


@pytest.fixture(scope="module")
def points() -> list[TracePoint]:
    branch = trace(
        EQUATIONS, linear_motion(EQUATIONS, 0), Heading.GAMMA_UP, gamma=Range(high=20 * GRAZING)
    )
    found = list(branch)
    assert branch.reason == "gamma leaves its range at 5"
    return found


def folds(points: list[TracePoint], *, at_kink: bool) -> list[Event]:
    """Folds in gamma, in the order of the branch."""
    events = [point.event for point in points if point.event is not None]
    return [e for e in events if e.kind is EventKind.FOLD_IN_GAMMA and e.at_kink == at_kink]


def test_in_and_out(points: list[TracePoint]) -> None:
    gamma = np.array([point.solution.energies.gamma for point in points]) / GRAZING
    followed = np.array([kinetic_shares(EQUATIONS, p.solution.q)[1, 0] for p in points])
    tip = int(np.argmin(followed))
    assert followed[tip] < 1e-3  # all energy in mode 2, in its third harmonic
    assert kinetic_shares(EQUATIONS, points[tip].solution.q)[3, 1] > 0.99
    assert gamma[tip] > 8
    fold = folds(points, at_kink=False)[-1]
    assert fold.solution.energies.gamma / GRAZING < 2.6  # all the way down
    assert gamma[-1] == pytest.approx(20)
    assert followed[-1] > 0.7  # and on along the main branch
    assert fold.bracket <= 1e-8
    lengths = [point.length for point in points]
    assert np.all(np.diff(lengths) >= 0)


def at_energy(start: Solution, gamma: float) -> Solution:
    return solve(EQUATIONS, FixedEnergy(gamma), start.q, start.omega)


def test_two_motions_on_one_side_of_a_fold_and_none_on_the_other(
    points: list[TracePoint],
) -> None:
    fold = folds(points, at_kink=False)[-1].place
    lowest = fold.solution.energies.gamma

    def beside(part: float) -> tuple[Solution, ...]:
        """Motions at a slightly larger energy, from guesses to both sides along the tangent."""
        guesses = (
            fold.at.moved(fold.metric.unscaled(sign * fold.tangent), np.sqrt(part))
            for sign in (-1, 1)
        )
        constraint = FixedEnergy(lowest * (1 + part))
        return tuple(solve(EQUATIONS, constraint, g.q, g.omega) for g in guesses)

    distances = []
    for part in (1e-6, 4e-6):
        pair = beside(part)
        assert all(found.converged for found in pair)
        way = fold.metric.between(unknowns(pair[0]), unknowns(pair[1]))
        distances.append(float(np.linalg.norm(way)))
    assert distances[1] / distances[0] == pytest.approx(2, rel=0.02)  # a quadratic fold
    below = at_energy(fold.solution, lowest * (1 - 1e-6))
    if below.converged:  # then it is far away
        assert np.linalg.norm(fold.metric.between(fold.at, unknowns(below))) > 0.1


def test_energies_of_the_way_in_and_out_are_told_apart(points: list[TracePoint]) -> None:
    """Newton's iteration at the energies of the trace keeps each of its motions."""
    ratios = (3.0, 5.0)
    branch = trace(
        EQUATIONS,
        linear_motion(EQUATIONS, 0),
        Heading.GAMMA_UP,
        gamma=Range(high=20 * GRAZING, targets=tuple(r * GRAZING for r in ratios)),
    )
    hits = [point.solution for point in branch if point.target][:-1]
    for ratio in ratios:
        here = [s for s in hits if abs(s.energies.gamma / (ratio * GRAZING) - 1) < 1e-10]
        assert len(here) == 3  # up the tongue, down again, and on the main branch
        assert np.ptp([solution.omega for solution in here]) > 1e-3
        for solution in here:
            again = at_energy(solution, ratio * GRAZING)
            assert again.iterations <= 1
            assert again.omega == pytest.approx(solution.omega, rel=1e-9)
