"""A structure at one of the speeds of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.reduction.mode_lines import same_modes
from fenics_nnm.structure.analysis import Analyse

#: Modes computed beyond those that are followed, as lines cross.
SPARE = 4


@dataclass(frozen=True, slots=True)
class SpinModes:
    """Modes of a structure at a speed.

    Attributes:
        speed: Speed in rad/s.
        frequencies: Their frequencies in Hz, shape (w,).
        shapes: Their mass-normalised shapes at the degrees of freedom of this rank, shape (n, w).
        momenta: M times them, shape (n, w).
        gap: Smallest gap in m.
    """

    speed: float
    frequencies: Array
    shapes: Array
    momenta: Array
    gap: float


@dataclass(frozen=True, slots=True)
class Spin:
    """A structure at a speed.

    Attributes:
        study: The study at this speed.
        analyse: Finds what is linear of it.
        modes: Its modes.
    """

    study: Any
    analyse: Analyse
    modes: SpinModes


@dataclass(slots=True)
class FollowedModes:
    """The lowest modes at the first speed, followed by their shapes over ascending speeds.

    Attributes:
        count: Number of modes to follow.
        inner: a^T b over all ranks, of two blocks of columns.
    """

    count: int
    inner: Callable[[Array, Array], Array]
    _shapes: Array | None = field(default=None)

    @property
    def begun(self) -> bool:
        """Whether a speed has been seen."""
        return self._shapes is not None

    def at(self, modes: SpinModes) -> Indices:
        """Index of each followed mode among those of the next speed, from 0; on all ranks."""
        if self._shapes is None:
            kept: Indices = np.arange(min(self.count, len(modes.frequencies)))
        else:
            kept = same_modes(self.inner(self._shapes, modes.momenta))
        self._shapes = modes.shapes[:, kept]
        return kept
