"""Step by step along a branch, in energy or in frequency, with a second look back."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.wanted import Failures, Followed
from fenics_nnm.nonlinear.solution import Solution

#: Positions that differ by less than this part are the same.
_SAME = 1e-9

#: A position is given up after so many attempts on the way to it that failed.
_ATTEMPTS = 16

#: The latest motions of a branch are kept with their levels, for the second look.
_WITH_LEVELS = 60

logger = logging.getLogger(__name__)


class PointSolver(Protocol):
    """Solves for motions at given positions: gamma ratios, or frequency ratios."""

    def at(self, position: float, neighbour: CascadeSolution | None) -> CascadeSolution:
        """Solve at a position, with the help of a neighbouring point where that is better."""

    def restored(self, position: float, finest: Solution) -> CascadeSolution:
        """Solutions of which the finest alone is known."""


@dataclass(slots=True)
class Stepping:
    """Run state of a branch that is followed in steps.

    Each position is approached from coarse to fine levels, so a point inside an internal resonance
    does not spoil those after it. A second look, down the branch, tries the positions that could
    not be reached from below, and those whose motion has lost energy to other modes.

    Attributes:
        solver: Solves at a position.
        maker: Makes points of solutions.
        name: Name of what is stepped.
        smallest_step: A step that fails is halved down to this.
        on_point: Called with each converged point before the next one is begun.
        points: Points by their position.
        solutions: What they were made of, in the order that they were found.
        failures: Wanted positions without a point, with the reason.
    """

    solver: PointSolver
    maker: PointMaker
    name: str
    smallest_step: float
    on_point: Callable[[BranchPoint], None]
    points: dict[float, BranchPoint] = field(default_factory=dict)
    solutions: dict[float, CascadeSolution] = field(default_factory=dict)
    failures: dict[float, str] = field(default_factory=dict)

    def take_over(self, known: Sequence[BranchPoint]) -> None:
        """Begin with points that were found before."""
        for point in known:
            self.points[point.position] = point
            solution = self.maker.solution(point)
            self.solutions[point.position] = self.solver.restored(point.position, solution)

    def run(
        self,
        targets: Sequence[float],
        on_position: Callable[[float], None],
        *,
        downwards: bool = False,
    ) -> None:
        """Visit all targets, and look back.

        Args:
            targets: Positions, ascending.
            on_position: Called with the position as far along as what has been dealt with.
            downwards: Begin with the last one.
        """
        for position, target in zip(targets, targets[::-1] if downwards else targets, strict=True):
            if not self.has(target):
                self.reach(target)
            on_position(position)
        self._second_look()

    def has(self, target: float) -> bool:
        """Whether there is a point at a position."""
        return any(abs(position - target) <= _SAME * target for position in self.points)

    def reach(self, target: float, first: CascadeSolution | None = None) -> None:
        """Get to `target` in halved steps where one step fails.

        After a step that had to be halved the next one is as long, and then they grow again. Steps
        over a position that was missed are not halved: they were, on the way to it.

        Args:
            target: Wanted position.
            first: Point to begin at; the nearest one if None.
        """
        at, failed, growth = target, 0, 2.0
        neighbour = first or self._nearest(target)
        while failed < _ATTEMPTS:
            found = self.solver.at(at, neighbour)
            start = neighbour.position if neighbour else at
            if found.finest is not None:
                self.accept(found)
                if at == target:
                    return
                at, neighbour = _onwards(at, growth * (at - start), target), found
                growth = 2.0
                continue
            logger.info("%s %.4f: %s", self.name.replace("_", " "), at, found.failure)
            self.failures.setdefault(target, found.failure)
            at, failed, growth = (start + at) / 2, failed + 1, 1.0
            if abs(at - start) < self.smallest_step or self._misses_between(start, target):
                return
        self.failures[target] = f"given up after {failed} attempts: {self.failures[target]}"

    def pass_energies(
        self, ratios: Sequence[float], solve: Callable[[float, CascadeSolution], CascadeSolution]
    ) -> None:
        """Add a point wherever the branch passes an energy.

        Args:
            ratios: Gamma ratios.
            solve: From a gamma ratio and a neighbour to a motion at its position.
        """
        for ratio in ratios:
            positions = sorted(self.solutions)
            sides = [self.solutions[position].gamma_ratio - ratio for position in positions]
            passed = [i for i in range(len(sides) - 1) if sides[i] * sides[i + 1] <= 0]
            if not passed:
                logger.warning(
                    "report_at = %g: has no point: the branch does not pass this energy", ratio
                )
            for i in passed:
                nearer = i if abs(sides[i]) < abs(sides[i + 1]) else i + 1
                found = solve(ratio, self.solutions[positions[nearer]])
                if found.finest is None:
                    self.failures[positions[nearer]] = f"report_at = {ratio:g}: {found.failure}"
                else:
                    self.accept(found)

    def accept(self, found: CascadeSolution) -> None:
        """Make a point of a motion, and keep both."""
        assert found.finest is not None
        point = self.maker.point(
            found.position,
            found.gamma_ratio,
            found.finest,
            skipped=found.skipped,
            slope_ratio=found.slope_ratio,
        )
        self.on_point(point)
        self._remember(found)
        self.points[found.position] = point
        self.failures.pop(found.position, None)

    def _remember(self, found: CascadeSolution) -> None:
        """Keep all levels of the latest motions, and the finest of the others."""
        self.solutions.pop(found.position, None)
        self.solutions[found.position] = found.thinned(levels=True)
        if len(self.solutions) > _WITH_LEVELS:
            position = list(self.solutions)[-_WITH_LEVELS - 1]
            self.solutions[position] = self.solutions[position].thinned(levels=False)

    def _second_look(self) -> None:
        """Go down the branch: try again what is missing, or has lost energy to other modes."""
        for position in sorted({*self.solutions, *self.failures}, reverse=True):
            above = min((other for other in self.solutions if other > position), default=None)
            if above is None:
                continue
            if position in self.failures:
                self.reach(position, self.solutions[above])
            elif self.solutions[position].has_lost_share(self.solutions[above]):
                found = self.solver.at(position, self.solutions[above])
                if found.share > self.solutions[position].share:
                    self.accept(found)

    def ended(self, stop: float) -> Followed:
        """The branch, once all is done.

        Args:
            stop: Last position that was wanted.
        """
        points = tuple(self.points[position] for position in sorted(self.points))
        failures = tuple(sorted(self.failures.items()))
        return Followed(points, failures, self._reason(stop, failures))

    def _reason(self, stop: float, failures: Failures) -> str:
        name = self.name.replace("_", " ")
        if not failures:
            return f"reached {name} {stop:g}"
        if not self.points:
            return f"no point converged; at {name} {failures[0][0]:g}: {failures[0][1]}"
        missing = ", ".join(f"{position:g}" for position, _ in failures)
        return f"no point at {name} {missing}: {failures[0][1]}"

    def _misses_between(self, one: float, other: float) -> bool:
        low, high = sorted((one, other))
        return any(low < position < high for position in self.failures)

    def _nearest(self, target: float) -> CascadeSolution | None:
        nearest = min(self.solutions, key=lambda position: abs(position - target), default=None)
        return None if nearest is None else self.solutions[nearest]


def _onwards(at: float, step: float, target: float) -> float:
    """The next position: a step further, or the target where that is not farther."""
    return target if abs(target - at) <= abs(step) * (1 + _SAME) else at + step
