"""What shooting finds near the points of a branch: the true motion, and its stability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fenics_nnm.nonlinear.family import Steps
from fenics_nnm.nonlinear.flow import Flow
from fenics_nnm.nonlinear.fourier import Series
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.nonlinear.shooting import Shooting, shoot
from fenics_nnm.nonlinear.stability import stability
from fenics_nnm.reduction.model import ReducedModel

#: Up to this part above grazing there is no contact.
_AT_GRAZING = 1e-9

#: No walks along a family: a point that is not near a true motion of its energy stays without one.
_DIRECT = Shooting(steps=Steps(walk=0))


def certified(
    model: ReducedModel, series: Series, points: Sequence[BranchPoint]
) -> tuple[BranchPoint, ...]:
    """The points with the frequency and the largest Floquet multiplier of the shot motion.

    Args:
        model: Reduced model in SI units, with massless contact points.
        series: Series that the points are written in.
        points: Points of a branch of this model.
    """
    flow = Flow(model)
    return tuple(_certified(flow, series, point) for point in points)


def _certified(flow: Flow, series: Series, point: BranchPoint) -> BranchPoint:
    if point.gamma_ratio <= 1 + _AT_GRAZING:  # a linear mode
        return replace(point, shot_frequency=point.frequency, largest_multiplier=1.0)
    shot = shoot(flow, series, point, options=_DIRECT)
    if not shot.converged:
        return point
    found = stability(flow, shot)
    largest = float("nan") if found.failure else float(found.largest)
    return replace(point, shot_frequency=shot.frequency, largest_multiplier=largest)
