"""What is wanted of a motion, collected stage by stage."""

from __future__ import annotations

from functools import partial
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.integrator import Trajectory


class Piece(Protocol):
    """The motion in one stage, from its start."""

    @property
    def contact(self) -> bool:
        """Whether any point is in contact."""

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times from the start, each of shape (len(times), J)."""

    def speed_integral(self, time: float) -> float:
        """Integral of |q'|^2 from the start to a time, in J s."""

    def carried(self, transition: Array, time: float) -> Array:
        """Derivatives of the state, shape (2 J, c), after some more time in this stage."""


class Record:
    """What is wanted of a motion, collected stage by stage."""

    def __init__(
        self, times: Array | None, modes: int, along: Array | None, *, speeds: bool
    ) -> None:
        """Nothing yet; arguments as of `Integrator.run`."""
        self._times = np.empty(0) if times is None else np.asarray(times)
        self._q = np.full((len(self._times), modes), np.nan)
        self._velocity = np.full((len(self._times), modes), np.nan)
        self._transition = along
        self._contact_time = 0.0
        self._speed_integral = 0.0 if speeds else float("nan")

    def note(self, motion: Piece, clock: float, duration: float) -> None:
        """Take what lies between `clock` and `duration` later."""
        if len(self._times):
            first = np.searchsorted(self._times, clock)
            last = np.searchsorted(self._times, clock + duration, side="right")
            chosen = slice(first, last)
            states = motion.states(self._times[chosen] - clock)
            self._q[chosen], self._velocity[chosen] = states
        if self._transition is not None:
            self._transition = motion.carried(self._transition, duration)
        self._contact_time += duration * motion.contact
        if not np.isnan(self._speed_integral):
            self._speed_integral += motion.speed_integral(duration)

    def trajectory(self, q: Array, velocity: Array, changes: int, failure: str) -> Trajectory:
        """The result, with the final state."""
        return Trajectory(
            q=q,
            velocity=velocity,
            changes=changes,
            contact_time=self._contact_time,
            q_at=self._q,
            velocity_at=self._velocity,
            speed_integral=self._speed_integral,
            derivative=None if self._transition is None else partial(np.asarray, self._transition),
            failure=failure,
        )
