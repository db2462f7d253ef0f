"""Which neighbours of a damped branch a family joins, though their frequencies seem to part them.

From the motion of one the energy is raised, with the damping as it is, to that of the other one.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fenics_nnm.backbone.damped_model import DampedModel
from fenics_nnm.backbone.damped_motions import Found, risen
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.time_domain.resonant_motion import (
    ResonantMotion,
    driven_by_push,
    resonant_motion,
)

#: Motions whose frequencies agree to this are the same.
_SAME = 1e-6


def damped_joins(
    damped: DampedModel,
    series: FourierSeries,
    points: Sequence[BranchPoint],
    numbers: Sequence[int],
) -> frozenset[int]:
    """Numbers of the points that a family joins to the next one, which has another number.

    Args:
        damped: Model with its damping.
        series: Series that points are written in.
        points: Points by rising gamma ratio.
        numbers: Numbers of their families by the course of the frequency.
    """
    pairs = enumerate(zip(pairwise(points), pairwise(numbers), strict=True))
    return frozenset(
        i for i, (both, apart) in pairs if len(set(apart)) > 1 and _joined(damped, series, *both)
    )


def _joined(
    damped: DampedModel, series: FourierSeries, one: BranchPoint, other: BranchPoint
) -> bool:
    begin = exact_motion(damped, series, one)
    if begin.failure:
        return False
    way = risen(damped, other.gamma_ratio, Found(one.gamma_ratio, begin))
    reached = way.motions[-1].omega / (2 * np.pi)
    return not way.failure and abs(reached / other.motion.frequency - 1) <= _SAME


def exact_motion(damped: DampedModel, series: FourierSeries, point: BranchPoint) -> ResonantMotion:
    """The exact motion that a point was written from.

    The level of its force is that which puts in what the damping ratio of the point takes.
    """
    q, omega, at = point.motion.q, 2 * np.pi * point.motion.frequency, np.zeros(1)
    rate = omega * series.rate_at(series.phase) @ q
    along = np.mean(series.synthesis @ q @ damped.push * np.cos(series.phase))
    assert point.sustained is not None
    level = 2 * point.sustained.ratio * np.mean(np.sum(rate**2, axis=1)) / along
    velocity = omega * series.rate_at(at)[0] @ q
    guess = ResonantMotion(series.basis_at(at)[0] @ q, velocity, omega, float(level))
    flow = driven_by_push(damped.model, damped.rate, damped.push)
    gamma = point.gamma_ratio * damped.grazing_gamma
    return resonant_motion(flow, damped.push, gamma, guess)
