"""The motion of a step near the times at which it was looked at, where steps end within."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fenics_nnm.arrays import Array

#: A time that the fastest mode turns by less from one that is known is near it, in radians: the
#: derivatives that are left out there are round-off.
_NEAR = 1e-3

#: Coordinates and, beside them, velocities by derivatives, over powers of the time from there.
_FACTORS = np.array([[1, 1, 1 / 2, 1 / 6, 1 / 24, 1 / 120], [0, 1, 1, 1 / 2, 1 / 6, 1 / 24]]).T

Derivatives = Callable[[float], Array]
"""From a time to coordinates of a stage there and their first five derivatives, shape (J, 6)."""


class NearMotion:
    """The motion at times that come close to each other, by a Taylor series where they are."""

    def __init__(self, derivatives: Derivatives, fastest: float) -> None:
        """Nothing yet.

        Args:
            derivatives: Gives the derivatives at a time.
            fastest: Circular frequency of the fastest mode in rad/s.
        """
        self._derivatives, self._reach = derivatives, _NEAR / fastest
        self._time = -np.inf
        self._known: Array = np.empty((0, 6))

    def at(self, time: float) -> Array:
        """Coordinates and velocities, shape (J, 2)."""
        if abs(time - self._time) > self._reach:
            self._time, self._known = time, self._derivatives(time)
        d = time - self._time
        powers = np.array((1.0, d, d**2, d**3, d**4, d**5))
        factors = _FACTORS.copy()
        factors[:, 0] *= powers
        factors[1:, 1] *= powers[:-1]
        return np.asarray(self._known @ factors)
