"""An independent check of converged motions: integration in time over one and ten periods.

Harmonic balance solves truncated equations; a motion whose higher harmonics matter can solve them
to round-off and still be no motion of the model. Followed from its initial state, a motion
that is resolved comes back after a period, one that is not misses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.backbone.point import Return
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.time_domain.integrator import Integrator

#: Periods that a motion is followed for, if that is all that is known of it.
PERIODS = 10

_NAN = float("nan")


@dataclass(frozen=True, slots=True)
class InTime:
    """What became of a motion that was integrated in time.

    Attributes:
        returned: How it comes back; None if that was given up within the first period.
        start_energy: Energy of the state at the start over that of the motion, less 1; nan if the
            periods were not followed to their end.
        failure: Empty, or why they were not.
    """

    returned: Return | None
    start_energy: float
    failure: str = ""


#: Of motions that cannot be followed, as contact points carry mass.
NOT_FOLLOWED = InTime(None, _NAN)


def followed(flow: Integrator, series: Series, motion: Motion, *, periods: int = PERIODS) -> InTime:
    """Follow a motion from its initial state.

    Args:
        flow: Integrator of the model that the motion belongs to, in SI units.
        series: Series that the motion is written in.
        motion: Motion.
        periods: How many periods.
    """
    position, rate = series.basis_at(np.zeros(1))[0], series.rate_at(np.zeros(1))[0]
    q, velocity = position @ motion.q, 2 * np.pi * motion.frequency * rate @ motion.q
    times = np.arange(1, periods + 1) / motion.frequency
    after = flow.run(q, velocity, times[-1], times=times[:-1])
    states = np.vstack([after.q_at, after.q]), np.vstack([after.velocity_at, after.velocity])
    missed = np.hypot(flow.model.omega * (states[0] - q), states[1] - velocity)
    misses = np.linalg.norm(missed, axis=1) / np.sqrt(2 * motion.energy)
    first = float(misses[0])
    if after.failure:
        returned = None if np.isnan(first) else Return(first, _NAN, _NAN)
        return InTime(returned, _NAN, after.failure)
    energy = flow.energy(q, velocity)
    energies = np.array([flow.energy(*state) for state in zip(*states, strict=True)])
    drift = float(np.abs(energies / energy - 1).max())
    last = float(misses[-1]) if periods == PERIODS else _NAN
    return InTime(Return(first, last, drift), energy / motion.energy - 1)
