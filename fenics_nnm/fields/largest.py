"""Largest values of fields that become known part by part of a body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import floor

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.backbone.extremes import KINDS, NOWHERE, Spot, StressPeak
from fenics_nnm.fields.screening import with_largest

#: The quantile beside the largest value.
_QUANTILE = 0.999

#: Values that differ by less than this part are equal.
_SAME = 1e-9


@dataclass(frozen=True, slots=True)
class Nodes:
    """Nodes of a part of a body.

    Attributes:
        numbers: Their numbers in the mesh of branch.h5, shape (n,).
        places: Their places in m, shape (n, 3).
        kinds: Their numbers in `KINDS`, shape (n,).
        region: Numbers of their materials, shape (n,).
    """

    numbers: Indices
    places: Array
    kinds: Indices
    region: Indices

    @property
    def regular(self) -> Indices:
        """Those that are not singular."""
        return np.flatnonzero(self.kinds == 0)

    def spot(self, at: int, value: float) -> Spot:
        """A value at one of them."""
        x, y, z = (float(each) for each in self.places[at])
        return Spot(value, int(self.numbers[at]), (x, y, z))


@dataclass(slots=True)
class Largest:
    """The largest of a value over all nodes, found part by part.

    Attributes:
        total: Number of all nodes.
    """

    total: int
    _away: Spot = NOWHERE
    _anywhere: Spot = NOWHERE
    _kind: int = 0
    _top: Array = field(default_factory=lambda: np.empty(0))

    @property
    def away(self) -> Spot:
        """The largest value of the nodes that are not singular."""
        return self._away

    @property
    def peak(self) -> StressPeak:
        """All that is known of it."""
        at = _QUANTILE * (self.total - 1)
        below, above = self._top[0], self._top[min(1, len(self._top) - 1)]
        quantile = float(below + (at - floor(at)) * (above - below))
        return StressPeak(self._away, self._anywhere, KINDS[self._kind], quantile)

    def add(self, nodes: Nodes, bound: Array, exact: Callable[[Indices], Array]) -> None:
        """Take further nodes into account.

        Args:
            nodes: The nodes.
            bound: What their values are not above, shape (n,).
            exact: Values at some of them.
        """
        least = self._top[0] if len(self._top) == self._kept else -np.inf
        found, values = with_largest(bound, exact, self._kept, least)
        if len(found):
            at = first_of_largest(values, nodes.numbers[found])
            spot = nodes.spot(found[at], float(values[at]))
            if _above(spot, self._anywhere):
                self._anywhere, self._kind = spot, int(nodes.kinds[found[at]])
            self._top = np.sort(np.concatenate([self._top, values]))[-self._kept :]
        self.add_regular(nodes, bound, exact)

    def add_regular(self, nodes: Nodes, bound: Array, exact: Callable[[Indices], Array]) -> None:
        """The same for the largest value of regular nodes alone; nan bounds are left out."""
        chosen = nodes.regular
        chosen = chosen[~np.isnan(bound[chosen])]
        if not len(chosen):
            return
        least = self._away.value if self._away.known else -np.inf
        found, values = with_largest(bound[chosen], lambda few: exact(chosen[few]), 1, least)
        if not len(found):
            return
        at = first_of_largest(values, nodes.numbers[chosen[found]])
        spot = nodes.spot(chosen[found[at]], float(values[at]))
        if _above(spot, self._away):
            self._away = spot

    @property
    def _kept(self) -> int:
        """Number of values from the one below the quantile on."""
        return self.total - floor(_QUANTILE * (self.total - 1))


def first_of_largest(values: Array, numbers: Indices) -> int:
    """Place of the largest value; of those equal but for round-off that of the lowest node.

    So what is symmetric has its largest value at the same node on any number of ranks.
    """
    if np.isnan(values).any():
        return int(np.argmax(values))
    equal = np.flatnonzero(values >= values.max() - _SAME * np.abs(values).max())
    return int(equal[np.argmin(numbers[equal])])


def _above(one: Spot, other: Spot) -> bool:
    """Whether a value is above another; of equal ones that of the lower node stays."""
    if not other.known:
        return True
    difference, round_off = one.value - other.value, _SAME * max(abs(one.value), abs(other.value))
    return difference > round_off or (difference >= -round_off and one.node < other.node)
