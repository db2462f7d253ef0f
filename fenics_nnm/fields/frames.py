"""Frames of a period, and which of them show the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: Instants of a period at which the largest stress is sought, besides those of the frames.
_INSTANTS = 128


@dataclass(frozen=True, slots=True)
class Frames:
    """Frames of a period at equal steps; the last is one step before its end.

    A reversible motion, u(-t) = u(t), passes the second half of the period like the first one
    backwards: fields of displacements and stresses are the same, velocities the opposite.

    Attributes:
        count: Number of frames.
        reversible: Whether the motion is reversible.
    """

    count: int
    reversible: bool

    @property
    def distinct(self) -> int:
        """Number of frames whose displacements differ: these are the first ones."""
        return self.count // 2 + 1 if self.reversible else self.count

    @property
    def times(self) -> Array:
        """Times of these as parts of the period."""
        return np.arange(self.distinct) / self.count

    @property
    def all_times(self) -> list[float]:
        """Times of all frames as parts of the period."""
        return [number / self.count for number in range(self.count)]

    @property
    def distinct_of_each(self) -> list[int]:
        """The distinct frame with the displacement of each frame."""
        found = [0] * self.count
        for number in range(self.distinct):
            for frame in self.shown_by(number):
                found[frame] = number
        return found

    def shown_by(self, number: int) -> dict[int, float]:
        """Frames with the displacement of one of these, and the factor of its velocity."""
        image = (self.count - number) % self.count
        alone = image == number or not self.reversible
        return {number: 1.0} if alone else {number: 1.0, image: -1.0}

    def searched(self) -> tuple[Array, Indices]:
        """Times at which the largest stress is sought, and where those of the frames are there."""
        instants = np.arange(_INSTANTS // 2 + 1 if self.reversible else _INSTANTS) / _INSTANTS
        times = np.unique(np.concatenate([self.times, instants]))
        return times, np.searchsorted(times, self.times)
