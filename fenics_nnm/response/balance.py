"""Work of what drives a motion, and what damping takes out of it."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.nonlinear.solution import Solution

#: A larger part of the work that damping does not take out is an error.
LARGEST_IMBALANCE = 1e-6

#: Work that is smaller than this part of what it could be with any phases is round-off.
_NOTHING = 1e-9
_TINY = float(np.finfo(float).tiny)


def imbalance(mechanics: Mechanics, series: FourierSeries, motion: Solution) -> float:
    """Work of given forces and moving gaps over a period less dissipation, relative to the work.

    Stiffness, inertia and gyroscopic terms do no work over a period, springs and contact at gaps
    that stand still neither: the linear part does what damping takes. A gap that moves pushes with
    -lambda at the rate g'. Forces that turn with the motion put in what they do on second-order
    displacement, too.
    """
    q = motion.q
    push = np.zeros_like(q)
    for each in mechanics.excitations:
        push += each.harmonics(series)
    force = motion.forces.harmonics(series)
    gaps = np.broadcast_to(mechanics.gap_motion.coefficients(series), force.shape)
    rates, gap_rates = series.turned(q), series.turned(gaps)
    work = _mean(series, push, rates) - _mean(series, force, gap_rates)
    lost = _mean(series, mechanics.linear.at(series, motion.omega).times(q), rates)
    largest = _mean(series, np.abs(push), np.abs(rates))
    largest += _mean(series, np.abs(force), np.abs(gap_rates))
    for turned in mechanics.turned:
        own, size = turned.work(SampledMotion(series, q, motion.omega))
        work, largest = work + own, largest + size
    return abs(work - lost) / max(abs(work), _NOTHING * largest, _TINY)


def _mean(series: FourierSeries, force: Array, rates: Array) -> float:
    """Mean over the phase of forces times rates, both as coefficients, shape (c, J)."""
    return float(np.sum(series.mean_square[:, None] * force * rates))
