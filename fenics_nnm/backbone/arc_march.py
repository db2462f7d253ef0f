"""A branch by its length: through folds, and into internal resonances and out again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.cascade import Lift
from fenics_nnm.backbone.coarse import GRAZING_GAMMA
from fenics_nnm.backbone.continuity import Continuity
from fenics_nnm.backbone.harmonic_copy import linear_motion
from fenics_nnm.backbone.levels import Level
from fenics_nnm.backbone.mode_trace import GAMMA_DOWN, GAMMA_UP, mode_trace
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.targets import ArcContinuation, Begin
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.continuation.branch_switching import switched
from fenics_nnm.continuation.events import branch_point_at
from fenics_nnm.continuation.heading import Along, Heading
from fenics_nnm.continuation.trace import End, Trace
from fenics_nnm.continuation.trace_options import Range
from fenics_nnm.nonlinear.conditions import FixedEnergy
from fenics_nnm.nonlinear.equations import Equations
from fenics_nnm.nonlinear.full_order import FullOrderEquations
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.reduction.flexibility import ACCURACY

#: A gamma ratio this near to a wanted one, relative, was aimed at it.
_SAME = 1e-9


@dataclass(slots=True)
class ArcMarch:
    """Run state of a branch that is followed by its length.

    Attributes:
        lift: Levels; the branch is one of the finest.
        maker: Makes points of solutions.
        wanted: What is wanted.
        on_point: Called with each point before the next one is begun.
        points: Points in the order of the branch.
        failure: Why the branch ended before it left the range of energies, or nothing.
        reason: Why it ended.

    Raises:
        ModelError: if contact points carry mass: multipliers are found at fixed energy.
    """

    lift: Lift
    maker: PointMaker
    wanted: ArcContinuation
    on_point: Callable[[BranchPoint], None]
    points: list[BranchPoint] = field(default_factory=list)
    failure: str = ""
    reason: str = ""

    def __post_init__(self) -> None:
        self.lift.assert_without_multipliers("continuation by arc-length")

    def run(self, known: Sequence[BranchPoint], on_progress: Callable[[float], None]) -> None:
        """Follow the branch, on from known points or from its beginning.

        Args:
            known: Points found before.
            on_progress: Called with the gamma ratio of each point.
        """
        self.points = sorted(known, key=lambda point: point.position)
        if len(self.points) > 1 and self._at_end(self.points[-1].gamma_ratio):
            self._end_of_range()
            return
        problem = arc_problem(self.lift.levels[-1], self.wanted.arc.newton)
        start = self._goes_on(problem) if len(self.points) > 1 else self._beginning(problem)
        if start is None:
            return
        solution, heading = start
        if not self.points:
            self._keep(solution, 0.0)
        begun = self.points[-1].position
        path = self._trace(problem, solution, heading)
        for point in path:
            if point.length <= _SAME and not point.event:
                continue  # the beginning is there already
            kind = point.event.kind if point.event else ""
            self._keep(point.solution, begun + point.length, kind)
            on_progress(self.points[-1].gamma_ratio)
        if path.end is End.LEFT_RANGE:
            self._end_of_range()
        else:
            self._fail(path.reason)

    def _at_end(self, ratio: float) -> bool:
        return any(abs(ratio - end) <= _SAME * end for end in (self.wanted.start, self.wanted.stop))

    def _trace(self, problem: Problem, start: Solution, heading: Heading) -> Trace:
        low, high = (
            self.wanted.start * (1 - _SAME) * self._grazing,
            self.wanted.stop * self._grazing,
        )
        inside = tuple(ratio * self._grazing for ratio in self.wanted.targets())
        return mode_trace(
            problem,
            start,
            heading,
            options=self.wanted.arc,
            gamma=Range(low, high, inside),
            rules=Continuity(grazing_gamma=self._grazing, to_rest=True),
        )

    @property
    def _grazing(self) -> float:
        """Gamma of the linear mode that touches, in the harmonic that it is written in."""
        return GRAZING_GAMMA * self.wanted.harmonic**2

    def _goes_on(self, problem: Problem) -> tuple[Solution, Heading]:
        """The last point, and the way that led there."""
        before, last = (self.maker.solution(point) for point in self.points[-2:])
        return self._at_energy_of(problem, last), Along(_way(problem, before, last))

    def _beginning(self, problem: Problem) -> tuple[Solution, Heading] | None:
        """Where the branch begins, and which way it goes; None if there is no motion."""
        if self.wanted.begin is not None:
            return self._from_known(problem, self.wanted.begin)
        equations = self.lift.levels[-1].equations
        if self.wanted.harmonic > 1 or (
            self.wanted.start < 1 and equations.rest.is_linear(self.lift.mode)
        ):
            amplitude = self.wanted.start**0.5
            linear = linear_motion(
                equations, self.lift.mode, harmonic=self.wanted.harmonic, amplitude=amplitude
            )
            growth = linear.with_q(equations.motion(linear.q))
            way = Along(Unknowns.of(_stacked(problem, growth), 0.0))
            return self._at_energy_of(problem, linear), way
        stack = self.lift.at(self.wanted.start, None)
        if stack.finest is None:
            self._fail(stack.failure)
            return None
        found = self._at_energy_of(problem, stack.finest)
        return (found, GAMMA_UP) if self._held(found) else None

    def _from_known(self, problem: Problem, begin: Begin) -> tuple[Solution, Heading] | None:
        """A known motion, or the one beside it on the branch that crosses there."""
        found = self._at_energy_of(problem, self.maker.solution(begin.point))
        if not self._held(found):
            return None
        if begin.along is None:
            return found, GAMMA_DOWN if begin.downwards else GAMMA_UP
        before, after = (self.maker.solution(point) for point in begin.along)
        event = branch_point_at(problem, found, _way(problem, before, after))
        first, second = switched(problem, event)
        side = second if begin.downwards else first
        if side is None:
            self._fail("no motion was found on this side of the branch point")
            return None
        return side.solution, Along(side.metric.unscaled(side.tangent))

    def _held(self, found: Solution) -> bool:
        if not found.converged:
            self._fail(f"no motion to begin at: {found.failure}")
        return found.converged

    def _at_energy_of(self, problem: Problem, near: Solution) -> Solution:
        """The motion of the same gamma next to one that may be stored or of another series."""
        guess = Unknowns.of(_stacked(problem, near), near.omega)
        return problem.solve(FixedEnergy(near.energies.gamma), guess)

    def _keep(self, solution: Solution, position: float, event: str = "") -> None:
        ratio = solution.energies.gamma / self._grazing
        aimed = [to for to in self.wanted.targets() if abs(ratio - to) <= _SAME * to]
        modes = self.maker.equations.model.modes
        whole = solution.with_q(solution.q[:, :modes])
        if self.points and self.points[-1].position == position:  # an event at the end of a step
            event = self.points.pop().notes.event or event
        slope = self.lift.slope_ratio(whole) if self.wanted.harmonic == 1 else float("nan")
        point = self.maker.point(
            position, aimed[0] if aimed else ratio, whole, event=event, slope_ratio=slope
        )
        self.on_point(point)
        self.points.append(point)

    def _fail(self, reason: str) -> None:
        """Say why the branch ended before it left the range of energies."""
        self.failure = self.reason = f"arc_length: {reason}"

    def _end_of_range(self) -> None:
        """Say where the branch left the range of energies."""
        ratio = self.points[-1].gamma_ratio
        if len(self.points) == 1:
            self.failure = self.reason = (
                f"the branch turns back where it begins, at gamma ratio {ratio:g}: "
                "lower continuation.energies.from"
            )
            return
        reached = "reached" if ratio > self.points[-2].gamma_ratio else "came back to"
        self.reason = f"{reached} gamma ratio {ratio:g}"


def arc_problem(level: Level, newton: Newton) -> Problem:
    """Equations of a level about any frequency."""
    source = level.flexibility
    if source is None:
        return Problem.of(level.equations, newton)
    last: list[FullOrderEquations] = []

    def about(omega: float) -> Equations:
        if last:
            allowed = ACCURACY * last[0].static_flexibility.max()
            if last[0].flexibility.error(omega).max() <= allowed:
                return last[0]
        last[:] = [FullOrderEquations(level.equations, source(omega))]
        return last[0]

    return Problem(about, newton)


def _way(problem: Problem, first: Solution, second: Solution) -> Unknowns:
    """The way from a motion to another one."""
    change = _stacked(problem, second) - _stacked(problem, first)
    return Unknowns.of(change, second.omega - first.omega)


def _stacked(problem: Problem, solution: Solution) -> Array:
    """Unknowns of a solution that has modal coordinates alone."""
    return problem.about(solution.omega).stacked(solution.q, solution.forces.force)
