"""The course of a motion with second-order kinematics: its steps, and what follows from them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.smooth_step import SmoothStep


@dataclass(frozen=True, slots=True)
class Part:
    """A step, and how much of it the motion goes along.

    Attributes:
        step: Step.
        passed: Time from its start.
    """

    step: SmoothStep
    passed: float


@dataclass(frozen=True, slots=True)
class Course:
    """A motion from a state.

    Attributes:
        q: Coordinates at the start, shape (J,).
        velocity: Their velocities, shape (J,).
        end: Coordinates and velocities at the end, each of shape (J,).
        parts: Its steps.
        changes: How often the set of points in contact changed.
        failure: Empty, or why it was not followed to the end.
    """

    q: Array
    velocity: Array
    end: tuple[Array, Array]
    parts: tuple[Part, ...]
    changes: int
    failure: str = ""

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return sum(bytes_of(p.step.seen, p.step.pushes, p.step.remainder) for p in self.parts)

    @property
    def contact_time(self) -> float:
        """Time with contact at some point in s."""
        return sum(part.passed for part in self.parts if part.step.stage.linear.contact)

    @property
    def speed_integral(self) -> float:
        """Integral of |q'|^2 in J s."""
        return sum(part.step.speed_integral(part.passed) for part in self.parts)

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at ascending times, each of shape (t, J); nan beyond it."""
        q, velocity = (np.full((len(times), len(self.q)), np.nan) for _ in range(2))
        q[times <= 0], velocity[times <= 0] = self.q, self.velocity
        for part, clock in self._clocked() if len(times) else ():
            at = (times > clock) & (times <= clock + part.passed)
            if at.any():
                q[at], velocity[at] = part.step.states(times[at] - clock)
        return q, velocity

    def carried(self, changes: Array) -> Array:
        """Changes of the end along changes of the start, as columns of shape (2 J, c)."""
        for part in self.parts:
            changes = part.step.carried(part.passed, changes)
        return changes

    def _clocked(self) -> Iterator[tuple[Part, float]]:
        """Its parts with the times at which they begin."""
        clock = 0.0
        for part in self.parts:
            yield part, clock
            clock += part.passed
