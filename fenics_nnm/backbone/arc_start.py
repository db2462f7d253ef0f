"""Where a branch that is followed by its length begins, and which way it goes."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.harmonic_copy import linear_motion
from fenics_nnm.backbone.mode_trace import GAMMA_DOWN, GAMMA_UP
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.continuation.branch_switching import switched
from fenics_nnm.continuation.events import branch_point_at
from fenics_nnm.continuation.heading import Along, Heading
from fenics_nnm.nonlinear.conditions import FixedEnergy
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns


class NoStartError(Exception):
    """There is no motion to begin at; the text says why."""


@dataclass(frozen=True, slots=True)
class Begin:
    """A known motion that a branch begins at.

    Attributes:
        point: Motion, of the model and in the series of the branch.
        along: Its neighbours on the branch that is known, where the other branch that crosses
            it there is wanted; else None.
        downwards: Whether to set out towards lower energies, or to the second side of a crossing.
    """

    point: BranchPoint
    along: tuple[BranchPoint, BranchPoint] | None = None
    downwards: bool = False


@dataclass(frozen=True, slots=True)
class ArcStart:
    """A motion, and the way on from it."""

    solution: Solution
    heading: Heading


@dataclass(frozen=True, slots=True)
class ArcStarts:
    """Finds where a branch begins.

    Attributes:
        problem: Equations of the finest level.
        cascade: Levels, and their motions of given energy.
        maker: Knows the solutions of points.
    """

    problem: Problem
    cascade: Cascade
    maker: PointMaker

    def is_linear_at(self, gamma_ratio: float) -> bool:
        """Whether the branch is linear at an energy."""
        equations = self.cascade.levels[-1].equations
        linear = equations.rest.is_linear(self.cascade.mode) and not equations.mechanics.forces
        return gamma_ratio < 1 and linear

    def linear(self, gamma_ratio: float, *, harmonic: int) -> ArcStart:
        """The linear mode, written in a harmonic, towards larger motions."""
        equations = self.cascade.levels[-1].equations
        linear = linear_motion(
            equations, self.cascade.mode, harmonic=harmonic, amplitude=gamma_ratio**0.5
        )
        growth = linear.with_q(equations.motion(linear.q))
        way = Along(Unknowns.of(self._stacked(growth), 0.0))
        return ArcStart(self._at_energy_of(linear), way)

    def nonlinear(self, gamma_ratio: float) -> ArcStart:
        """The motion of an energy that the levels lead to, towards higher energies.

        Raises:
            NoStartError: if there is none.
        """
        found = self.cascade.at(gamma_ratio, None)
        if found.finest is None:
            raise NoStartError(found.failure)
        return ArcStart(self._held(found.finest), GAMMA_UP)

    def known(self, begin: Begin) -> ArcStart:
        """A known motion, or the one beside it on the branch that crosses there.

        Raises:
            NoStartError: if there is none.
        """
        found = self._held(self.maker.solution(begin.point))
        if begin.along is None:
            return ArcStart(found, GAMMA_DOWN if begin.downwards else GAMMA_UP)
        way = self._way(*(self.maker.solution(point) for point in begin.along))
        first, second = switched(self.problem, branch_point_at(self.problem, found, way))
        side = second if begin.downwards else first
        if side is None:
            raise NoStartError("no motion was found on this side of the branch point")
        return ArcStart(side.solution, Along(side.metric.unscaled(side.tangent)))

    def onward(self, before: BranchPoint, last: BranchPoint) -> ArcStart:
        """The last point, and the way that led there."""
        first, second = self.maker.solution(before), self.maker.solution(last)
        return ArcStart(self._at_energy_of(second), Along(self._way(first, second)))

    def _held(self, near: Solution) -> Solution:
        """The motion of the same gamma next to one, which must exist."""
        found = self._at_energy_of(near)
        if not found.converged:
            raise NoStartError(f"no motion to begin at: {found.failure}")
        return found

    def _at_energy_of(self, near: Solution) -> Solution:
        """The motion of the same gamma next to one that may be stored or of another series."""
        guess = Unknowns.of(self._stacked(near), near.omega)
        return self.problem.solve(FixedEnergy(near.energies.gamma), guess)

    def _way(self, first: Solution, second: Solution) -> Unknowns:
        """The way from a motion to another one."""
        change = self._stacked(second) - self._stacked(first)
        return Unknowns.of(change, second.omega - first.omega)

    def _stacked(self, solution: Solution) -> Array:
        """Unknowns of a solution that has modal coordinates alone."""
        equations = self.problem.about(solution.omega)
        return equations.stacked(solution.q, solution.forces.force)
