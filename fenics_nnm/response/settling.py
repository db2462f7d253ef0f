"""A driven motion from rest, in time, as a guess of the periodic motion that it settles on."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.time_domain.driven_flow import driven_flow

#: Periods after which a motion is taken as it is, and the change of state over one, relative in the
#: energy norm, below which it has settled sooner.
_PERIODS, _SETTLED = 200, 1e-4


def settled_from_rest(mechanics: Mechanics, series: FourierSeries, omega: float) -> Unknowns:
    """What a motion from rest at a circular frequency in rad/s has come to in its last period.

    Args:
        mechanics: What it obeys, with equations in time.
        series: Series in time that it is written in.
        omega: Circular frequency in rad/s.
    """
    flow = driven_flow(mechanics, omega)
    period, scale = 2 * np.pi / omega, mechanics.model.omega
    q: Array = np.zeros(len(scale))
    velocity: Array = np.zeros(len(scale))
    for _ in range(_PERIODS):
        after = flow.run(q, velocity, period)
        if after.failure:
            break
        change = _size(scale, after.q - q, after.velocity - velocity)
        q, velocity = after.q, after.velocity
        if change < _SETTLED * _size(scale, q, velocity):
            break
    last = flow.run(q, velocity, period, times=series.phase / omega)
    if last.failure:
        return Unknowns.of(np.zeros((len(series.order), len(scale))), omega)
    return Unknowns.of(np.asarray(series.analysis @ last.q_at), omega)


def _size(scale: Array, q: Array, velocity: Array) -> float:
    return float(np.linalg.norm([scale * q, velocity]))
