"""Work of the forces that drive a motion, and what damping takes out of it."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.nonlinear.unknowns import Unknowns

#: A larger part of the work that damping does not take out is an error.
LARGEST_IMBALANCE = 1e-6

#: Work that is smaller than this part of what it could be with any phases is round-off.
_NOTHING = 1e-9


def imbalance(mechanics: Mechanics, series: FourierSeries, at: Unknowns) -> float:
    """Work of the given forces over a period less dissipation, relative to the work.

    Stiffness, inertia and gyroscopic terms do no work over a period, contact and springs neither:
    the linear part does what damping takes.
    """
    push = np.sum([each.harmonics(series) for each in mechanics.excitations], axis=0)
    rates = series.turned(at.q)
    work = _mean(series, push, rates)
    lost = _mean(series, mechanics.linear.at(series, at.omega).times(at.q), rates)
    largest = _mean(series, np.abs(push), np.abs(rates))
    return abs(work - lost) / max(abs(work), _NOTHING * largest)


def _mean(series: FourierSeries, force: Array, rates: Array) -> float:
    """Mean over the phase of forces times rates, both as coefficients, shape (c, J)."""
    return float(np.sum(series.mean_square[:, None] * force * rates))
