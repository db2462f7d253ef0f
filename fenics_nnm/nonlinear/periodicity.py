"""An independent check of converged motions: integration in time over one period.

Harmonic balance solves truncated equations; a motion whose higher harmonics matter can solve them
to round-off and still be no motion of the model. Followed from its initial state, a motion
that is resolved comes back after a period, one that is not misses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.flow import Flow
from fenics_nnm.nonlinear.fourier import Series
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.reduction.model import ReducedModel


def return_errors(model: ReducedModel, series: Series, points: Sequence[BranchPoint]) -> Array:
    """Distance of the state after one period from its start, relative in the energy norm.

    The motion is followed exactly from one change of contact to the next, so the errors are those
    of the points alone.

    Args:
        model: Reduced model in SI units.
        series: Series that the points are written in.
        points: Points of a branch of this model.

    Returns:
        One error a point, shape (len(points),); 0 is a perfect return, 1 as far away as the
        amplitude; nan where contact changes so often that the motion was given up.
    """
    if not points:
        return np.empty(0)
    flow = Flow(model)
    return np.array([_return_error(flow, series, point) for point in points])


def _return_error(flow: Flow, series: Series, point: BranchPoint) -> float:
    position, rate = series.basis_at(np.zeros(1))[0], series.rate_at(np.zeros(1))[0]
    q, velocity = position @ point.q, 2 * np.pi * point.frequency * rate @ point.q
    after = flow.run(q, velocity, 1 / point.frequency)
    if after.failure:
        return float("nan")
    missed = np.hypot(flow.model.omega * (after.q - q), after.velocity - velocity)
    return float(np.linalg.norm(missed) / np.sqrt(2 * point.energy))
