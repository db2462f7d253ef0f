"""The motion of a step between times at which it is known, against a closed form."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.exponential_rule import Weights, gauss_nodes
from fenics_nnm.time_domain.step_series import StepSeries, WatchedMotion

#: Circular frequencies, the step, and times at which the motion is known.
NU, STEP = np.array([1.5, 3.0, 16.0]), 0.5
WIDTH = STEP / 8
TIMES = np.concatenate([[1e-9], WIDTH * np.arange(1, 9)])


def _exact(time: float) -> Array:
    """Motion from x = 1, x' = 2 with x'' + nu^2 x = 1 + s^3, s = t / h.

    A particular solution is (1 + s^3 - 6 s / (nu h)^2) / nu^2.
    """
    s, bend = time / STEP, 6 / (NU * STEP) ** 2
    x, rate = 1 - 1 / NU**2, 2 + bend / (STEP * NU**2)
    cosine, sine = np.cos(NU * time), np.sin(NU * time)
    place = (1 + s**3 - bend * s) / NU**2 + x * cosine + rate * sine / NU
    speed = (3 * s**2 - bend) / (STEP * NU**2) - x * NU * sine + rate * cosine
    return np.column_stack([place, speed])


def test_motion_between_known_times_is_exact() -> None:
    nodes = gauss_nodes(7)
    force = np.tile(1 + nodes.at**3, (3, 1))
    series = StepSeries.of(nodes, NU, STEP, TIMES, WIDTH)
    watched = Weights.of(nodes, NU, STEP, TIMES).motion(np.ones(3), np.full(3, 2.0), force)
    between = WatchedMotion(series, watched, force)
    for time in (TIMES[0], 0.3 * WIDTH, 0.99 * WIDTH, 4.5 * WIDTH, 4.6 * WIDTH, 7.9 * WIDTH, STEP):
        np.testing.assert_allclose(between.at(float(time)), _exact(float(time)), rtol=3e-12)
