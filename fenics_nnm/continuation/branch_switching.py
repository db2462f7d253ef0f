"""From a simple branch point on to the other branch.

At a simple branch point the null space of the Jacobian has the tangent t and one more direction n,
orthogonal to it. Motions with n . (y - y0) = +-length lie on the other branch, whatever its tangent
in the plane of t and n: the branch that is known stays near the line along t.

H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", 1977.
"""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import CurvePoint, FixedArc, Problem, curve_point
from fenics_nnm.continuation.events import BRANCH_POINT, Event
from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.unknowns import Unknowns

#: Lengths that are tried, from the shortest, as parts of the first one.
_LENGTHS = (1.0, 4.0, 16.0, 0.25)

#: A motion closer to the known branch than this part of the length is on it.
_SAME = 0.5


def switched(
    problem: Problem, event: Event, *, length: float = 1e-3
) -> tuple[CurvePoint | None, CurvePoint | None]:
    """Points of the other branch to both sides of a simple branch point, leading away from it.

    Args:
        problem: Equations.
        event: A branch point with a kernel of one dimension besides the tangent.
        length: Distance to step off along the second direction of the null space; where no motion
            is found, others of this order are tried.

    Returns:
        One point to each side, ready to be traced; None where there is none.

    Raises:
        ModelError: if the event is no simple branch point.
    """
    if event.kind != BRANCH_POINT.kind or len(event.kernel) != 1:
        raise ModelError(
            f"{event.kind} with {len(event.kernel)} directions besides the tangent:"
            " only a branch point with one has another branch to go over to"
        )
    sides = event.kernel[0], -event.kernel[0]
    first, second = (_other_branch(problem, event.point, side, length) for side in sides)
    return first, second


def _other_branch(
    problem: Problem, at: CurvePoint, normal: Array, length: float
) -> CurvePoint | None:
    for part in _LENGTHS:
        found = _stepped_off(problem, at, normal, part * length)
        if found is not None:
            return found
    return None


def _stepped_off(
    problem: Problem, at: CurvePoint, normal: Array, length: float
) -> CurvePoint | None:
    """The motion at a distance along the second direction, unless it is on the known branch."""
    guess = at.at.moved(at.metric.unscaled(normal), length)
    found = problem.solve(FixedArc(at.metric, at.at, normal, length), guess)
    if not found.converged:
        return None
    way = at.metric.between(at.at, found.at)
    if _distance_from_known(problem, at, way) < _SAME * length:
        return None
    equations = problem.about(found.omega)
    reached = curve_point(equations, found, way)
    ahead = reached.metric.scaled(at.metric.unscaled(way))
    return reached if reached.tangent @ ahead > 0 else reached.turned()


def _distance_from_known(problem: Problem, at: CurvePoint, way: Array) -> float:
    """Distance of a motion from the one of the known branch that is as far along the tangent."""
    along = float(way @ at.tangent)
    guess: Unknowns = at.at.moved(at.metric.unscaled(at.tangent), along)
    known = problem.solve(FixedArc(at.metric, at.at, at.tangent, along), guess)
    if not known.converged:
        return float(np.linalg.norm(way - along * at.tangent))
    return float(np.linalg.norm(way - at.metric.between(at.at, known.at)))
