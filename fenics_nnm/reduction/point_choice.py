"""Which places become contact points: those that come to the obstacle first, the others spread.

Contact begins where the followed mode first brings a place to its obstacle. If that place is no
contact point, the model is free beyond first contact, and its whole energy axis is off.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.approach import Approach

#: Distances that differ by less than this part of the size of all places are the same.
_TIE = 1e-9

#: Coordinates that differ by less than this part of that size are the same.
_SAME_COORDINATE = 1e-6

#: A place is as near as the nearest one if its amplitude of contact is larger by this part only.
_AS_NEAR = 1e-3

#: Places that differ by this part only are alike by symmetry: the place itself decides.
_ALIKE = 1e-6


@dataclass(frozen=True, slots=True)
class PointChoice:
    """The places of a patch that become contact points.

    Attributes:
        chosen: Their indices, ascending.
        needed: Those that come to the obstacle first, as far as that is known.
    """

    chosen: Indices
    needed: tuple[int, ...] = ()

    @classmethod
    def evenly(cls, points: Array, count: int) -> PointChoice:
        """So many of the places, far from each other.

        Args:
            points: Coordinates in m, shape (n, dim).
            count: Number of places, at most n.
        """
        return cls(spread(points, count))

    def improved(self, points: Array, approach: Approach, taken: Mask) -> PointChoice:
        """The same where it has what comes to the obstacle first, else others about that.

        Args:
            points: Coordinates in m, shape (n, dim).
            approach: How the followed mode brings the places to the obstacle.
            taken: Places that are contact points of another patch already, shape (n,).
        """
        count = len(self.chosen)
        nearest = _nearest(points, approach, self.chosen)
        needed = tuple(dict.fromkeys([*self.needed, *nearest]))[:count]
        if np.isin(needed, self.chosen).all():
            return replace(self, needed=needed)
        if np.count_nonzero(~taken) < count:
            return self
        return PointChoice(spread(points, count, first=needed, barred=taken), needed)


def spread(
    points: Array, count: int, *, first: tuple[int, ...] = (), barred: Mask | None = None
) -> Indices:
    """Indices of `count` points that lie far from each other, ascending.

    Starts with the point farthest from the centre and adds the one farthest from all chosen; of
    points as far as each other the one with the smallest last coordinate, then the one before.

    Args:
        points: Coordinates, shape (n, dim).
        count: Number of points.
        first: Points to start with.
        barred: Points that are left out unless they are among the first, shape (n,).
    """
    if count >= len(points):
        return np.arange(len(points))
    order = _order(points)
    distance = np.linalg.norm(points - points.mean(axis=0), axis=1)
    tie = _TIE * float(distance.max())
    chosen = list(first or [_farthest(distance, tie, order)])
    distance = np.min([np.linalg.norm(points - points[each], axis=1) for each in chosen], axis=0)
    if barred is not None:
        distance[barred] = -1.0
    while len(chosen) < count:
        chosen.append(_farthest(distance, tie, order))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.sort(np.array(chosen, dtype=np.int64))


def _farthest(distance: Array, tie: float, order: Indices) -> int:
    """Of the largest distances, which may differ by round-off, the first in an order."""
    return int(order[np.argmax(distance[order] >= distance.max() - tie)])


def _order(points: Array) -> Indices:
    """Points in the order of their last coordinate, where it is the same of the one before."""
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max()) or 1.0
    rounded = np.round((points - low) / (_SAME_COORDINATE * size))
    return np.lexsort(rounded.T)


def _nearest(points: Array, approach: Approach, chosen: Indices) -> list[int]:
    """The place that comes first of each kind, a chosen one where that is as near."""
    found = []
    for distance in _kinds(approach):
        nearest = float(distance.min())
        near = nearest + _AS_NEAR * abs(nearest)
        own = chosen[distance[chosen] <= near]
        among = own if len(own) else np.arange(len(points))
        found.append(_first_place(points, distance, among))
    return found


def _kinds(approach: Approach) -> Iterator[Array]:
    """Distances of the places that are met at rest, and by either half of the motion.

    Those of other places are infinite. Kinds without a place are left out; the first one comes
    first.
    """
    clearance, reach = approach.clearance, approach.reach
    at_rest = np.where(clearance <= 0, clearance, np.inf)
    sides = [np.where(sign * approach.motion > 0, reach, np.inf) for sign in (1, -1)]
    for distance in [at_rest, *sorted(sides, key=lambda side: float(side.min()))]:
        if np.isfinite(distance.min()):
            yield distance


def _first_place(points: Array, distance: Array, among: Indices) -> int:
    """The nearest of some places; of those alike, the first one in the order of coordinates."""
    nearest = float(distance[among].min())
    alike = among[distance[among] <= nearest + _ALIKE * abs(nearest)]
    return int(alike[_order(points[alike])[0]])
