"""Factors of parts of a flexibility, for sets of points that are nested in groups only.

Contact that moves along a patch has sets of points that are not nested as a whole, but those at
samples that follow each other nearly are. They are halved until they are, and each group has the
factor of its own points, see `mechanics.nested_factor`. Factors are kept for sets to come.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg.lapack import dposv

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.nested_factor import NestedFactor, NestedOrder

#: Sets of a group differ from leading parts by at most so many points, or this part of the largest.
_FEW, _PART = 8, 0.06

#: Bytes of the factors that are kept besides those in use, and of what is worked on at once.
_KEPT, _AT_ONCE = 2**29, 2**25


@dataclass(frozen=True, slots=True, eq=False)
class FactoredPart:
    """Factor of the flexibility of some points.

    Attributes:
        points: The points, ascending, shape (k,).
        factor: Factor of the flexibility among them.
    """

    points: Indices
    factor: NestedFactor

    @classmethod
    def of(cls, R: Array, sets: Mask, order: NestedOrder) -> FactoredPart:
        """The points of sets of shape (s, n_c), in an order of all points."""
        taken = np.asarray(sets.any(axis=0))
        points = np.flatnonzero(taken)
        place = np.searchsorted(points, order.points[taken[order.points]])
        own = NestedOrder(place, np.argsort(place), order.flips)
        return cls(points, NestedFactor.of(R[points[:, None], points], own))

    @property
    def bytes_(self) -> int:
        """Memory that it takes."""
        return 3 * 8 * len(self.points) ** 2

    def suits(self, sets: Mask) -> Mask:
        """Which of some sets, shape (s, n_c), are nearly leading parts of its order."""
        own, order = sets[:, self.points], self.factor.order
        inside = own.sum(axis=1) == sets.sum(axis=1)
        flips = order.flipped(own, order.leading(own)).sum(axis=1)
        return np.asarray(inside & (flips <= 2 * order.flips + _FEW))

    def closing(self, sets: Mask, gaps: Array) -> Array:
        """Forces that close gaps at the points of sets, all of shape (s, n_c)."""
        force = np.zeros_like(gaps)
        force[:, self.points] = self.factor.on(sets[:, self.points]).closing(gaps[:, self.points])
        return force

    def stiffness(self, sets: Mask, shapes: Array) -> Array:
        """Phi_A^T R_AA^-1 Phi_A for shapes Phi of shape (n_c, J), shape (s, J, J)."""
        return self.factor.on(sets[:, self.points]).stiffness(shapes[self.points])

    def few(self, rows: Indices) -> Iterator[Indices]:
        """Some samples, as many at once as memory allows."""
        width = 2 * self.factor.order.flips + _FEW
        count = max(1, _AT_ONCE // (8 * width * len(self.points)))
        for first in range(0, len(rows), count):
            yield rows[first : first + count]


@dataclass(frozen=True, slots=True)
class FactoredParts:
    """Factors that suit some sets of points.

    Attributes:
        parts: The factors, the latest ones last.
    """

    parts: tuple[FactoredPart, ...] = ()

    def suited(self, R: Array, sets: Mask) -> FactoredParts:
        """With factors for sets of shape (s, n_c), as far as these fit in memory."""
        chosen = self.chosen(sets)
        left = chosen < 0
        if not left.any():
            return self
        used = [self.parts[number] for number in np.unique(chosen[~left])]
        idle = [part for part in self.parts if part not in used]
        room = _KEPT - sum(part.bytes_ for part in used)
        more = _fitting(_parts(R, sets[left]), room)
        room -= sum(part.bytes_ for part in more)
        return FactoredParts((*_fitting(reversed(idle), room), *used, *more))

    def chosen(self, sets: Mask) -> Indices:
        """Number of the first factor that suits each set of shape (s, n_c), or -1, shape (s,)."""
        found = np.full(len(sets), -1)
        for number, part in enumerate(self.parts):
            left = np.flatnonzero(found < 0)
            if not left.size:
                break
            found[left[part.suits(sets[left])]] = number
        return found

    def among(self, place: Indices) -> FactoredParts:
        """The same where points have other numbers: those given of the former ones, ascending."""
        return FactoredParts(tuple(replace(p, points=place[p.points]) for p in self.parts))

    def on(self, R: Array, sets: Mask) -> PartedSets:
        """Sets of shape (s, n_c), each with a factor that suits it if there is one."""
        return PartedSets(R, self.parts, sets, self.chosen(sets))


@dataclass(frozen=True, slots=True)
class PartedSets:
    """Sets of points, each with the factor of a part, or dealt with by itself.

    Attributes:
        R: Flexibility of all points, shape (n_c, n_c).
        parts: The factors.
        sets: The sets, shape (s, n_c).
        chosen: Number of the factor of each set, or -1, shape (s,).
    """

    R: Array
    parts: tuple[FactoredPart, ...]
    sets: Mask
    chosen: Indices

    def closing(self, gaps: Array) -> Array:
        """Forces at the points of each set that close gaps there, both of shape (s, n_c)."""
        force = np.zeros_like(gaps)
        for part, rows in self._groups():
            force[rows] = part.closing(self.sets[rows], gaps[rows])
        for row in self._alone():
            points = np.flatnonzero(self.sets[row])
            force[row, points] = self._solved(points, gaps[row, points])
        return force

    def stiffness(self, shapes: Array) -> Array:
        """Phi_A^T R_AA^-1 Phi_A for shapes Phi of shape (n_c, J), shape (s, J, J)."""
        modes = shapes.shape[1]
        found = np.zeros((len(self.sets), modes, modes))
        for part, rows in self._groups():
            found[rows] = part.stiffness(self.sets[rows], shapes)
        for row in self._alone():
            points = np.flatnonzero(self.sets[row])
            found[row] = shapes[points].T @ self._solved(points, shapes[points])
        return found

    def _solved(self, points: Indices, right: Array) -> Array:
        _, found, failed = dposv(self.R[points[:, None], points], right, lower=True)
        if failed:
            raise np.linalg.LinAlgError("the contact flexibility is not positive definite")
        return np.asarray(found)

    def _alone(self) -> Iterator[int]:
        """Sets without a factor that have a point."""
        return iter(np.flatnonzero((self.chosen < 0) & self.sets.any(axis=1)))

    def _groups(self) -> Iterator[tuple[FactoredPart, Indices]]:
        for number in np.unique(self.chosen[self.chosen >= 0]):
            part = self.parts[number]
            for rows in part.few(np.flatnonzero(self.chosen == number)):
                yield part, rows


def _fitting(parts: Iterable[FactoredPart], room: int) -> list[FactoredPart]:
    """The first of some factors, as many as fit into some bytes."""
    found: list[FactoredPart] = []
    for part in parts:
        room -= part.bytes_
        if room < 0:
            break
        found.append(part)
    return found


def _parts(R: Array, sets: Mask) -> Iterator[FactoredPart]:
    """Factors for sets of shape (s, n_c): of all of them, or of each half."""
    order = NestedOrder.of(sets)
    if len(sets) == 1 or order.flips <= max(_FEW, _PART * int(sets.sum(axis=1).max())):
        yield FactoredPart.of(R, sets, order)
        return
    half = len(sets) // 2
    yield from _parts(R, sets[:half])
    yield from _parts(R, sets[half:])
