"""The course of a motion with second-order kinematics: its steps, and what follows from them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby

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

    @property
    def changed(self) -> bool:
        """Whether a change of contact ended it."""
        return self.passed < self.step.rule.step

    @property
    def end(self) -> tuple[Array, Array]:
        """Coordinates and velocities at its end, each of shape (J,)."""
        linear = self.step.stage.linear
        q, velocity = (linear.V @ self.step.after(self.passed)).T
        return linear.rest + q, velocity


def parts_until(parts: Iterable[Part], span: float) -> Iterator[Part]:
    """Parts of a motion until a time, the last one left there."""
    clock = 0.0
    for part in parts:
        left = span - clock
        if part.passed >= left:
            yield Part(part.step, left)
            return
        yield part
        clock += part.passed


@dataclass(frozen=True, slots=True)
class Course:
    """A motion from a state.

    Attributes:
        q: Coordinates at the start, shape (J,).
        velocity: Their velocities, shape (J,).
        end: Coordinates and velocities at the end, each of shape (J,).
        parts: Its steps.
        failure: Empty, or why it was not followed to the end.
    """

    q: Array
    velocity: Array
    end: tuple[Array, Array]
    parts: tuple[Part, ...]
    failure: str = ""
    _known: list[Array] = field(init=False, repr=False, compare=False, default_factory=list)

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return sum(bytes_of(p.step.seen, p.step.pushes, p.step.remainder) for p in self.parts)

    @property
    def changes(self) -> int:
        """How often the set of points in contact changed."""
        return sum(part.changed for part in self.parts[:-1])

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
        """Changes of the end along changes of the start, as columns of shape (2 J, c).

        The derivative by the whole state is kept once it was asked for.
        """
        if changes.shape[1] >= len(changes) and not self._known:
            self._known.append(self._carried(np.eye(len(changes))))
        return np.asarray(self._known[0] @ changes) if self._known else self._carried(changes)

    def _carried(self, changes: Array) -> Array:
        slopes = _slopes(self.parts)
        for _, group in groupby(self.parts, key=lambda part: id(part.step.stage)):
            parts = list(group)
            V = parts[0].step.stage.linear.V
            changes = _turned(V.T, changes)
            for part in parts:
                changes = part.step.carried(part.passed, changes, next(slopes))
            changes = _turned(V, changes)
        return changes

    def _clocked(self) -> Iterator[tuple[Part, float]]:
        """Its parts with the times at which they begin."""
        clock = 0.0
        for part in self.parts:
            yield part, clock
            clock += part.passed


def _turned(matrix: Array, changes: Array) -> Array:
    """Changes (2 J, c) of coordinates and velocities, both by a matrix (J, J)."""
    both = changes.reshape(2, len(matrix), changes.shape[1])
    return np.asarray((matrix @ both).reshape(changes.shape))


def _slopes(parts: Sequence[Part]) -> Iterator[Array]:
    """Slopes of the remainder at the nodes of parts, made for all parts of a stage at once."""
    alike: dict[int, list[SmoothStep]] = {}
    for part in parts:
        alike.setdefault(id(part.step.stage), []).append(part.step)
    found = {stage: iter(_slopes_alike(steps)) for stage, steps in alike.items()}
    return (next(found[id(part.step.stage)]) for part in parts)


def _slopes_alike(steps: Sequence[SmoothStep]) -> Sequence[Array]:
    """Those of steps of one stage."""
    seen = np.concatenate([step.seen for step in steps], axis=1)
    return np.split(steps[0].stage.remainder.slopes(seen), len(steps))
