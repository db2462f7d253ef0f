"""Folds and simple branch points between two points of a branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import Metric, Place, Problem, null_space, place, unknowns
from fenics_nnm.continuation.segment import NotOnSegmentError, Segment
from fenics_nnm.nonlinear.newton import Solution, Unknowns

#: Slopes d ln gamma / ds and d ln omega / ds below this are round-off: the branch is level there.
_LEVEL = 1e-9

#: A function that changes sign, and is still this part of its values at the ends, jumps there.
_JUMP = 1e-2

#: Points this many tolerances to both sides of a kink are no farther apart than this part of the
#: step: else it is a gap.
_SIDES, _GAP = 4.0, 1e-2

#: The tangent at a branch point is taken from points this part of the step to both sides.
_BESIDE = 1e-2

#: Singular values of the scaled Jacobian below this count as zero.
_ZERO = 1e-6


class EventKind(StrEnum):
    """What happens at a point of a branch."""

    FOLD_IN_GAMMA = "fold in gamma"
    FOLD_IN_OMEGA = "fold in omega"
    BRANCH_POINT = "branch point"


@dataclass(frozen=True, slots=True)
class Event:
    """A point of a branch where it turns back or meets another.

    Attributes:
        kind: Kind.
        place: The point.
        bracket: Length of the branch to which it is located.
        at_kink: Whether the quantity that tells the event jumps through zero instead of passing it:
            contact opens or closes at a sample there, and the point is bracketed, no more.
        singular_values: The smallest singular values of the scaled Jacobian, ascending; the first
            belongs to the tangent and is 0. Empty for folds.
        kernel: Directions of the null space besides the tangent, unit vectors in the scaled
            unknowns of the place, as rows; none for folds, and for branch points at kinks.
    """

    kind: EventKind
    place: Place
    bracket: float
    at_kink: bool
    singular_values: Array = field(default_factory=lambda: np.empty(0))
    kernel: Array = field(default_factory=lambda: np.empty((0, 0)))

    @property
    def solution(self) -> Solution:
        """Motion at the event."""
        return self.place.solution


def branch_point_at(problem: Problem, solution: Solution, along: Unknowns) -> Event:
    """A branch point that was located before.

    Args:
        problem: Equations.
        solution: Motion at the branch point.
        along: Direction of the known branch.
    """
    equations = problem.about(solution.omega)
    metric = Metric.about(equations, unknowns(solution))
    way = metric.scaled(along)
    at = replace(place(equations, solution, way), tangent=way / np.linalg.norm(way))
    values, kernel = _kernel(problem, at)
    return Event(EventKind.BRANCH_POINT, at, 0.0, not len(kernel), values, kernel)


def gamma_slope(problem: Problem, point: Place) -> float:
    """Slope d ln gamma / ds along the tangent."""
    solution, step = point.solution, point.metric.unscaled(point.tangent)
    equations = problem.about(solution.omega)
    by_q, by_omega = equations.gamma_gradient(solution.q, solution.omega)
    slope = float(np.sum(by_q * step.q)) + by_omega * step.omega
    return slope / equations.gamma(solution.q, solution.omega)


def omega_slope(problem: Problem, point: Place) -> float:
    """Slope d ln omega / ds along the tangent."""
    return float(point.tangent[-1])


def branching(problem: Problem, point: Place) -> float:
    """Smallest singular value of the Jacobian besides that of the tangent, with a sign.

    The sign is that of the determinant of the bordered Jacobian.
    """
    equations = problem.about(point.solution.omega)
    values, _ = null_space(equations, point.metric, point.solution)
    return point.orientation * float(values[1])


def events_on(
    segment: Segment, tolerance: float, *, located: bool = True
) -> list[tuple[float, Event]]:
    """Events between two points of a branch with their fractions of the chord, in order.

    Two events of a kind in one segment cancel and are not seen: smaller steps show them.

    Args:
        segment: The piece of the branch.
        tolerance: Length to which events are located.
        located: Else they are only told, at the end of the segment.

    Raises:
        NotOnSegmentError: if one cannot be located.
    """
    first, second = segment.first, segment.second
    found = []
    for kind, value in (
        (EventKind.FOLD_IN_GAMMA, gamma_slope),
        (EventKind.FOLD_IN_OMEGA, omega_slope),
        (EventKind.BRANCH_POINT, branching),
    ):
        if kind is EventKind.BRANCH_POINT and first.orientation * second.orientation >= 0:
            continue  # the common case, without singular values
        ends = value(segment.problem, first), value(segment.problem, second)
        if ends[0] * ends[1] < 0 and min(map(abs, ends)) > _LEVEL:
            if located:
                found.append(_located(segment, kind, value, ends, tolerance))
            else:
                found.append((1.0, Event(kind, second, segment.length, at_kink=True)))
    return sorted(found, key=lambda item: item[0])


def _located(
    segment: Segment,
    kind: EventKind,
    value: Callable[[Problem, Place], float],
    ends: tuple[float, float],
    tolerance: float,
) -> tuple[float, Event]:
    problem = segment.problem
    fraction = segment.zero(lambda point: value(problem, point), 0.0, 1.0, tolerance)
    at = segment.at(fraction)
    jumps = abs(value(problem, at)) > _JUMP * min(map(abs, ends))
    if jumps:
        _check_continuity(segment, fraction, tolerance)
    if kind is not EventKind.BRANCH_POINT:
        return fraction, Event(kind, at, tolerance, jumps)
    at = replace(at, tangent=_tangent(segment, fraction))
    values, kernel = _kernel(problem, at)
    kernel = np.empty((0, at.tangent.size)) if jumps else kernel
    return fraction, Event(kind, at, tolerance, jumps, values, kernel)


def _check_continuity(segment: Segment, fraction: float, tolerance: float) -> None:
    """A kink has points near it to both sides; a gap is between two branches.

    Raises:
        NotOnSegmentError: if there is a gap.
    """
    beside = _SIDES * tolerance / segment.length
    sides = [segment.at(float(np.clip(fraction + step, 0, 1))) for step in (-beside, beside)]
    gap = np.linalg.norm(segment.metric.between(sides[0].at, sides[1].at))
    if gap > _GAP * segment.length:
        raise NotOnSegmentError("the step leads to another branch")


def _tangent(segment: Segment, fraction: float) -> Array:
    """Unit tangent at a branch point, where the Jacobian has two, from points to both sides."""
    sides = [segment.at(float(np.clip(fraction + step, 0, 1))) for step in (-_BESIDE, _BESIDE)]
    at = segment.at(fraction)
    chord = at.metric.between(sides[0].at, sides[1].at)
    return np.asarray(chord / np.linalg.norm(chord))


def _kernel(problem: Problem, point: Place) -> tuple[Array, Array]:
    """Smallest singular values, and the null space besides the tangent."""
    equations = problem.about(point.solution.omega)
    values, vectors = null_space(equations, point.metric, point.solution)
    null = vectors[values < _ZERO]
    across = null - np.outer(null @ point.tangent, point.tangent)
    _, sizes, directions = np.linalg.svd(across, full_matrices=False)
    return values[: len(null) + 3], directions[sizes > 0.5]
