"""A branch of nonlinear modes that is followed by its length: over gamma and frequency."""

from __future__ import annotations

from fenics_nnm.backbone.continuity import Continuity
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.continuation.events import BRANCH_POINT, fold
from fenics_nnm.continuation.heading import Heading, Rising
from fenics_nnm.continuation.trace import Rules, Trace, trace
from fenics_nnm.continuation.trace_options import ArcLength, Bound, Range
from fenics_nnm.nonlinear.conditions import FREQUENCY, GAMMA
from fenics_nnm.nonlinear.solution import Solution

GAMMA_UP, GAMMA_DOWN = Rising(GAMMA), Rising(GAMMA, falls=True)
OMEGA_UP = Rising(FREQUENCY)

#: What may happen to a branch of nonlinear modes.
FOLD_IN_GAMMA, FOLD_IN_OMEGA = fold(GAMMA), fold(FREQUENCY)
EVENTS = (FOLD_IN_GAMMA, FOLD_IN_OMEGA, BRANCH_POINT)


def mode_trace(
    problem: Problem,
    start: Solution,
    heading: Heading,
    *,
    options: ArcLength | None = None,
    gamma: Range | None = None,
    omega: Range | None = None,
    rules: Rules | None = None,
) -> Trace:
    """Follow a branch of nonlinear modes from a motion.

    Args:
        problem: Equations about any frequency.
        start: A motion that solves them.
        heading: Which way to go.
        options: Configuration.
        gamma: Range of gamma, with targets.
        omega: Range of omega, with targets.
        rules: Whether a step has stayed on the branch, and where it ends; unless given, it ends on
            the way down a linear mode, except where gamma has a lower bound to come to.

    Raises:
        ModelError: if the heading shows no direction at the start.
    """
    gamma = gamma or Range()
    return trace(
        problem,
        start,
        heading,
        options=options,
        bounds=(Bound(GAMMA, gamma), Bound(FREQUENCY, omega or Range())),
        events=EVENTS,
        rules=rules or Continuity(to_rest=gamma.low > 0),
    )
