"""A branch by its length: through folds, and into internal resonances and out again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from fenics_nnm.backbone.arc_start import ArcStart, ArcStarts, NoStartError
from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.coarse import GRAZING_GAMMA
from fenics_nnm.backbone.continuity import Continuity
from fenics_nnm.backbone.mode_trace import mode_trace
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.wanted import Followed
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.continuation.trace import End, Trace
from fenics_nnm.continuation.trace_options import ArcLength, Range
from fenics_nnm.nonlinear.solution import Solution

#: A gamma ratio this near to a wanted one, relative, was aimed at it.
_SAME = 1e-9


@dataclass(frozen=True, slots=True)
class EnergyRange:
    """Energies that bound a branch.

    Attributes:
        start: Lowest gamma ratio.
        stop: Highest gamma ratio.
        targets: Gamma ratios to hit at each passing.
        harmonic: Harmonic that the linear mode is written in.
    """

    start: float
    stop: float
    targets: tuple[float, ...]
    harmonic: int

    @property
    def grazing(self) -> float:
        """Gamma of the linear mode that touches, in the harmonic that it is written in."""
        return GRAZING_GAMMA * self.harmonic**2

    @property
    def gamma(self) -> Range:
        """Range of gamma, with targets."""
        low, high = self.start * (1 - _SAME) * self.grazing, self.stop * self.grazing
        return Range(low, high, tuple(ratio * self.grazing for ratio in self.targets))

    def ends_at(self, ratio: float) -> bool:
        """Whether a gamma ratio is one of the ends."""
        return any(abs(ratio - end) <= _SAME * end for end in (self.start, self.stop))

    def ratio(self, gamma: float) -> float:
        """Gamma ratio, the one that was aimed at where there is one."""
        ratio = gamma / self.grazing
        return next((to for to in self.targets if abs(ratio - to) <= _SAME * to), ratio)


@dataclass(slots=True)
class ArcFollowing:
    """Run state of a branch that is followed by its length.

    Attributes:
        cascade: Levels; the branch is one of the finest.
        maker: Makes points of solutions.
        energies: Energies that bound the branch.
        arc: Steps along the branch.
        on_point: Called with each point before the next one is begun.
        points: Points in the order of the branch; those found before, at first.
        failure: Why the branch ended before it left the range of energies, or nothing.
        reason: Why it ended.
    """

    cascade: Cascade
    maker: PointMaker
    energies: EnergyRange
    arc: ArcLength
    on_point: Callable[[BranchPoint], None]
    points: list[BranchPoint] = field(default_factory=list)
    failure: str = ""
    reason: str = ""

    def run(
        self, begin: Callable[[ArcStarts], ArcStart], on_position: Callable[[float], None]
    ) -> None:
        """Follow the branch, on from known points or from its beginning.

        Args:
            begin: Finds where it begins.
            on_position: Called with the gamma ratio of each point.
        """
        if len(self.points) > 1 and self.energies.ends_at(self.points[-1].gamma_ratio):
            self._end_of_range()
            return
        problem = self.cascade.levels[-1].problem(self.arc.newton)
        starts = ArcStarts(problem, self.cascade, self.maker)
        try:
            start = starts.onward(*self.points[-2:]) if len(self.points) > 1 else begin(starts)
        except NoStartError as error:
            self._fail(str(error))
            return
        if not self.points:
            self._keep(start.solution, 0.0)
        self._trace(problem, start, on_position)

    def ended(self) -> Followed:
        """The branch, once it has ended."""
        last = self.points[-1].gamma_ratio if self.points else self.energies.start
        failures = ((last, self.failure),) if self.failure else ()
        return Followed(tuple(self.points), failures, self.reason, connected=True)

    def _trace(
        self, problem: Problem, start: ArcStart, on_position: Callable[[float], None]
    ) -> None:
        """Keep the points of the trace that leads on from a start."""
        begun, path = self.points[-1].position, self._path(problem, start)
        for point in path:
            if point.length <= _SAME and not point.event:
                continue  # the beginning is there already
            kind = point.event.kind if point.event else ""
            self._keep(point.solution, begun + point.length, kind)
            on_position(self.points[-1].gamma_ratio)
        if path.end is End.LEFT_RANGE:
            self._end_of_range()
        else:
            self._fail(path.reason)

    def _path(self, problem: Problem, start: ArcStart) -> Trace:
        return mode_trace(
            problem,
            start.solution,
            start.heading,
            options=self.arc,
            gamma=self.energies.gamma,
            rules=Continuity(grazing_gamma=self.energies.grazing, to_rest=True),
        )

    def _keep(self, solution: Solution, position: float, event: str = "") -> None:
        modes = self.maker.equations.model.modes
        whole = solution.with_q(solution.q[:, :modes])  # without forces, at full order
        if self.points and self.points[-1].position == position:  # an event at the end of a step
            event = self.points.pop().notes.event or event
        first = self.energies.harmonic == 1
        point = self.maker.point(
            position,
            self.energies.ratio(solution.energies.gamma),
            whole,
            event=event,
            slope_ratio=self.cascade.slope_ratio(whole) if first else float("nan"),
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
                "it must begin lower"
            )
            return
        reached = "reached" if ratio > self.points[-2].gamma_ratio else "came back to"
        self.reason = f"{reached} gamma ratio {ratio:g}"
