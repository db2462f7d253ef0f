"""What may be believed of each point of a branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.fourier import Series
from fenics_nnm.nonlinear.periodicity import return_errors
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.reduction.model import ReducedModel

#: Status of a point, from the best to the worst.
CONVERGED = "converged"
RESONANT = "inside resonance"
UNCHECKED = "unchecked"
UNRESOLVED = "unresolved"
STATUSES = (CONVERGED, RESONANT, UNCHECKED, UNRESOLVED)

#: A motion that misses its start by more than this part of its amplitude is not resolved.
_LARGEST_RETURN_ERROR = 1 / 3

#: Another mode with more than this share of the kinetic energy in one harmonic ...
_SHARE = 0.03

#: ... that meets its frequency to within this part is in internal resonance.
_DETUNING = 0.02


def judged(
    model: ReducedModel, series: Series, points: Sequence[BranchPoint], *, mode: int
) -> tuple[BranchPoint, ...]:
    """The points with return errors, internal resonances and statuses.

    Points of a model whose contact points carry mass stay "unchecked": their motion after an impact
    depends on an impact law that harmonic balance does not have.

    Args:
        model: Reduced model in SI units.
        series: Series that the points are written in.
        points: Points of a branch of this model.
        mode: Index of the followed mode.
    """
    errors: Array = np.full(len(points), np.nan)
    if model.massless:
        errors = return_errors(model, series, points)
    return tuple(
        _judged(model, point, float(error), internal_resonance(model, series, point, mode))
        for point, error in zip(points, errors, strict=True)
    )


def internal_resonance(model: ReducedModel, series: Series, point: BranchPoint, mode: int) -> str:
    """The mode and harmonic that draw energy from the motion in resonance, or nothing.

    In an internal resonance n omega stays near omega_j while energy flows into mode j, so the
    frequency lags behind the main branch.
    """
    order = series.order
    kinetic = (series.mean_square * order**2)[:, None] * point.q**2
    kinetic[np.ix_(order == 1, [mode])] = 0.0
    harmonic = np.maximum(order, 1)[:, None] * 2 * np.pi * point.frequency
    near = np.abs(model.omega / harmonic - 1) < _DETUNING
    total = float(((series.mean_square * order**2)[:, None] * point.q**2).sum())
    share = np.where(near, kinetic, 0.0) / total
    row, column = np.unravel_index(int(np.argmax(share)), share.shape)
    if share[row, column] < _SHARE:
        return ""
    return f"mode {column + 1} in harmonic {int(order[row])}"


def _judged(model: ReducedModel, point: BranchPoint, error: float, resonance: str) -> BranchPoint:
    if not model.massless:
        status = UNCHECKED
    elif not error <= _LARGEST_RETURN_ERROR:
        status = UNRESOLVED
    else:
        status = RESONANT if resonance else CONVERGED
    return replace(point, return_error=error, resonance=resonance, status=status)
