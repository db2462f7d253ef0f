"""Step by step along a branch, in energy or in frequency, with a second look back."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from fenics_nnm.backbone.cascade import SHARE_DROP, Stack
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.nonlinear.solution import Solution

#: Places that differ by less than this part are the same.
_SAME = 1e-9

#: The latest motions of a branch are kept with their levels, for the second look.
_WITH_LEVELS = 60

logger = logging.getLogger(__name__)


class Course(Protocol):
    """Solves for motions at given places: gamma ratios, or frequency ratios."""

    def at(self, place: float, neighbour: Stack | None) -> Stack:
        """Solve at a place, with the help of a neighbouring point where that is better."""

    def restored(self, place: float, finest: Solution) -> Stack:
        """A stack of which the finest motion alone is known."""


@dataclass(slots=True)
class March:
    """Run state of a branch that is followed in steps.

    Each place is approached from coarse to fine levels, so a point inside an internal resonance
    does not spoil those after it. A second look, down the branch, tries the places that could not
    be reached from below, and those whose motion has lost energy to other modes.

    Attributes:
        course: Solves at a place.
        maker: Makes points of solutions.
        name: Name of what is stepped.
        smallest_step: A step that fails is halved down to this.
        on_point: Called with each converged point before the next one is begun.
        points: Points by their place.
        stacks: Their solutions, in the order that they were found.
        failures: Wanted places without a point, with the reason.
    """

    course: Course
    maker: PointMaker
    name: str
    smallest_step: float
    on_point: Callable[[BranchPoint], None]
    points: dict[float, BranchPoint] = field(default_factory=dict)
    stacks: dict[float, Stack] = field(default_factory=dict)
    failures: dict[float, str] = field(default_factory=dict)

    def take_over(self, known: Sequence[BranchPoint]) -> None:
        """Begin with points that were found before."""
        for point in known:
            self.points[point.position] = point
            solution = self.maker.solution(point)
            self.stacks[point.position] = self.course.restored(point.position, solution)

    def run(
        self,
        targets: Sequence[float],
        on_progress: Callable[[float], None],
        *,
        downwards: bool = False,
    ) -> None:
        """Visit all targets, and look back.

        Args:
            targets: Places, ascending.
            on_progress: Called with the place as far along as what has been dealt with.
            downwards: Begin with the last one.
        """
        for place, target in zip(targets, targets[::-1] if downwards else targets, strict=True):
            if not self.has(target):
                self.reach(target)
            on_progress(place)
        self._second_look()

    def has(self, target: float) -> bool:
        """Whether there is a point at a place."""
        return any(abs(place - target) <= _SAME * target for place in self.points)

    def reach(self, target: float, first: Stack | None = None) -> None:
        """Get to `target` in halved steps where one step fails.

        Steps over a place that was missed are not halved: they were, on the way to that place.

        Args:
            target: Wanted place.
            first: Point to begin at; the nearest one if None.
        """
        at = target
        neighbour = first or self._nearest(target)
        while True:
            stack = self.course.at(at, neighbour)
            if stack.finest is not None:
                self.accept(stack)
                if at == target:
                    return
                at, neighbour = target, stack
                continue
            logger.info("%s %.4f: %s", self.name.replace("_", " "), at, stack.failure)
            self.failures.setdefault(target, stack.failure)
            start = neighbour.place if neighbour else at
            at = (start + at) / 2
            if abs(at - start) < self.smallest_step or self._misses_between(start, target):
                return

    def pass_energies(
        self, ratios: Sequence[float], solve: Callable[[float, Stack], Stack]
    ) -> None:
        """Add a point wherever the branch passes an energy.

        Args:
            ratios: Gamma ratios.
            solve: From a gamma ratio and a neighbour to a stack at its place.
        """
        for ratio in ratios:
            places = sorted(self.stacks)
            sides = [self.stacks[place].gamma_ratio - ratio for place in places]
            passed = [i for i in range(len(sides) - 1) if sides[i] * sides[i + 1] <= 0]
            if not passed:
                logger.warning(
                    "report_at = %g: has no point: the branch does not pass this energy", ratio
                )
            for i in passed:
                nearer = i if abs(sides[i]) < abs(sides[i + 1]) else i + 1
                stack = solve(ratio, self.stacks[places[nearer]])
                if stack.finest is None:
                    self.failures[places[nearer]] = f"report_at = {ratio:g}: {stack.failure}"
                else:
                    self.accept(stack)

    def accept(self, stack: Stack) -> None:
        """Make a point of a stack, and keep both."""
        assert stack.finest is not None
        point = self.maker.point(
            stack.place,
            stack.gamma_ratio,
            stack.finest,
            skipped=stack.skipped,
            slope_ratio=stack.slope_ratio,
        )
        self.on_point(point)
        self._remember(stack)
        self.points[stack.place] = point
        self.failures.pop(stack.place, None)

    def _remember(self, stack: Stack) -> None:
        """Keep all levels of the latest motions, and the finest of the others."""
        self.stacks.pop(stack.place, None)
        self.stacks[stack.place] = stack.thinned(levels=True)
        if len(self.stacks) > _WITH_LEVELS:
            place = list(self.stacks)[-_WITH_LEVELS - 1]
            self.stacks[place] = self.stacks[place].thinned(levels=False)

    def _second_look(self) -> None:
        """Go down the branch: try again what is missing, or has lost energy to other modes."""
        for place in sorted({*self.stacks, *self.failures}, reverse=True):
            above = min((other for other in self.stacks if other > place), default=None)
            if above is None:
                continue
            if place in self.failures:
                self.reach(place, self.stacks[above])
            elif self.stacks[place].share < self.stacks[above].share - SHARE_DROP:
                stack = self.course.at(place, self.stacks[above])
                if stack.share > self.stacks[place].share:
                    self.accept(stack)

    def _misses_between(self, one: float, other: float) -> bool:
        low, high = sorted((one, other))
        return any(low < place < high for place in self.failures)

    def _nearest(self, target: float) -> Stack | None:
        nearest = min(self.stacks, key=lambda place: abs(place - target), default=None)
        return None if nearest is None else self.stacks[nearest]
