"""Continuation of a nonlinear mode."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from fenics_nnm.backbone.advice import advice
from fenics_nnm.backbone.arc_march import ArcMarch
from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.cascade import Lift
from fenics_nnm.backbone.frequency_sweep import FrequencySweep
from fenics_nnm.backbone.levels import HarmonicBalance, Level, contact_model, levels
from fenics_nnm.backbone.march import March
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.targets import (
    ArcContinuation,
    Continuation,
    EnergyContinuation,
    FrequencyContinuation,
)
from fenics_nnm.backbone.verdict import judged
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.model import ReducedModel, Scales
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.full_order_solver import FlexibilitySource
from fenics_nnm.nonlinear.reduction_error import (
    NO_ERROR,
    ReductionError,
    reduction_error,
)
from fenics_nnm.nonlinear.series_error import SeriesError, series_error
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.reduction.truncation import Truncation

__all__ = [
    "ArcContinuation",
    "Branch",
    "Continuation",
    "EnergyContinuation",
    "FrequencyContinuation",
    "follow",
]

Failures = tuple[tuple[float, str], ...]


def follow(
    model: ReducedModel,
    continuation: Continuation,
    balance: HarmonicBalance,
    *,
    mode: int,
    flexibility: FlexibilitySource | None = None,
    truncation: Truncation | None = None,
    shooting: bool = False,
    known: Sequence[BranchPoint] = (),
    on_point: Callable[[BranchPoint], None] = lambda point: None,
    on_progress: Callable[[float], None] = lambda place: None,
) -> Branch:
    """Follow a nonlinear mode.

    Args:
        model: Reduced model in SI units.
        continuation: Energies or frequencies to visit, or a branch to follow by its length.
        balance: Series in time, and how contact is found.
        mode: Index of the linear mode that the branch starts at, from 0.
        flexibility: Residual flexibility of the full model, in SI units, for a branch of full
            order; with multipliers the contact points carry mass.
        truncation: What the model leaves out, in SI units, for an error estimate of each point.
        shooting: Whether to shoot for the true motion near each point of a reduced model whose
            contact points carry no mass.
        known: Points found before, in SI units; they are part of the branch as they are.
        on_point: Called with each converged point before the next one is begun; a later point at
            the same position replaces the earlier one. The check of periodicity comes at the end.
        on_progress: Called with each place that has been dealt with.

    Raises:
        ModelError: if the mode is not in the model or never touches, contact points carry mass
            and the continuation is not one in energy, or a gap is not positive where they carry
            mass or at full order.
    """
    if not 0 <= mode < model.modes:
        raise ModelError(f"mode.number = {mode + 1}: must be between 1 and {model.modes}")
    if flexibility is not None and model.gap.min() <= 0:
        raise ModelError(
            f"contact.gap = {model.gap.min():g}: must be positive at full order; gaps of any sign "
            'need reduction.method = "massless"'
        )
    obeyed = contact_model(model, balance, full_order=flexibility is not None)
    scaled, scales = model.dimensionless(mode)
    beyond = flexibility and _dimensionless(flexibility, scales)
    lift = Lift(levels(scaled, balance, mode=mode, flexibility=beyond), mode, continuation.newton)
    finest = lift.levels[-1].equations
    error = _error_estimate(finest, scales, truncation, full_order=flexibility is not None)
    harmonic = continuation.harmonic if isinstance(continuation, ArcContinuation) else 1
    maker = PointMaker(finest, scales, error, _series_estimate(lift.levels[-1]), harmonic)
    found, failures, reason = _followed(lift, maker, continuation, known, on_point, on_progress)
    if failures:
        reason = f"{reason}; {advice(continuation, balance.series)}"
    shooting = shooting and flexibility is None  # the flow is that of a reduced model
    verdicts = judged(
        obeyed, balance.series, found, mode=mode, harmonic=harmonic, shooting=shooting
    )
    return Branch(verdicts.points, failures, reason, verdicts.bifurcations)


def _dimensionless(source: FlexibilitySource, scales: Scales) -> FlexibilitySource:
    return lambda omega: source(omega * scales.omega).dimensionless(scales)


def _error_estimate(
    equations: HarmonicEquations, scales: Scales, truncation: Truncation | None, *, full_order: bool
) -> Callable[[Solution], ReductionError | None]:
    """From a solution to the error of the reduction, None where it is not known."""
    if full_order:
        return lambda solution: NO_ERROR
    if truncation is None:
        return lambda solution: None
    known = truncation.dimensionless(scales)
    return lambda solution: reduction_error(known, equations, solution)


def _series_estimate(finest: Level) -> Callable[[Solution], SeriesError | None]:
    """From a solution to the error of its series, unknown where contact points carry mass."""
    if finest.multipliers is not None:
        return lambda solution: None
    return lambda solution: series_error(finest.equations, solution)


def _followed(
    lift: Lift,
    maker: PointMaker,
    continuation: Continuation,
    known: Sequence[BranchPoint],
    on_point: Callable[[BranchPoint], None],
    on_progress: Callable[[float], None],
) -> tuple[list[BranchPoint], Failures, str]:
    """Points in the order of the branch, what is missing, and why the branch ended."""
    if isinstance(continuation, ArcContinuation):
        arc = ArcMarch(lift, maker, continuation, on_point)
        arc.run(known, on_progress)
        last = arc.points[-1].gamma_ratio if arc.points else continuation.start
        return arc.points, ((last, arc.failure),) if arc.failure else (), arc.reason
    sweep = None if isinstance(continuation, EnergyContinuation) else FrequencySweep(lift)
    march = March(sweep or lift, maker, continuation.name, continuation.smallest_step, on_point)
    march.take_over(known)
    downwards = lift.downwards and sweep is None
    march.run(continuation.targets(), on_progress, downwards=downwards)
    if sweep:
        march.pass_energies(continuation.report_at, sweep.at_energy)
    points = [march.points[place] for place in sorted(march.points)]
    failures = tuple(sorted(march.failures.items()))
    return points, failures, _reason(continuation, points, failures)


def _reason(
    continuation: Continuation,
    points: Sequence[BranchPoint],
    failures: Failures,
) -> str:
    name = continuation.name.replace("_", " ")
    if not failures:
        return f"reached {name} {continuation.stop:g}"
    if not points:
        return f"no point converged; at {name} {failures[0][0]:g}: {failures[0][1]}"
    missing = ", ".join(f"{ratio:g}" for ratio, _ in failures)
    return f"no point at {name} {missing}: {failures[0][1]}"
