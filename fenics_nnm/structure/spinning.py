"""A structure at one of the speeds of a Campbell diagram."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.structure.analysis import Analyse

#: Modes computed beyond those that are followed, as lines cross.
SPARE = 4


@dataclass(frozen=True, slots=True)
class Spin:
    """A structure at a speed.

    Attributes:
        study: The study at this speed.
        analyse: Finds what is linear of it.
        kept: Index of each followed mode among those at this speed, from 0, shape (k,).
        frequencies: Their frequencies in Hz, shape (k,).
        shapes: Their shapes, shape (n, k).
        gap: Smallest gap in m.
    """

    study: Any
    analyse: Analyse
    kept: Indices
    frequencies: Array
    shapes: Array
    gap: float

    @property
    def speed(self) -> float:
        """Speed in rad/s."""
        return float(self.study.speed)
