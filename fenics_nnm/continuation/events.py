"""Folds and simple branch points between two points of a branch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import CurvePoint, Metric, Problem, curve_point, null_space
from fenics_nnm.continuation.segment import NotOnSegmentError, Segment
from fenics_nnm.nonlinear.conditions import Quantity
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

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


@dataclass(frozen=True, slots=True)
class EventTest:
    """A function of the points of a branch that changes sign at an event.

    Attributes:
        kind: What happens there, in words.
        value: From equations and a point to the function.
        may_change: From the points at both ends of a step to whether it may change sign between.
        located_with_kernel: Whether the null space belongs to the event.
    """

    kind: str
    value: Callable[[Problem, CurvePoint], float]
    may_change: Callable[[CurvePoint, CurvePoint], bool] = lambda first, second: True
    located_with_kernel: bool = False


@dataclass(frozen=True, slots=True)
class Event:
    """A point of a branch where it turns back or meets another.

    Attributes:
        kind: What happens, in words.
        point: The point.
        bracket: Length of the branch to which it is located.
        at_kink: Whether the function that shows the event jumps through zero instead of passing it:
            contact opens or closes at a sample there, and the point is bracketed, no more.
        singular_values: The smallest singular values of the scaled Jacobian, ascending; the first
            belongs to the tangent and is 0. Empty for folds.
        kernel: Directions of the null space besides the tangent, unit vectors in the scaled
            unknowns of the point, as rows; none for folds, and for branch points at kinks.
    """

    kind: str
    point: CurvePoint
    bracket: float
    at_kink: bool
    singular_values: Array = field(default_factory=lambda: np.empty(0))
    kernel: Array = field(default_factory=lambda: np.empty((0, 0)))

    @property
    def solution(self) -> Solution:
        """Motion at the event."""
        return self.point.solution


def branch_point_at(problem: Problem, solution: Solution, along: Unknowns) -> Event:
    """A branch point that was located before.

    Args:
        problem: Equations.
        solution: Motion at the branch point.
        along: Direction of the known branch.
    """
    equations = problem.about(solution.omega)
    metric = Metric.about(equations, solution.at)
    way = metric.scaled(along)
    at = replace(curve_point(equations, solution, way), tangent=way / np.linalg.norm(way))
    values, kernel = _kernel(problem, at)
    return Event(BRANCH_POINT.kind, at, 0.0, not len(kernel), values, kernel)


def fold(quantity: Quantity) -> EventTest:
    """Where a quantity has an extremum along the branch: its slope d ln / ds changes sign."""

    def slope(problem: Problem, point: CurvePoint) -> float:
        equations, step = problem.about(point.solution.omega), point.metric.unscaled(point.tangent)
        return quantity.slope(equations, point.solution, step)

    return EventTest(f"fold in {quantity.name}", slope)


def branching(problem: Problem, point: CurvePoint) -> float:
    """Smallest singular value of the Jacobian besides that of the tangent, with a sign.

    The sign is that of the determinant of the bordered Jacobian.
    """
    equations = problem.about(point.solution.omega)
    values, _ = null_space(equations, point.metric, point.solution)
    return point.orientation * float(values[1])


#: Where another branch crosses; most steps show to have none without singular values.
BRANCH_POINT = EventTest(
    "branch point",
    branching,
    lambda first, second: first.orientation * second.orientation < 0,
    located_with_kernel=True,
)


def events_on(
    segment: Segment, tests: Sequence[EventTest], tolerance: float, *, located: bool = True
) -> list[tuple[float, Event]]:
    """Events between two points of a branch with their fractions of the chord, in order.

    Two events of a kind in one segment cancel and are not seen: smaller steps show them.

    Args:
        segment: The piece of the branch.
        tests: What to look for.
        tolerance: Length to which events are located.
        located: Else they are only reported, at the end of the segment.

    Raises:
        NotOnSegmentError: if one cannot be located.
    """
    first, second = segment.first, segment.second
    found = []
    for test in tests:
        if not test.may_change(first, second):
            continue
        ends = test.value(segment.problem, first), test.value(segment.problem, second)
        if ends[0] * ends[1] < 0 and min(map(abs, ends)) > _LEVEL:
            if located:
                found.append(_located(segment, test, ends, tolerance))
            else:
                found.append((1.0, Event(test.kind, second, segment.length, at_kink=True)))
    return sorted(found, key=lambda item: item[0])


def _located(
    segment: Segment, test: EventTest, ends: tuple[float, float], tolerance: float
) -> tuple[float, Event]:
    problem, value = segment.problem, test.value
    fraction = segment.zero(lambda point: value(problem, point), 0.0, 1.0, tolerance)
    at = segment.at(fraction)
    jumps = abs(value(problem, at)) > _JUMP * min(map(abs, ends))
    if jumps:
        _check_continuity(segment, fraction, tolerance)
    if not test.located_with_kernel:
        return fraction, Event(test.kind, at, tolerance, jumps)
    at = replace(at, tangent=_tangent(segment, fraction))
    values, kernel = _kernel(problem, at)
    kernel = np.empty((0, at.tangent.size)) if jumps else kernel
    return fraction, Event(test.kind, at, tolerance, jumps, values, kernel)


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


def _kernel(problem: Problem, point: CurvePoint) -> tuple[Array, Array]:
    """Smallest singular values, and the null space besides the tangent."""
    equations = problem.about(point.solution.omega)
    values, vectors = null_space(equations, point.metric, point.solution)
    null = vectors[values < _ZERO]
    across = null - np.outer(null @ point.tangent, point.tangent)
    _, sizes, directions = np.linalg.svd(across, full_matrices=False)
    return values[: len(null) + 3], directions[sizes > 0.5]
