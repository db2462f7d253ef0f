"""An independent check of converged motions: integration in time over one and ten periods.

Harmonic balance solves truncated equations; a motion whose higher harmonics matter can solve them
to round-off and still be no motion of the model. Followed from its initial state, a motion
that is resolved comes back after a period, one that is not misses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.time_domain.flow import Flow

#: Periods that a motion is followed for.
PERIODS = 10


@dataclass(frozen=True, slots=True)
class Return:
    """How a motion comes back to where it started.

    Distances are relative in the energy norm: 1 is as far away as the amplitude.

    Attributes:
        after_one: Distance of the state after one period from its start; nan if given up before.
        after_ten: The same after ten periods. On an unstable motion it grows by the multipliers.
        energy_drift: Largest relative change of the energy in ten periods: what the integration
            itself does wrong.
        start_energy: Energy of the state at the start over that of the point, less 1.
        failure: Empty, or why the ten periods were not followed to their end.
    """

    after_one: float
    after_ten: float
    energy_drift: float
    start_energy: float
    failure: str = ""


#: Of motions that cannot be followed.
UNKNOWN_RETURN = Return(float("nan"), float("nan"), float("nan"), float("nan"))


def returned(flow: Flow, series: Series, point: BranchPoint) -> Return:
    """Follow a point from its initial state, exactly from one change of contact to the next.

    Args:
        flow: Flow of the model that the point belongs to, in SI units.
        series: Series that the point is written in.
        point: Point.
    """
    position, rate = series.basis_at(np.zeros(1))[0], series.rate_at(np.zeros(1))[0]
    q, velocity = position @ point.q, 2 * np.pi * point.frequency * rate @ point.q
    times = np.arange(1, PERIODS + 1) / point.frequency
    after = flow.run(q, velocity, times[-1], times=times[:-1])
    states = np.vstack([after.q_at, after.q]), np.vstack([after.velocity_at, after.velocity])
    missed = np.hypot(flow.model.omega * (states[0] - q), states[1] - velocity)
    misses = np.linalg.norm(missed, axis=1) / np.sqrt(2 * point.energy)
    first = float(misses[0])
    if after.failure:
        return replace(UNKNOWN_RETURN, after_one=first, failure=after.failure)
    energy = flow.energy(q, velocity)
    energies = np.array([flow.energy(*state) for state in zip(*states, strict=True)])
    drift = float(np.abs(energies / energy - 1).max())
    return Return(first, float(misses[-1]), drift, energy / point.energy - 1)
