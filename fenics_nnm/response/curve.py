"""The response of a driven structure through contact, followed along its curve by arc-length.

The frequency is the parameter: the curve is followed from the lowest frequency, through folds where
it turns back, to the highest one. Where it does not arrive there it is followed from the highest
frequency, too, as another branch. Points are those of the continuation, the wanted frequencies
as often as the curve passes them, folds, and peaks of the first place that is watched.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.continuation.events import BRANCH_POINT, fold
from fenics_nnm.continuation.heading import Rising
from fenics_nnm.continuation.segment import Segment
from fenics_nnm.continuation.trace import End, Rules, Trace, TracePoint, trace
from fenics_nnm.continuation.trace_options import ArcLength, Bound, Range
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.conditions import FREQUENCY, FixedFrequency
from fenics_nnm.nonlinear.equations import Equations
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.timed import TimedEquations
from fenics_nnm.response.driven import point_of
from fenics_nnm.response.first_motion import first_motion
from fenics_nnm.response.judge import Judge, judge_of
from fenics_nnm.response.peak_events import Crest, crests
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.structure import DrivenStructure

#: A motion at a wanted frequency is farther from its guess than this part of a step: another one.
_FARTHEST = 0.5

#: Newton's iteration along the curve. The equations are smooth: where the line search does not lead
#: on quickly the step along the curve is too long, and a shorter one is cheaper.
_SHORT_STEPS = Newton(
    tolerance=1e-12, round_off=1e-10, iterations=8, shortest_fraction=2.0**-2, leaps=0
)

#: A curve closes where its start is beside a step by less than this part of it.
_BESIDE = 0.2

#: A wanted frequency this near to the end of a step, over it, is that of the end.
_ABOVE = 1 + 1e-9

#: Motions at one frequency that differ by less than this part of their size are the same.
_SAME = 1e-6


@dataclass(frozen=True, slots=True)
class Curve:
    """The response at one level of the forces.

    Attributes:
        points: Its points, branch by branch, in the order of each.
        reason: Why it does not reach from the lowest frequency to the highest one, or nothing.
    """

    points: tuple[ResponsePoint, ...]
    reason: str = ""


def curve(
    structure: DrivenStructure,
    series: FourierSeries,
    frequencies: Array,
    *,
    judge: Judge | None = None,
    options: ArcLength | None = None,
    on_progress: Callable[[float], None] = lambda part: None,
) -> Curve:
    """The response through contact.

    Args:
        structure: Driven structure whose contact points have no mass.
        series: Series in time.
        frequencies: Wanted frequencies in Hz, ascending, shape (f,), two or more.
        judge: What judges its motions; by default integration in time, where there is such.
        options: Steps of the continuation.
        on_progress: Called with the part of the range of frequencies that was reached.
    """
    follower = Follower.of(structure, series, frequencies, judge, options)
    rising = follower.followed(falls=False, on_progress=on_progress)
    if not rising.reason and follower.arrives_alone(rising.points[-1]):
        return rising
    falling = follower.followed(falls=True, on_progress=on_progress)
    second = tuple(replace(each, branch=2) for each in falling.points)
    return Curve(rising.points + second, rising.reason)


@dataclass(frozen=True, slots=True)
class ClosesAt:
    """A curve that may come back to where it began, and ends there.

    Attributes:
        start: Where it began.
    """

    start: Solution

    def refusal(self, equations: Equations, before: Solution, after: Solution) -> str:
        """No step is refused."""
        return ""

    def end(self, before: Solution, after: Solution) -> str:
        """Ends where the start lies between two motions."""
        way, left = _between(before, after), _between(before, self.start)
        length, ahead = float(np.linalg.norm(way)), float(way @ left)
        beside = np.linalg.norm(left - ahead / length**2 * way)
        if 0 < ahead <= length**2 and beside < _BESIDE * length:
            return "it is closed"
        return ""


def _between(first: Solution, second: Solution) -> Array:
    """Change of the motion relative to its size, and of its frequency."""
    size, q = float(np.linalg.norm(second.q)), second.q - first.q
    return np.append(q.ravel() / max(size, 1e-300), second.omega / first.omega - 1)


@dataclass(frozen=True, slots=True)
class Follower:
    """What follows the response at one level.

    Attributes:
        structure: Driven structure.
        series: Series in time.
        equations: Its equations.
        omega: Wanted circular frequencies in rad/s, ascending, shape (f,).
        judge: What judges its motions.
        options: Steps of the continuation.
    """

    structure: DrivenStructure
    series: FourierSeries
    equations: TimedEquations
    omega: Array
    judge: Judge
    options: ArcLength

    @classmethod
    def of(
        cls,
        structure: DrivenStructure,
        series: FourierSeries,
        frequencies: Array,
        judge: Judge | None = None,
        options: ArcLength | None = None,
    ) -> Follower:
        """What follows a response over frequencies in Hz, as `curve` does."""
        return cls(
            structure,
            series,
            TimedEquations.of(structure.mechanics, series),
            2 * np.pi * frequencies,
            judge or judge_of(structure.mechanics),
            options or ArcLength(newton=_SHORT_STEPS),
        )

    def piece(self, start: Solution) -> Curve:
        """The piece of the curve through a motion; a closed one ends with its first motion."""
        rising = self._trace(start, falls=False, rules=ClosesAt(start))
        points = [point for point, _ in self._points(rising)]
        if rising.end is End.RULE:
            return Curve((*points[:-1], points[0]))
        falling = self._trace(start, falls=True, rules=ClosesAt(start))
        before = [point for point, _ in self._points(falling)]
        ends = [each.reason for each in (rising, falling) if each.end is not End.LEFT_RANGE]
        return Curve((*before[:0:-1], *points), "; ".join(ends))

    def followed(self, *, falls: bool, on_progress: Callable[[float], None]) -> Curve:
        """The curve from the lowest frequency up, or from the highest one down."""
        first, last = self.omega[[-1, 0]] if falls else self.omega[[0, -1]]
        start = self.first_motion(float(first))
        if start.failure:
            where = f"{first / 2 / np.pi:.6g} Hz"
            return Curve((), f"no motion was found at {where}: {start.failure}")
        steps = self._trace(start, falls=falls)
        points = []
        for point, omega in self._points(steps):
            points.append(point)
            on_progress(min(1.0, abs(omega - first) / abs(last - first)))
        arrived = steps.end is End.LEFT_RANGE and abs(points[-1].omega / last - 1) < 1e-9
        reason = "" if arrived else f"at {points[-1].frequency:.6g} Hz: {steps.reason}"
        return Curve(tuple(points), reason)

    def arrives_alone(self, end: ResponsePoint) -> bool:
        """Whether the motion that is found at the highest frequency is the end of the curve.

        Where several motions coexist there, it may be another one, on a piece of its own.
        """
        other = self.first_motion(float(self.omega[-1]))
        if other.failure:
            return True
        distance = float(np.linalg.norm(other.q - end.q))
        return distance < _SAME * float(np.linalg.norm(end.q))

    def first_motion(self, omega: float) -> Solution:
        """A motion at a frequency."""
        return first_motion(self.structure, self.equations, omega)

    def _trace(self, start: Solution, *, falls: bool, rules: Rules | None = None) -> Trace:
        problem = Problem.of(self.equations, self.options.newton)
        crest = Crest(self.series, self.structure.watched)
        events = (fold(FREQUENCY), BRANCH_POINT, *crests(crest, problem))
        ends = Range(float(self.omega[0]), float(self.omega[-1]))
        return trace(
            problem,
            start,
            Rising(FREQUENCY, falls),
            options=self.options,
            bounds=(Bound(FREQUENCY, ends),),
            events=events,
            rules=rules,
        )

    def _points(self, steps: Trace) -> Iterator[tuple[ResponsePoint, float]]:
        """Points of the curve in order, with the wanted frequencies between those of the trace."""
        first = TracePoint(steps.start, 0.0)
        yield self._point(first.solution), first.solution.omega
        for before, after in itertools.pairwise(itertools.chain((first,), steps)):
            for found in self._between(Segment(steps.problem, before.point, after.point)):
                yield self._point(found), found.omega
            event = after.event.kind if after.event else ""
            yield self._point(after.solution, event), after.solution.omega

    def _between(self, segment: Segment) -> Iterator[Solution]:
        """Motions at the wanted frequencies between two points of the trace."""
        low, high = segment.first.solution.omega, segment.second.solution.omega
        least, most = sorted((low, high))
        inside = self.omega[(self.omega > least * _ABOVE) & (self.omega < most / _ABOVE)]
        for omega in inside if high > low else inside[::-1]:
            found = _at_frequency(segment, float(omega))
            if found is not None:
                yield found

    def _point(self, solution: Solution, event: str = "") -> ResponsePoint:
        if self.structure.forces or solution.forces.force.any():
            known = self.judge.of_contact(self.series, solution.q, solution.omega)
        else:
            known = self.judge.of_linear(solution.omega)
        point = point_of(self.structure, self.series, solution, known)
        return replace(point, event=event)


def _at_frequency(segment: Segment, omega: float) -> Solution | None:
    """The motion at a frequency between two points; None if another one was found."""

    def missing(fraction: float) -> float:
        return segment.guess(fraction).omega / omega - 1

    if missing(0.0) * missing(1.0) >= 0:
        return None
    guess = segment.guess(float(brentq(missing, 0.0, 1.0, xtol=1e-6)))
    found = segment.problem.solve(FixedFrequency(omega), guess)
    distance = np.linalg.norm(segment.metric.between(guess, found.at))
    return found if found.converged and distance < _FARTHEST * segment.length else None
