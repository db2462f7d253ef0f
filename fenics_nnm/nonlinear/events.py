"""Folds and simple branch points between two points of a branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.arc_length import Place, Problem, null_space
from fenics_nnm.nonlinear.newton import Solution
from fenics_nnm.nonlinear.segment import NotOnSegmentError, Segment

#: Slopes d ln gamma / ds and d ln omega / ds below this are round-off: the branch is level there.
_LEVEL = 1e-9

#: A function that changes sign, and is still this part of its values at the ends, jumps there.
_JUMP = 1e-2

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
        place: The point, located to the tolerance.
        at_kink: Whether the quantity that tells the event jumps through zero instead of passing it:
            contact at a sample opens or closes there, and the point is bracketed, no more.
        singular_values: The smallest singular values of the scaled Jacobian, ascending; the first
            belongs to the tangent and is 0. Empty for folds.
        kernel: Directions of the null space besides the tangent, unit vectors in the scaled
            unknowns of the place, as rows; none for folds.
        failure: Why the point could not be located to the tolerance; it is then an end of the step.
    """

    kind: EventKind
    place: Place
    at_kink: bool = False
    singular_values: Array = field(default_factory=lambda: np.empty(0))
    kernel: Array = field(default_factory=lambda: np.empty((0, 0)))
    failure: str = ""

    @property
    def solution(self) -> Solution:
        """Motion at the event."""
        return self.place.solution


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


def events_on(segment: Segment, tolerance: float) -> list[tuple[float, Event]]:
    """Events between two points of a branch with their fractions of the chord, in order.

    Two events of a kind in one segment cancel and are not seen: smaller steps show them.

    Args:
        segment: The piece of the branch.
        tolerance: Length to which events are located.
    """
    found = [
        _fold(segment, EventKind.FOLD_IN_GAMMA, gamma_slope, tolerance),
        _fold(segment, EventKind.FOLD_IN_OMEGA, omega_slope, tolerance),
        _branch_point(segment, tolerance),
    ]
    return sorted((item for item in found if item is not None), key=lambda item: item[0])


def _fold(
    segment: Segment,
    kind: EventKind,
    slope: Callable[[Problem, Place], float],
    tolerance: float,
) -> tuple[float, Event] | None:
    def value(point: Place) -> float:
        return slope(segment.problem, point)

    ends = value(segment.first), value(segment.second)
    if ends[0] * ends[1] >= 0 or min(map(abs, ends)) < _LEVEL:
        return None
    try:
        fraction = segment.zero(value, 0.0, 1.0, tolerance)
    except NotOnSegmentError as error:
        return 1.0, Event(kind, segment.second, failure=f"not located: {error}")
    at = segment.at(fraction)
    return fraction, Event(kind, at, at_kink=_jumps(value(at), ends))


def _branch_point(segment: Segment, tolerance: float) -> tuple[float, Event] | None:
    def value(point: Place) -> float:
        equations = segment.problem.about(point.solution.omega)
        values, _ = null_space(equations, point.metric, point.solution)
        return point.orientation * float(values[1])

    kind = EventKind.BRANCH_POINT
    if segment.first.orientation * segment.second.orientation >= 0:
        return None
    try:
        fraction = segment.zero(value, 0.0, 1.0, tolerance)
    except NotOnSegmentError as error:
        return 1.0, Event(kind, segment.second, failure=f"not located: {error}")
    at = segment.at(fraction)
    values, kernel = _kernel(segment.problem, at)
    ends = value(segment.first), value(segment.second)
    event = Event(kind, at, _jumps(value(at), ends), singular_values=values, kernel=kernel)
    return fraction, event


def _kernel(problem: Problem, point: Place) -> tuple[Array, Array]:
    """Smallest singular values, and the null space besides the tangent."""
    equations = problem.about(point.solution.omega)
    values, vectors = null_space(equations, point.metric, point.solution)
    null = vectors[values < _ZERO]
    across = null - np.outer(null @ point.tangent, point.tangent)
    _, sizes, directions = np.linalg.svd(across, full_matrices=False)
    return values[: len(null) + 3], directions[sizes > 0.5]


def _jumps(value: float, ends: tuple[float, float]) -> bool:
    return abs(value) > _JUMP * min(map(abs, ends))
