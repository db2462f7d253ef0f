"""What may be believed of each point of a branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.certificate import certified
from fenics_nnm.nonlinear.fourier import Series
from fenics_nnm.nonlinear.periodicity import return_errors
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.nonlinear.resonance import INSIDE, strongest_resonance
from fenics_nnm.reduction.model import ReducedModel

#: Status of a point, from the best to the worst.
CONVERGED = "converged"
RESONANT = "inside resonance"
UNCHECKED = "unchecked"
UNRESOLVED = "unresolved"
STATUSES = (CONVERGED, RESONANT, UNCHECKED, UNRESOLVED)

#: A motion that misses its start by more than this part of its amplitude is not resolved.
_LARGEST_RETURN_ERROR = 1 / 3

#: So is one whose true motion of the same energy has another frequency by more than this part.
_LARGEST_SHOT_CHANGE = 0.01


def judged(
    model: ReducedModel,
    series: Series,
    points: Sequence[BranchPoint],
    *,
    mode: int,
    shooting: bool,
) -> tuple[BranchPoint, ...]:
    """The points with return errors, internal resonances, statuses and shot motions.

    Points of a model whose contact points carry mass stay "unchecked": their motion after an impact
    depends on an impact law that harmonic balance does not have.

    Args:
        model: Reduced model in SI units.
        series: Series that the points are written in.
        points: Points of a branch of this model.
        mode: Index of the followed mode.
        shooting: Whether to shoot for the true motion near each point.
    """
    errors: Array = np.full(len(points), np.nan)
    if model.massless:
        errors = return_errors(model, series, points)
        points = certified(model, series, points) if shooting else points
    return tuple(
        _judged(point, float(error), internal_resonance(model, series, point, mode))
        for point, error in zip(points, errors, strict=True)
    )


def internal_resonance(model: ReducedModel, series: Series, point: BranchPoint, mode: int) -> str:
    """The mode and harmonic that draw energy from the motion in resonance, or nothing."""
    omega = 2 * np.pi * point.frequency
    found = strongest_resonance(model.omega, series, point.q, omega, mode=mode)
    return str(found) if found.share > INSIDE else ""


def _judged(point: BranchPoint, error: float, resonance: str) -> BranchPoint:
    if np.isnan(error):
        status = UNCHECKED
    elif error > _LARGEST_RETURN_ERROR or _shot_elsewhere(point):
        status = UNRESOLVED
    else:
        status = RESONANT if resonance else CONVERGED
    return replace(point, return_error=error, resonance=resonance, status=status)


def _shot_elsewhere(point: BranchPoint) -> bool:
    return abs(point.shot_frequency / point.frequency - 1) > _LARGEST_SHOT_CHANGE
