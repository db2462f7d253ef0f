"""The damped backbone: motions in phase resonance, followed from level to level by arc-length.

All modes are damped as they are, and the force is in phase with the velocity, see
`nonlinear.resonant`. Every point is a driven motion at its own level of the forces, and judged like
those of a response; the peaks of the responses lie on the curve. It begins without contact, where
it is a closed form, and is followed from a little beyond the level at which the first gap is closed
to a little beyond the highest level, or until a frequency leaves its range.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import CurvePoint, Problem
from fenics_nnm.continuation.events import BRANCH_POINT, EventTest
from fenics_nnm.continuation.heading import Away, Heading, Rising
from fenics_nnm.continuation.trace import End, Trace, TracePoint, trace
from fenics_nnm.continuation.trace_options import ArcLength, Bound, Range
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.conditions import FREQUENCY, GAMMA, Condition, FixedEnergy
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.resonant import LEVEL, FixedLevel, ResonantEquations
from fenics_nnm.nonlinear.solution import Solution, evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.response.driven import NothingTouches, point_of
from fenics_nnm.response.judge import Judge, judge_of
from fenics_nnm.response.linear_resonances import LinearResonance, linear_resonances
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.structure import DrivenStructure

#: Through contact the curve is followed from one of these parts beyond first contact.
_BEYOND = (0.01, 0.003, 0.03, 0.1, 0.001)

#: With springs that are not linear it begins at this part of the lowest level.
_LOWEST = 0.01

#: The level may fall to this part of that where the curve begins.
_FALLS_TO = 0.5

#: The curve is followed to this multiple of the highest level: it may come back from a fold there.
_RISES_TO = 1.25

#: Newton's iteration to the first motion.
_FIRST = Newton(tolerance=1e-12, round_off=1e-10, iterations=40)

#: Levels that differ by less than this part are the same.
_SAME = 1e-9

#: Part of the unit step along the curve over which the slope of the level is taken.
_STEP = 1e-6


@dataclass(frozen=True, slots=True)
class Resonance:
    """A motion in phase resonance.

    Attributes:
        point: The driven motion at its level.
        force: Size of the first force in N, 0-peak.
        damping_ratio: Dissipated power over 4 omega times the mean kinetic energy.
    """

    point: ResponsePoint
    force: float
    damping_ratio: float


@dataclass(frozen=True, slots=True)
class DampedBackbone:
    """Motions in phase resonance, branch by branch.

    Attributes:
        points: Its points in the order of the curve; each linear resonance has its own branch.
        reasons: Why branches do not reach the highest level or an end of the frequencies.
    """

    points: tuple[Resonance, ...] = ()
    reasons: tuple[str, ...] = ()

    def doubted(self, doubt: str) -> DampedBackbone:
        """The same, where a doubt stands against all motions in contact."""
        return replace(
            self,
            points=tuple(replace(each, point=each.point.doubted(doubt)) for each in self.points),
        )

    @property
    def refuted(self) -> tuple[Resonance, ...]:
        """Points that are no motions of the structure."""
        return tuple(each for each in self.points if each.point.refuted)

    def followed_by(self, other: DampedBackbone) -> DampedBackbone:
        """The points and reasons of both."""
        return DampedBackbone(self.points + other.points, self.reasons + other.reasons)

    def numbered(self, branch: int) -> DampedBackbone:
        """The same as a branch of a number."""
        points = (replace(each, point=replace(each.point, branch=branch)) for each in self.points)
        return DampedBackbone(
            tuple(points), tuple(f"branch {branch}: {reason}" for reason in self.reasons)
        )

    def at_speeds(self, per_hertz: float) -> DampedBackbone:
        """The same with the speeds of rotation, in rad/s per Hz, that go with the frequencies."""
        points = (
            replace(each, point=replace(each.point, speed=per_hertz * each.point.frequency))
            for each in self.points
        )
        return replace(self, points=tuple(points))


def damped_backbone(
    structure: DrivenStructure,
    series: FourierSeries,
    frequencies: Array,
    levels: Sequence[float],
    *,
    judge: Judge | None = None,
    options: ArcLength | None = None,
    on_progress: Callable[[float], None] = lambda part: None,
) -> DampedBackbone:
    """Motions in phase resonance within a range of frequencies, up to the highest level.

    Args:
        structure: Driven structure at level 1.
        series: Series in time.
        frequencies: Wanted frequencies in Hz, ascending, shape (f,).
        levels: Factors of the forces, each of which has a point where the curve passes it.
        judge: What judges its motions; by default integration in time, where there is such.
        options: Steps of the continuation.
        on_progress: Called with the part that is done.
    """
    if objection := _objection(structure):
        return DampedBackbone((), (objection,))
    follower = ResonanceFollower(
        structure,
        ResonantEquations.of(structure.mechanics, series),
        judge or judge_of(structure.mechanics),
        2 * np.pi * frequencies[[0, -1]],
        tuple(sorted(levels)),
        options or ArcLength(),
    )
    starts = list(linear_resonances(structure, follower.equations, frequencies))
    if not starts:
        return DampedBackbone((), ("there is no phase resonance within the frequencies",))
    found = DampedBackbone()
    for number, start in enumerate(starts, start=1):
        found = found.followed_by(follower.branch(start).numbered(number))
        on_progress(number / len(starts))
    return found


def _objection(structure: DrivenStructure) -> str:
    """Why phase resonance is not defined, or not found, or nothing."""
    if structure.gap_motion.moves:
        return "phase resonance needs forces alone: a casing that moves past drives the structure"
    harmonics = set(structure.drive.harmonics)
    if len(harmonics) > 1 or 0 in harmonics:
        listed = ", ".join(map(str, sorted(harmonics)))
        return f"phase resonance needs forces of one harmonic alone, from 1: there are {listed}"
    if structure.model.gap.min(initial=np.inf) <= 0:
        return "contact points touch at rest: there is no phase resonance without contact"
    return ""


@dataclass(frozen=True, slots=True)
class ResonanceFollower:
    """What follows motions in phase resonance.

    Attributes:
        structure: Driven structure at level 1.
        equations: Its equations.
        judge: What judges its motions.
        range: Lowest and highest circular frequency in rad/s, shape (2,).
        levels: Wanted levels, ascending.
        options: Steps of the continuation.
    """

    structure: DrivenStructure
    equations: ResonantEquations
    judge: Judge
    range: Array
    levels: tuple[float, ...]
    options: ArcLength

    def branch(self, linear: LinearResonance) -> DampedBackbone:
        """The motions that begin with a linear one."""
        opened = DampedBackbone(tuple(self._opened(linear)))
        if linear.grazing >= self.highest and not self.structure.forces:
            return opened
        if objection := self.structure.objection:
            return opened.followed_by(DampedBackbone((), (f"at first contact: {objection}",)))
        return opened.followed_by(self._beyond(linear))

    def _beyond(self, linear: LinearResonance) -> DampedBackbone:
        """Those beyond first contact."""
        start = self._start(linear)
        if start.failure or not 0 < LEVEL.value(start) < self.highest:
            why = start.failure or f"only one at level {LEVEL.value(start):.6g}"
            where = f"beyond level {linear.grazing:.6g} no motion was found: {why}"
            return DampedBackbone((), (where,))
        near, steps = self._near(linear, start), self._trace(start, self._heading(linear))
        found = tuple(self._point(each) for each in near.values() if each.converged)
        lost = [f"level {level:g}: {each.failure}" for level, each in near.items() if each.failure]
        points = (*found, *self._followed(steps))
        end, top = points[-1].point, max(each.point.level for each in points)
        if top < self.highest or steps.end is not End.LEFT_RANGE:
            lost += [f"ends at level {end.level:.6g}, {end.frequency:.6g} Hz: {steps.reason}"]
        return DampedBackbone(points, tuple(lost))

    @property
    def highest(self) -> float:
        """The highest level."""
        return self.levels[-1]

    def _start(self, linear: LinearResonance) -> Solution:
        """The motion from which the curve is followed: of the energy of a linear one, or its level.

        At first contact either may hardly change along the curve, or turn back.
        """
        guesses = [linear.at_level(level) for level in self._first_levels(linear)]
        energy = self.equations.energy.gamma
        conditions: list[tuple[Condition, Unknowns]] = [
            *((FixedEnergy(energy(guess)), guess) for guess in guesses),
            *((FixedLevel(float(guess.parameters[1])), guess) for guess in guesses),
        ]
        for condition, guess in conditions:
            found = solve(self.equations, condition, guess, options=_FIRST)
            if found.converged and 0 < LEVEL.value(found) < self.highest:
                break
        return found

    def _first_levels(self, linear: LinearResonance) -> Iterator[float]:
        """Levels of the linear motions whose energies are tried."""
        if self.structure.forces:
            yield _LOWEST * min(self.levels[0], linear.grazing)
            return
        spare = (self.highest / linear.grazing - 1) / 2
        for beyond in _BEYOND:
            yield linear.grazing * (1 + min(beyond, spare))

    def _opened(self, linear: LinearResonance) -> Iterator[Resonance]:
        """Motions at the wanted levels that touch nothing, and the one at first contact."""
        if self.structure.forces:
            return
        for level in self.levels:
            if level < linear.grazing:
                yield self._open_point(linear, level)
        if linear.grazing <= self.highest:
            yield self._open_point(linear, linear.grazing, "first contact")

    def _open_point(self, linear: LinearResonance, level: float, event: str = "") -> Resonance:
        opened = HarmonicEquations(
            self.structure.mechanics, self.equations.series, NothingTouches()
        )
        return self._point(evaluated(opened, linear.at_level(level)), event)

    def _near(self, linear: LinearResonance, start: Solution) -> dict[float, Solution]:
        """Motions at wanted levels between first contact and where the curve is followed from."""
        low, high = linear.grazing, LEVEL.value(start)
        return {
            level: solve(self.equations, FixedLevel(level), start.at, options=_FIRST)
            for level in self.levels
            if low < level < high and not self.structure.forces
        }

    def _heading(self, linear: LinearResonance) -> Heading:
        """Away from first contact, where the energy may rise to either side; else up in energy."""
        if self.structure.forces:
            return Rising(GAMMA)
        return Away(linear.at_level(linear.grazing))

    def _trace(self, start: Solution, heading: Heading) -> Trace:
        lowest, top = _FALLS_TO * LEVEL.value(start), _RISES_TO * self.highest
        return trace(
            Problem.of(self.equations, self.options.newton),
            start,
            heading,
            options=self.options,
            bounds=(
                Bound(LEVEL, Range(lowest, top, self.levels)),
                Bound(FREQUENCY, Range(float(self.range[0]), float(self.range[1]))),
            ),
            events=(EventTest("fold in level", self._level_slope), BRANCH_POINT),
        )

    def _level_slope(self, problem: Problem, point: CurvePoint) -> float:
        """Relative slope of the level along the curve, from the balance of work."""
        step, level = point.metric.unscaled(point.tangent), self.equations.balanced_level
        ahead, behind = (level(point.at.moved(step, part)) for part in (_STEP, -_STEP))
        return (ahead - behind) / (2 * _STEP) / level(point.at)

    def _followed(self, steps: Trace) -> Iterator[Resonance]:
        for each in itertools.chain((TracePoint(steps.start, 0.0),), steps):
            yield self._point(each.solution, each.event.kind if each.event else "")

    def _point(self, solution: Solution, event: str = "") -> Resonance:
        """A motion, and what is known of it."""
        level, series = self._snapped(LEVEL.value(solution)), self.equations.series
        driven = self.structure.at_level(level)
        judge = self.judge.under(driven.mechanics)
        if self.structure.forces or solution.forces.force.any():
            known = judge.of_contact(series, solution.q, solution.omega)
        else:
            known = judge.of_linear(solution.omega)
        return Resonance(
            point=replace(point_of(driven, series, solution, known), level=level, event=event),
            force=float(abs(driven.drive.amplitudes[0])),
            damping_ratio=self.equations.damping_ratio(solution.at),
        )

    def _snapped(self, level: float) -> float:
        """A level without the round-off by which it differs from a wanted one."""
        nearest = min(self.levels, key=lambda wanted: abs(level - wanted))
        return nearest if abs(level / nearest - 1) < _SAME else level
