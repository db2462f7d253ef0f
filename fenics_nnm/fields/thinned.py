"""A motion at few of its instants, and how far from straight lines it is between them.

A length, and the mean stress with 2/3 of von Mises', is convex: on a straight line between two
states it is not above the larger one of theirs. So with amounts a_s(t) of shapes of size L_s the
largest one over all instants is not above that of a few of them and

    sum_s max_t |a_s(t) - line_s(t)| L_s.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: Of so many instants one is looked at.
_EVERY = 6


@dataclass(frozen=True, slots=True)
class Thinned:
    """Amounts of shapes at all instants and at few.

    Attributes:
        amounts: Amounts at all, shape (t, shapes).
        few: Those at few of them, shape (k, shapes).
        bent: Largest difference of each from the straight lines between them, shape (shapes,).
    """

    amounts: Array
    few: Array
    bent: Array

    def of(self, shapes: Indices) -> Thinned:
        """Those of some shapes alone."""
        return Thinned(self.amounts[:, shapes], self.few[:, shapes], self.bent[shapes])


def thinned(amounts: Array, phase: Array) -> Thinned:
    """Amounts (t, shapes) and those at few of the ascending phases (t,), both ends among them."""
    places = np.arange(len(phase))
    kept = np.union1d(places[::_EVERY], places[-1:])
    if len(kept) == len(phase):
        return Thinned(amounts, amounts, np.zeros(amounts.shape[1]))
    before = np.minimum(np.searchsorted(kept, places, side="right") - 1, len(kept) - 2)
    first, last = phase[kept[before]], phase[kept[before + 1]]
    part = ((phase - first) / (last - first))[:, None]
    few = amounts[kept]
    line = (1 - part) * few[before] + part * few[before + 1]
    return Thinned(amounts, few, np.abs(amounts - line).max(axis=0))
