"""Tracing a branch by pseudo-arclength: predictor, corrector, step control, targets and bounds.

Where the equations are only piecewise smooth (contact opens or closes at a sample) the branch has
kinks, see `continuation.kinks`. A step must pass tests before it is taken: it may not turn much,
must pass the test of the caller, must lead back, and what it seems to have passed must be found.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import (
    CurvePoint,
    FixedArc,
    Metric,
    Problem,
    curve_point,
    null_space,
)
from fenics_nnm.continuation.events import BRANCH_POINT, Event, EventTest, events_on
from fenics_nnm.continuation.heading import Heading
from fenics_nnm.continuation.kinks import ways_on
from fenics_nnm.continuation.segment import NotOnSegmentError, Segment
from fenics_nnm.continuation.trace_options import ArcLength, Bound, Predictor
from fenics_nnm.nonlinear.equations import Equations
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: In a step shorter than this many smallest ones, events that are not found are left at its end.
_SHORT = 4

#: Why a step is refused that meets no other objection.
_UNLOCATED = "a fold, branch point or target within a step is not found"

#: A step back finds the point before where it misses it by less than this part of the step.
_RETURNED = 1e-2

#: It is solved to this part of the step, which shows as much as a solution to round-off.
_ROUGHLY = 1e-6

#: Singular values of the scaled Jacobian below this leave a direction loose.
_LOOSE = 1e-6

#: A kink is passed by steps of these multiples of the smallest one.
_PAST_KINK = (4.0, 16.0, 64.0, 256.0)

#: Largest angle in degrees between such a step and the tangent past the kink.
_LARGEST_TURN_AT_KINK = 80.0

#: After a kink the tangent may be this far across the step that led there.
_ACROSS = 0.5

#: A step that leads back along the branch has a cosine below this with the way ahead.
_BACK = -0.99

#: Where that fails, it is looked for to this part of a step, by its place on the branch alone.
_HIT = 1e-14

#: A target is looked for along the branch to this part of a step, then at once.
_ROUGH = 1e-3


class End(StrEnum):
    """Why a trace has ended."""

    LEFT_RANGE = "a quantity leaves its range"
    MOST_POINTS = "the largest number of steps was taken"
    RULE = "the rules of the branch end it"
    STUCK = "no step leads on"


class Rules(Protocol):
    """What a caller knows of the branch: steps that leave it, and where it ends."""

    def refusal(self, equations: Equations, before: Solution, after: Solution) -> str:
        """Why a step is not on the branch, or nothing."""

    def end(self, before: Solution, after: Solution) -> str:
        """Why the branch ends after a step, or nothing."""


@dataclass(frozen=True, slots=True)
class NoRules:
    """A branch that nothing more is known of."""

    def refusal(self, equations: Equations, before: Solution, after: Solution) -> str:
        """No step is refused."""
        return ""

    def end(self, before: Solution, after: Solution) -> str:
        """It ends nowhere."""
        return ""


@dataclass(frozen=True, slots=True)
class TracePoint:
    """A point of the branch.

    Attributes:
        point: The point with its tangent.
        length: Length of the branch from its start.
        event: What happens there, or None.
        target: Whether it is one of the values to be hit.
    """

    point: CurvePoint
    length: float
    event: Event | None = None
    target: bool = False

    @property
    def solution(self) -> Solution:
        """Motion."""
        return self.point.solution


_Hit = tuple[float, CurvePoint, str]
"""Fraction of a step, point, and whether a range is left there: why the branch ends, or nothing."""


@dataclass(frozen=True, slots=True)
class _Step:
    """A step, the events on it with their fractions of it, and the targets hit."""

    segment: Segment
    events: list[tuple[float, Event]]
    hits: list[_Hit]


@dataclass(slots=True)
class Trace:
    """Points along a branch, to be iterated over once; `end` and `reason` say why they end.

    Attributes:
        problem: Equations.
        start: Point to start from; it is not among the points.
        options: Configuration.
        bounds: Quantities with their ranges and targets.
        events: Events that are looked for.
        rules: What the caller knows of the branch.
        end: Why the branch has ended, None until then.
        reason: The same in words, with figures.
    """

    problem: Problem
    start: CurvePoint
    options: ArcLength
    bounds: tuple[Bound, ...]
    events: tuple[EventTest, ...]
    rules: Rules
    end: End | None = None
    reason: str = ""

    def __iter__(self) -> Iterator[TracePoint]:
        """The points in the order of the branch; `reason` is set when they end."""
        here, last, length, travelled = self.start, None, self.options.step, 0.0
        for _ in range(self.options.points):
            step, length, failure = self._advanced(here, last, length)
            if step is None:
                self._end(End.STUCK, failure)
                return
            segment, reached = step.segment, step.segment.second
            for fraction, point in self._between(step):
                yield TracePoint(
                    point.point, travelled + fraction * segment.length, point.event, point.target
                )
                if self.end:
                    return
            travelled += segment.length
            yield TracePoint(reached, travelled)
            if ended := self.rules.end(here.solution, reached.solution):
                self._end(End.RULE, ended)
                return
            here, last = reached, here
        taken = f"points = {self.options.points} steps were taken: raise it to go on"
        self._end(End.MOST_POINTS, taken)

    def _end(self, end: End, reason: str) -> None:
        self.end, self.reason = end, reason

    def _advanced(
        self, here: CurvePoint, last: CurvePoint | None, length: float
    ) -> tuple[_Step | None, float, str]:
        """The next step, the length to try after it, and why there is none."""
        direction, smallest, failure = self._direction(here, last), self.options.smallest_step, ""
        while length >= smallest:
            reached, failure = self._reached(here, direction, length)
            if reached is not None and not self._leads_back(here, reached):
                reached, failure = None, "a step back along the branch ends elsewhere"
            step = self._step(here, reached) if reached is not None else None
            if reached is not None and step is not None:
                spare = self.options.wanted_iterations - reached.solution.iterations
                factor = float(np.clip(2.0 ** (spare / 2), 0.5, self.options.growth))
                return step, min(length * factor, self.options.largest_step), ""
            length /= 2
        failure = (
            f"{failure or _UNLOCATED}, in steps down to smallest_step = {smallest:g}: lower it"
        )
        reached = self._past_kink(here)
        step = self._step(here, reached, past_kink=True) if reached is not None else None
        return step, 2 * smallest, failure if step else failure + self._looseness(here)

    def _step(
        self, here: CurvePoint, reached: CurvePoint, *, past_kink: bool = False
    ) -> _Step | None:
        """A step with what lies on it; None where that is not found, and the step can be shorter.

        A change of orientation without a branch point between is a jump to another branch.
        """
        segment, tolerance = Segment(self.problem, here, reached), self.options.event_tolerance
        try:
            events = events_on(segment, self.events, tolerance)
            return _Step(segment, events, self._hits(segment, events))
        except NotOnSegmentError:
            if segment.length > _SHORT * self.options.smallest_step and not past_kink:
                return None
            unlocated = events_on(segment, self.events, tolerance, located=False)
            return _Step(segment, unlocated, self._leaves(segment))

    def _direction(self, here: CurvePoint, last: CurvePoint | None) -> Array:
        """Unit vector of the prediction in the scaled unknowns about a point."""
        if last is None or self.options.predictor is Predictor.TANGENT:
            return here.tangent
        secant = here.metric.between(last.at, here.at)
        return np.asarray(secant / np.linalg.norm(secant))

    def _reached(
        self, here: CurvePoint, direction: Array, length: float, past_kink: Unknowns | None = None
    ) -> tuple[CurvePoint | None, str]:
        """The point a step away, from a guess past a kink or along the direction, or why not."""
        arc = FixedArc(here.metric, here.at, direction, length)
        guess = past_kink or here.at.moved(here.metric.unscaled(direction), length)
        found = self.problem.solve(arc, guess)
        if not found.converged:
            return None, f"Newton's iteration fails: {found.failure}"
        way = here.metric.between(here.at, found.at)
        turn = float(np.degrees(np.arccos(min(1.0, length / float(np.linalg.norm(way))))))
        if turn > (_LARGEST_TURN_AT_KINK if past_kink else self.options.largest_turn):
            return None, f"the branch turns by {turn:.0f} degrees in a step"
        equations = self.problem.about(found.omega)
        refusal = self.rules.refusal(equations, here.solution, found)
        if refusal:
            return None, refusal
        return self._oriented(here, found, way), ""

    def _oriented(self, here: CurvePoint, found: Solution, way: Array) -> CurvePoint:
        """A point reached by a step, with the tangent that leads on."""
        equations = self.problem.about(found.omega)
        metric = Metric.about(equations, found.at)
        ahead = metric.scaled(here.metric.unscaled(way))
        reached = curve_point(equations, found, ahead)
        across = float(reached.tangent @ ahead) < _ACROSS * float(np.linalg.norm(ahead))
        if across and reached.orientation * here.orientation < 0:
            return reached.turned()
        return reached

    def _looseness(self, here: CurvePoint) -> str:
        """What the null space says of a point that the branch does not leave."""
        equations = self.problem.about(here.solution.omega)
        values, _ = null_space(equations, here.metric, here.solution)
        loose = int(np.count_nonzero(values < _LOOSE))
        if loose == 1:
            return ""
        return (
            f"; {loose} directions of motion have no stiffness there: a branch point, or natural"
            " frequencies that are multiples of this frequency"
        )

    def _leads_back(self, here: CurvePoint, reached: CurvePoint) -> bool:
        """Whether a step back from a point, along its own tangent, finds the one before.

        Where it does not, the step is likely to have led to another branch.
        """
        way = reached.metric.between(here.at, reached.at)
        length = float(np.linalg.norm(way))
        guess = reached.at.moved(reached.metric.unscaled(reached.tangent), -length)
        arc = FixedArc(reached.metric, reached.at, way / length, -length)
        found = self.problem.roughly(_ROUGHLY * length).solve(arc, guess)
        missed = np.linalg.norm(reached.metric.between(here.at, found.at))
        return found.converged and float(missed) < _RETURNED * length

    def _past_kink(self, here: CurvePoint) -> CurvePoint | None:
        """A point beyond a kink that is less than the smallest step ahead."""
        for multiple in _PAST_KINK:
            length = multiple * self.options.smallest_step
            for direction, guess in ways_on(self.problem, here, length):
                reached, _ = self._reached(here, direction, length, guess)
                if reached is not None:
                    way = here.metric.between(here.at, reached.at)
                    if here.tangent @ way > _BACK * np.linalg.norm(way):
                        return reached
        return None

    def _between(self, step: _Step) -> Iterator[tuple[float, TracePoint]]:
        """Events and hit targets within a step, in order, with their fractions of the step."""
        events = [(at, TracePoint(event.point, 0.0, event), "") for at, event in step.events]
        hits = [(at, TracePoint(hit, 0.0, target=True), leaves) for at, hit, leaves in step.hits]
        for fraction, point, leaves in sorted([*hits, *events], key=lambda item: item[0]):
            if leaves:
                self._end(End.LEFT_RANGE, leaves)
            yield fraction, point
            if leaves:
                return

    def _hits(self, segment: Segment, events: list[tuple[float, Event]]) -> list[_Hit]:
        """Points where a bounded quantity, monotonic between two events, has a wanted value.

        Raises:
            NotOnSegmentError: if one is not found.
        """
        found, fractions = [], [0.0, *(fraction for fraction, _ in events), 1.0]
        for low, high in itertools.pairwise(fractions):
            ends = segment.at(low).solution, segment.at(high).solution
            for bound in self.bounds:
                first, last = map(bound.quantity.value, ends)
                for value in bound.range.between(first, last):
                    fraction, at = _hit(segment, bound, value, (low, high))
                    found.append((fraction, at, bound.leaving(value, last - first)))
        return found

    def _leaves(self, segment: Segment) -> list[_Hit]:
        """The end of a segment, if a range is left on it."""
        for bound in self.bounds:
            first = bound.quantity.value(segment.first.solution)
            last = bound.quantity.value(segment.second.solution)
            for value in bound.range.between(first, last):
                if leaves := bound.leaving(value, last - first):
                    return [(1.0, segment.second, leaves)]
        return []


def trace(
    problem: Problem,
    start: Solution,
    heading: Heading,
    *,
    options: ArcLength | None = None,
    bounds: Sequence[Bound] = (),
    events: Sequence[EventTest] = (BRANCH_POINT,),
    rules: Rules | None = None,
) -> Trace:
    """Follow a branch from a motion.

    Args:
        problem: Equations about any frequency.
        start: A motion that solves them.
        heading: Which way to go.
        options: Configuration.
        bounds: Quantities with their ranges and targets.
        events: Events to look for.
        rules: What is known of the branch.

    Raises:
        ModelError: if the heading shows no direction at the start.
    """
    return Trace(
        problem=problem,
        start=heading.first(problem, start),
        options=options or ArcLength(),
        bounds=tuple(bounds),
        events=tuple(events),
        rules=rules or NoRules(),
    )


def _hit(
    segment: Segment, bound: Bound, value: float, between: tuple[float, float]
) -> tuple[float, CurvePoint]:
    """Fraction and point where a quantity has a value, between two fractions."""

    def missing(point: CurvePoint) -> float:
        return bound.quantity.value(point.solution) / value - 1

    for tolerance in (_ROUGH * segment.length, _HIT * segment.length):
        fraction = segment.zero(missing, *between, tolerance)
        near = segment.at(fraction)
        try:
            exact = segment.solved(bound.quantity.fixed(value), near.at)
        except NotOnSegmentError:
            continue
        return fraction, exact
    return fraction, near
