"""Folds of a branch of driven motions: where its frequency turns back."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.driven_flow import DrivenFlow
from fenics_nnm.time_domain.driven_map import DrivenMap, Missed
from fenics_nnm.time_domain.driven_motion import Arrived, DrivenOrbit, Step, arrived, orbit_of

#: Motions nearer to each other than this, relative in the energy norm, are the fold.
_TOLERANCE = 1e-9

#: Largest number of motions that are shot.
_MOST = 80


def fold_between(flow: DrivenFlow, before: DrivenOrbit, after: DrivenOrbit) -> DrivenOrbit:
    """The exact motion at which the branch turns back between two of its motions.

    Motions on the way from one to the other are shot with the frequency left open; the tangent of
    the branch has no part along the frequency at the fold. The way is halved until it has no
    length, as beside a grazing motion the tangent turns with the root of the distance.

    Args:
        flow: Flow of the model.
        before: A motion on one side of the fold.
        after: One on the other side.

    Returns:
        The motion, with a failure if the branch does not turn back in between.
    """
    equations = DrivenMap.around(flow.at(before.omega), before.q, before.velocity)
    left, right = (
        equations.unknowns(each.q, each.velocity, each.omega) for each in (before, after)
    )
    along = right - left
    if np.sign(equations.tangent(left, along)[-1]) == np.sign(equations.tangent(right, along)[-1]):
        return _no_fold(equations, left, "the branch does not turn back between the two motions")
    rising = np.sign(equations.tangent(left, along)[-1])
    for _ in range(_MOST):
        found = arrived(equations, (left + right) / 2, _across(equations, along))
        if found.failure:
            return orbit_of(equations, found)
        if np.sign(equations.tangent(found.unknowns, along)[-1]) == rising:
            left = found.unknowns
        else:
            right = found.unknowns
        if np.linalg.norm(right - left) < _TOLERANCE:
            break
    return orbit_of(equations, arrived(equations, (left + right) / 2, _across(equations, along)))


def _across(equations: DrivenMap, along: Array) -> Step:
    """Steps of state and frequency that are orthogonal to a direction."""

    def step(unknowns: Array, miss: Missed) -> Array:
        matrix = np.vstack([equations.jacobian(unknowns, miss), along])
        return np.linalg.solve(matrix, np.append(-miss.values, 0.0))

    return step


def _no_fold(equations: DrivenMap, at: Array, reason: str) -> DrivenOrbit:
    return orbit_of(equations, Arrived(at, equations.miss(at), 0, reason))
