"""Tracing a branch by pseudo-arclength: predictor, corrector, step control, targets and bounds.

Where the equations are only piecewise smooth (contact opens or closes at a sample) the branch has
kinks, see `continuation.kinks`. A step must pass tests before it is taken: it may not turn much,
must pass the test of the caller, must lead back, and what it seems to have passed must be found.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import (
    FixedArc,
    Metric,
    Place,
    Problem,
    null_space,
    place,
    unknowns,
)
from fenics_nnm.continuation.continuity import Continuity, StepTest
from fenics_nnm.continuation.events import Event, events_on, gamma_slope, omega_slope
from fenics_nnm.continuation.kinks import ways_on
from fenics_nnm.continuation.segment import NotOnSegmentError, Segment
from fenics_nnm.continuation.trace_options import ArcLength, Heading, Predictor, Range
from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.full_order import Equations
from fenics_nnm.nonlinear.newton import (
    Constraint,
    FixedEnergy,
    FixedFrequency,
    Solution,
    Unknowns,
)

#: In a step shorter than this many smallest ones, events that are not found are told as they are.
_SHORT = 4

#: Why a step is refused that meets no other objection.
_UNLOCATED = "a fold, branch point or target within a step is not found"

#: A step back finds the point before where it misses it by less than this part of the step.
_RETURNED = 1e-2

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

#: A slope below this tells no direction.
_LEVEL = 1e-9

#: Where that fails, it is looked for to this part of a step, by its place on the branch alone.
_HIT = 1e-14

#: A target is looked for along the branch to this part of a step, then at once.
_ROUGH = 1e-3


@dataclass(frozen=True, slots=True)
class TracePoint:
    """A point of the branch.

    Attributes:
        place: The point with its tangent.
        length: Length of the branch from its start.
        event: What happens there, or None.
        target: Whether it is one of the values to be hit.
    """

    place: Place
    length: float
    event: Event | None = None
    target: bool = False

    @property
    def solution(self) -> Solution:
        """Motion."""
        return self.place.solution


_Hit = tuple[float, Place, str]
"""Fraction of a step, point, and whether a range is left there: why the branch ends, or nothing."""

_Span = tuple[
    str, Range, Callable[[Solution], float], Callable[[float], FixedEnergy | FixedFrequency]
]
"""Name, range and value of what is bounded, and the constraint that fixes it."""


@dataclass(frozen=True, slots=True)
class _Step:
    """A step, the events on it with their fractions of it, and the targets hit."""

    segment: Segment
    events: list[tuple[float, Event]]
    hits: list[_Hit]


@dataclass(slots=True)
class Trace:
    """Points along a branch, to be iterated over once; `reason` says why they end.

    Attributes:
        problem: Equations.
        start: Point to start from; it is not among the points.
        options: Configuration.
        gamma: Range of gamma, with targets.
        omega: Range of omega, with targets.
        stop: From a motion to why the branch ends there, or nothing.
        accept: Whether a step has stayed on the branch.
        reason: Why the branch has ended, empty until then.
    """

    problem: Problem
    start: Place
    options: ArcLength
    gamma: Range
    omega: Range
    stop: Callable[[Solution], str]
    accept: StepTest
    reason: str = ""

    def __iter__(self) -> Iterator[TracePoint]:
        """The points in the order of the branch; `reason` is set when they end."""
        here, last, length, travelled = self.start, None, self.options.step, 0.0
        for _ in range(self.options.points):
            step, length, failure = self._advanced(here, last, length)
            if step is None:
                self.reason = failure
                return
            segment, reached = step.segment, step.segment.second
            for fraction, point in self._between(step):
                yield TracePoint(
                    point.place, travelled + fraction * segment.length, point.event, point.target
                )
                if self.reason:
                    return
            travelled += segment.length
            yield TracePoint(reached, travelled)
            self.reason = self.stop(reached.solution) or self._comes_to_rest(here, reached)
            if self.reason:
                return
            here, last = reached, here
        self.reason = f"points = {self.options.points} steps were taken: raise it to go on"

    def _comes_to_rest(self, here: Place, reached: Place) -> str:
        """Why there is nothing to be found on the way down a linear mode, or nothing."""
        free = not (here.solution.energies.contact or reached.solution.energies.contact)
        falls = _gamma(reached.solution) < _gamma(here.solution)
        if free and falls and not self.gamma.low:
            return "the branch has come to a linear mode without contact, and leads down to rest"
        return ""

    def _advanced(
        self, here: Place, last: Place | None, length: float
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

    def _step(self, here: Place, reached: Place, *, past_kink: bool = False) -> _Step | None:
        """A step with what lies on it; None where that is not found, and the step can be shorter.

        A change of orientation without a branch point between is a jump to another branch.
        """
        segment, tolerance = Segment(self.problem, here, reached), self.options.event_tolerance
        try:
            events = events_on(segment, tolerance)
            return _Step(segment, events, self._hits(segment, events))
        except NotOnSegmentError:
            if segment.length > _SHORT * self.options.smallest_step and not past_kink:
                return None
            told = events_on(segment, tolerance, located=False)
            return _Step(segment, told, self._leaves(segment))

    def _direction(self, here: Place, last: Place | None) -> Array:
        """Unit vector of the prediction in the scaled unknowns about a point."""
        if last is None or self.options.predictor is Predictor.TANGENT:
            return here.tangent
        secant = here.metric.between(last.at, here.at)
        return np.asarray(secant / np.linalg.norm(secant))

    def _reached(
        self, here: Place, direction: Array, length: float, past_kink: Unknowns | None = None
    ) -> tuple[Place | None, str]:
        """The point a step away, from a guess past a kink or along the direction, or why not."""
        arc = FixedArc(here.metric, here.at, direction, length)
        guess = past_kink or here.at.moved(here.metric.unscaled(direction), length)
        found = self.problem.solve(arc, guess)
        if not found.converged:
            return None, f"Newton's iteration fails: {found.failure}"
        way = here.metric.between(here.at, unknowns(found))
        turn = float(np.degrees(np.arccos(min(1.0, length / float(np.linalg.norm(way))))))
        if turn > (_LARGEST_TURN_AT_KINK if past_kink else self.options.largest_turn):
            return None, f"the branch turns by {turn:.0f} degrees in a step"
        equations = self.problem.about(found.omega)
        refusal = self.accept(equations, here.solution, found)
        if refusal:
            return None, refusal
        return self._oriented(here, found, way), ""

    def _oriented(self, here: Place, found: Solution, way: Array) -> Place:
        """A point reached by a step, with the tangent that leads on."""
        equations = self.problem.about(found.omega)
        metric = Metric.about(equations, unknowns(found))
        ahead = metric.scaled(here.metric.unscaled(way))
        reached = place(equations, found, ahead)
        across = float(reached.tangent @ ahead) < _ACROSS * float(np.linalg.norm(ahead))
        if across and reached.orientation * here.orientation < 0:
            return reached.turned()
        return reached

    def _looseness(self, here: Place) -> str:
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

    def _leads_back(self, here: Place, reached: Place) -> bool:
        """Whether a step back from a point, along its own tangent, finds the one before.

        Where it does not, the step is likely to have led to another branch.
        """
        way = reached.metric.between(here.at, reached.at)
        length = float(np.linalg.norm(way))
        guess = reached.at.moved(reached.metric.unscaled(reached.tangent), -length)
        arc = FixedArc(reached.metric, reached.at, way / length, -length)
        found = self.problem.solve(arc, guess)
        missed = np.linalg.norm(reached.metric.between(here.at, unknowns(found)))
        return found.converged and float(missed) < _RETURNED * length

    def _past_kink(self, here: Place) -> Place | None:
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
        events = [(at, TracePoint(event.place, 0.0, event), "") for at, event in step.events]
        hits = [(at, TracePoint(hit, 0.0, target=True), leaves) for at, hit, leaves in step.hits]
        for fraction, point, leaves in sorted([*hits, *events], key=lambda item: item[0]):
            self.reason = leaves
            yield fraction, point
            if leaves:
                return

    def _hits(self, segment: Segment, events: list[tuple[float, Event]]) -> list[_Hit]:
        """Points where gamma or omega, monotonic between two events, has a wanted value.

        Raises:
            NotOnSegmentError: if one is not found.
        """
        found, fractions = [], [0.0, *(fraction for fraction, _ in events), 1.0]
        for low, high in itertools.pairwise(fractions):
            ends = segment.at(low).solution, segment.at(high).solution
            for name, span, value_of, fixed in self._spans:
                rising = value_of(ends[1]) - value_of(ends[0])
                for value in span.between(value_of(ends[0]), value_of(ends[1])):
                    fraction, at = _hit(segment, value_of, fixed, value, low, high)
                    found.append((fraction, at, _leaving(name, span, value, rising)))
        return found

    def _leaves(self, segment: Segment) -> list[_Hit]:
        """The end of a segment, if a range is left on it."""
        first, second = segment.first.solution, segment.second.solution
        for name, span, value_of, _ in self._spans:
            rising = value_of(second) - value_of(first)
            for value in span.between(value_of(first), value_of(second)):
                if leaves := _leaving(name, span, value, rising):
                    return [(1.0, segment.second, leaves)]
        return []

    @property
    def _spans(self) -> tuple[_Span, _Span]:
        return (
            ("gamma", self.gamma, _gamma, FixedEnergy),
            ("omega", self.omega, _omega, FixedFrequency),
        )


def trace(
    problem: Problem | Equations,
    start: Solution,
    heading: Heading | Unknowns,
    *,
    options: ArcLength | None = None,
    gamma: Range | None = None,
    omega: Range | None = None,
    stop: Callable[[Solution], str] = lambda solution: "",
    accept: StepTest | None = None,
) -> Trace:
    """Follow a branch from a motion.

    Args:
        problem: Equations, or how to have them about a frequency.
        start: A motion that solves them.
        heading: Which way to go: the sign of the first change of gamma or omega, or a direction.
        options: Configuration.
        gamma: Range of gamma, with targets.
        omega: Range of omega, with targets.
        stop: From a motion to why the branch ends there, or nothing.
        accept: Whether a step has stayed on the branch.

    Raises:
        ModelError: if the heading tells no direction at the start.
    """
    options = options or ArcLength()
    if not isinstance(problem, Problem):
        problem = Problem.of(problem, options.newton)
    return Trace(
        problem=problem,
        start=start_place(problem, start, heading),
        options=options,
        gamma=gamma or Range(),
        omega=omega or Range(),
        stop=stop,
        accept=accept or Continuity(),
    )


def start_place(problem: Problem, start: Solution, heading: Heading | Unknowns) -> Place:
    """A motion with the tangent that leads the wanted way.

    Raises:
        ModelError: if the heading tells no direction.
    """
    equations = problem.about(start.omega)
    metric = Metric.about(equations, unknowns(start))
    if isinstance(heading, Unknowns):
        return place(equations, start, metric.scaled(heading))
    _, vectors = null_space(equations, metric, start)
    first = place(equations, start, vectors[0])
    by_gamma = heading in (Heading.GAMMA_UP, Heading.GAMMA_DOWN)
    slope = (gamma_slope if by_gamma else omega_slope)(problem, first)
    if abs(slope) < _LEVEL:
        raise ModelError(f'heading "{heading}": the branch is level there; head by the other')
    up = heading in (Heading.GAMMA_UP, Heading.OMEGA_UP)
    return first if (slope > 0) == up else first.turned()


def _leaving(name: str, span: Range, value: float, rising: float) -> str:
    """That a range is left at a value, or nothing."""
    return f"{name} leaves its range at {value:g}" if span.left_at(value, rising) else ""


def _gamma(solution: Solution) -> float:
    return solution.energies.gamma


def _omega(solution: Solution) -> float:
    return solution.omega


def _hit(
    segment: Segment,
    value_of: Callable[[Solution], float],
    fixed: Callable[[float], Constraint],
    value: float,
    low: float,
    high: float,
) -> tuple[float, Place]:
    """Fraction and point where gamma or omega has a value, between two fractions."""

    def missing(point: Place) -> float:
        return value_of(point.solution) / value - 1

    for tolerance in (_ROUGH * segment.length, _HIT * segment.length):
        fraction = segment.zero(missing, low, high, tolerance)
        near = segment.at(fraction)
        try:
            exact = segment.solved(fixed(value), near.at)
        except NotOnSegmentError:
            continue
        return fraction, exact
    return fraction, near
