"""Continuation of a nonlinear mode over energy."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.full_order_solver import FlexibilitySource
from fenics_nnm.nonlinear.levels import HarmonicBalance, contact_model, levels
from fenics_nnm.nonlinear.lift import SHARE_DROP, Lift, Stack
from fenics_nnm.nonlinear.mode import HarmonicEquations
from fenics_nnm.nonlinear.newton import Newton, Solution
from fenics_nnm.nonlinear.point import BranchPoint, PointMaker
from fenics_nnm.nonlinear.reduction_error import (
    NO_ERROR,
    UNKNOWN_ERROR,
    ReductionError,
    reduction_error,
)
from fenics_nnm.nonlinear.series_error import series_error
from fenics_nnm.nonlinear.verdict import judged
from fenics_nnm.reduction.model import ReducedModel, Scales
from fenics_nnm.reduction.truncation import Truncation

#: Energies that differ by less than this part are the same.
_SAME = 1e-9

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class EnergyContinuation:
    """Which energies to visit; all are ratios gamma / gamma_grazing.

    Attributes:
        start: First ratio.
        stop: Last ratio.
        step: Largest step.
        smallest_step: A step that fails is halved down to this.
        report_at: Ratios that must be among the points.
        newton: Newton's configuration.
    """

    start: float
    stop: float
    step: float
    smallest_step: float = 0.005
    report_at: tuple[float, ...] = ()
    newton: Newton = field(default_factory=lambda: Newton(iterations=25))

    def __post_init__(self) -> None:
        if not 0 < self.start < self.stop:
            raise ModelError(
                f"energies from {self.start:g} to {self.stop:g}: must be 0 < from < to"
            )
        outside = [ratio for ratio in self.report_at if not self.start <= ratio <= self.stop]
        if outside:
            raise ModelError(
                f"report_at = {outside[0]:g}: must lie between {self.start:g} and {self.stop:g}"
            )

    def targets(self) -> list[float]:
        """Ratios to visit, ascending: equal steps no larger than `step`, and `report_at`."""
        count = int(np.ceil((self.stop - self.start) / self.step - 1e-9))
        grid = self.start + (self.stop - self.start) * np.arange(count + 1) / count
        free = [g for g in grid if all(abs(g - r) > 1e-9 * r for r in self.report_at)]
        return sorted({*(float(g) for g in free), *self.report_at})


@dataclass(frozen=True, slots=True)
class Branch:
    """A branch and the reason of its end.

    Attributes:
        points: Converged points, by ascending energy.
        failures: Wanted ratios without a point, each with the reason.
        reason: Why the branch ended.
    """

    points: tuple[BranchPoint, ...]
    failures: tuple[tuple[float, str], ...]
    reason: str

    @property
    def complete(self) -> bool:
        """Whether every wanted energy has a point."""
        return not self.failures


def follow(
    model: ReducedModel,
    continuation: EnergyContinuation,
    balance: HarmonicBalance,
    *,
    mode: int,
    flexibility: FlexibilitySource | None = None,
    truncation: Truncation | None = None,
    shooting: bool = False,
    known: Sequence[BranchPoint] = (),
    on_point: Callable[[BranchPoint], None] = lambda point: None,
    on_progress: Callable[[float], None] = lambda ratio: None,
) -> Branch:
    """Follow a nonlinear mode over energy.

    Each energy is approached from coarse to fine levels, so a point inside an internal resonance
    does not spoil those after it. A second look, down the branch, tries the energies that could
    not be reached from below, and those whose motion has lost energy to other modes.

    Args:
        model: Reduced model in SI units.
        continuation: Energies to visit.
        balance: Series in time, and how contact is found.
        mode: Index of the linear mode that the branch starts at, from 0.
        flexibility: Residual flexibility of the full model, in SI units, for a branch of full
            order; with multipliers the contact points carry mass.
        truncation: What the model leaves out, in SI units, for an error estimate of each point.
        shooting: Whether to shoot for the true motion near each point of a reduced model whose
            contact points carry no mass.
        known: Points found before, in SI units; they are part of the branch as they are.
        on_point: Called with each converged point before the next one is begun; a later point at
            the same energy replaces the earlier one. The check of periodicity comes at the end.
        on_progress: Called with each energy ratio that has been dealt with.

    Raises:
        ModelError: if the mode is not in the model or never touches.
    """
    if not 0 <= mode < model.modes:
        raise ModelError(f"mode.number = {mode + 1}: must be between 1 and {model.modes}")
    scaled, scales = model.dimensionless(mode)
    beyond = flexibility and _dimensionless(flexibility, scales)
    lift = Lift(levels(scaled, balance, mode=mode, flexibility=beyond), mode, continuation.newton)
    finest = lift.levels[-1].equations
    error = _error_estimate(finest, scales, truncation, full_order=flexibility is not None)
    maker = PointMaker(finest, scales, error, lambda solution: series_error(finest, solution))
    march = _March(lift, maker, continuation, on_point)
    march.take_over(known)
    for target in continuation.targets():
        if not march.has(target):
            march.reach(target)
        on_progress(target)
    march.second_look()
    found = [march.points[ratio] for ratio in sorted(march.points)]
    obeyed = contact_model(model, balance, full_order=flexibility is not None)
    shooting = shooting and flexibility is None  # the flow is that of a reduced model
    points = judged(obeyed, balance.series, found, mode=mode, shooting=shooting)
    failures = tuple(sorted(march.failures.items()))
    return Branch(points, failures, _reason(continuation, points, failures))


def _dimensionless(source: FlexibilitySource, scales: Scales) -> FlexibilitySource:
    return lambda omega: source(omega * scales.omega).dimensionless(scales)


def _error_estimate(
    equations: HarmonicEquations, scales: Scales, truncation: Truncation | None, *, full_order: bool
) -> Callable[[Solution], ReductionError]:
    """From a solution to the error of the reduction."""
    if full_order:
        return lambda solution: NO_ERROR
    if truncation is None:
        return lambda solution: UNKNOWN_ERROR
    known = truncation.dimensionless(scales)
    return lambda solution: reduction_error(known, equations, solution)


@dataclass(slots=True)
class _March:
    """Run state of `follow`."""

    lift: Lift
    maker: PointMaker
    continuation: EnergyContinuation
    on_point: Callable[[BranchPoint], None]
    points: dict[float, BranchPoint] = field(default_factory=dict)
    stacks: dict[float, Stack] = field(default_factory=dict)
    failures: dict[float, str] = field(default_factory=dict)

    def take_over(self, known: Sequence[BranchPoint]) -> None:
        """Begin with points that were found before."""
        for point in known:
            ratio = point.gamma_ratio
            self.points[ratio] = point
            self.stacks[ratio] = self.lift.restored(ratio, self.maker.solution(point))

    def has(self, target: float) -> bool:
        """Whether there is a point at an energy."""
        return any(abs(ratio - target) <= _SAME * target for ratio in self.points)

    def reach(self, target: float, first: Stack | None = None) -> None:
        """Get to `target` in halved steps where one step fails.

        Args:
            target: Wanted energy ratio.
            first: Point to begin at; the nearest one if None.
        """
        at = target
        neighbour = first or self._nearest(target)
        while True:
            stack = self.lift.at(at, neighbour)
            if stack.finest is not None:
                self._accept(stack)
                if at == target:
                    return
                at, neighbour = target, stack
                continue
            logger.info("gamma_ratio %.4f: %s", at, stack.failure)
            self.failures.setdefault(target, stack.failure)
            start = neighbour.gamma_ratio if neighbour else at
            at = (start + at) / 2
            if abs(at - start) < self.continuation.smallest_step:
                return

    def second_look(self) -> None:
        """Go down the branch: try again what is missing, or has lost energy to other modes."""
        for ratio in sorted({*self.stacks, *self.failures}, reverse=True):
            above = min((g for g in self.stacks if g > ratio), default=None)
            if above is None:
                continue
            if ratio in self.failures:
                self.reach(ratio, self.stacks[above])
            elif self.stacks[ratio].share < self.stacks[above].share - SHARE_DROP:
                stack = self.lift.at(ratio, self.stacks[above])
                if stack.share > self.stacks[ratio].share:
                    self._accept(stack)

    def _nearest(self, target: float) -> Stack | None:
        nearest = min(self.stacks, key=lambda ratio: abs(ratio - target), default=None)
        return None if nearest is None else self.stacks[nearest]

    def _accept(self, stack: Stack) -> None:
        assert stack.finest is not None
        point = self.maker.point(stack.gamma_ratio, stack.finest)
        self.on_point(point)
        self.stacks[stack.gamma_ratio] = stack
        self.points[stack.gamma_ratio] = point
        self.failures.pop(stack.gamma_ratio, None)


def _reason(
    continuation: EnergyContinuation,
    points: tuple[BranchPoint, ...],
    failures: tuple[tuple[float, str], ...],
) -> str:
    if not failures:
        return f"reached gamma_ratio {continuation.stop:g}"
    if not points:
        return f"no point converged; at gamma_ratio {failures[0][0]:g}: {failures[0][1]}"
    missing = ", ".join(f"{ratio:g}" for ratio, _ in failures)
    return f"no point at gamma_ratio {missing}: {failures[0][1]}"
