"""Error estimates of the points of a branch: from a solution of the finest level to its error."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from fenics_nnm.backbone.levels import Level
from fenics_nnm.backbone.slope import frequency_slope
from fenics_nnm.mechanics.model import Scales
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.reduction_error import NO_ERROR, ReductionError, reduction_error
from fenics_nnm.nonlinear.series_error import SeriesError, series_error
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.reduction.truncation import Truncation

ReductionEstimate = Callable[[Solution], ReductionError | None]
"""From a solution to the error of the reduction, None where it is not known."""

SeriesEstimate = Callable[[Solution], SeriesError | None]
"""From a solution to the error of its series in time, None where it is not known."""

SlopeEstimate = Callable[[Solution], float]
"""From a solution to the slope d ln omega / d ln gamma of its family, nan where not known."""


def reduction_estimate(
    truncation: Truncation | None, equations: HarmonicEquations, scales: Scales
) -> ReductionEstimate:
    """Error of the reduction.

    Args:
        truncation: What the model leaves out, in SI units, if that is known.
        equations: Equations of the finest level, dimensionless.
        scales: Units of the dimensionless model.
    """
    if truncation is None:
        return unknown
    return partial(reduction_error, truncation.dimensionless(scales), equations)


def series_estimate(finest: Level) -> SeriesEstimate:
    """Error of the series, unknown where contact points carry mass."""
    if not finest.equations.model.massless:
        return unknown
    return partial(series_error, finest.equations)


def slope_estimate(finest: Level) -> SlopeEstimate:
    """Slope of the branch, nan where the law of contact has none."""
    if not finest.solver.knows_slopes:
        return no_slope
    return partial(frequency_slope, finest.equations)


def no_slope(solution: Solution) -> float:
    """A slope that is not known."""
    return float("nan")


def no_error(solution: Solution) -> ReductionError:
    """At full order nothing is left out."""
    return NO_ERROR


def unknown(solution: Solution) -> None:
    """An error that is not known."""
