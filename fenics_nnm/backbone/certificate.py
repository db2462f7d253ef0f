"""What shooting finds near a point of a branch: the true motion, and its stability."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.time_domain.bifurcations import Witness
from fenics_nnm.time_domain.family import Steps
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.shooting import Shooting, ShotMotion, shoot
from fenics_nnm.time_domain.stability import STABLE, stability

#: No walk along a family: a point that is not near a true motion of its energy stays without one.
_DIRECT = Shooting(steps=Steps(walk=0))

#: A point that comes back within this after a period is near one: there a short walk is worth it.
_NEAR = 0.05
_SHORT_WALK = Shooting(steps=Steps(walk=20))


def certified(flow: Flow, series: Series, point: BranchPoint) -> tuple[BranchPoint, Witness | None]:
    """A point with the shot motion of its energy and the stability of that; and this motion.

    Args:
        flow: Flow of the model that the point belongs to, in SI units.
        series: Series that the point is written in.
        point: Point with its return error; where no motion is found, its `reason` becomes why.
    """
    shot = shot_motion(flow, series, point)
    if not shot.converged:
        why = f"no exact motion of its energy nearby: {shot.failure}"
        return replace(point, reason=why), None
    found = stability(flow, shot, reversible=not series.free_phase)
    certain = replace(
        point,
        shot_frequency=shot.frequency,
        shot_distance=shot.distance,
        shot_return_error=shot.return_error,
        largest_multiplier=found.largest,
        stability="" if found.failure else found.kind or STABLE,
        multipliers=found.multipliers,
    )
    return certain, None if found.failure else Witness(point.gamma_ratio, shot, found)


def shot_motion(flow: Flow, series: Series, point: BranchPoint) -> ShotMotion:
    """The motion of the energy of a point, by Newton's iteration, or also by a short walk."""
    near = point.return_error <= _NEAR
    return shoot(flow, series, point, options=_SHORT_WALK if near else _DIRECT)


def of_linear_mode(point: BranchPoint, others: Array) -> BranchPoint:
    """A point without contact: the linear mode itself is its exact motion, and stable.

    Args:
        point: The point.
        others: Circular frequencies in rad/s of the other linear modes, shape (J - 1,): over the
            period T their phases turn by omega_j T, so exp(+-i omega_j T) are the multipliers.
    """
    turns = np.exp(1j * others / point.frequency)
    return replace(
        point,
        shot_frequency=point.frequency,
        shot_distance=0.0,
        shot_return_error=0.0,
        largest_multiplier=1.0,
        stability=STABLE,
        multipliers=np.concatenate([turns, turns.conj()]),
    )
