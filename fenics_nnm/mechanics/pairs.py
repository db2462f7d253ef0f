"""Pairs of masters, each once: how second-order displacements of a body are kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from fenics_nnm.arrays import Array, Indices


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pairs of k masters, each once.

    Attributes:
        first: The first of each pair, shape (p,).
        second: The second, not before it, shape (p,).
        place: Number of each pair, shape (k, k).
    """

    first: Indices
    second: Indices
    place: Indices

    @classmethod
    def of(cls, count: int) -> Self:
        """Pairs of so many."""
        first, second = np.triu_indices(count)
        place = np.zeros((count, count), dtype=np.int64)
        place[first, second] = place[second, first] = np.arange(len(first))
        return cls(first, second, place)

    def products(self, one: Array, other: Array | None = None) -> Array:
        """Factors of theta of the pairs in 1/2 sum theta_ij x_i y_j, from (.., k), (.., p)."""
        other = one if other is None else other
        both = one[..., self.first] * other[..., self.second]
        mirrored = one[..., self.second] * other[..., self.first]
        return np.where(self.first == self.second, both / 2, (both + mirrored) / 2)
