"""One factor of the static flexibility for many sets of points that are nearly nested.

Contact spreads from a few points and draws back to them, so the sets of points in contact at the
samples are nearly nested. With those points first that belong to most sets, a set is a leading part
of all points, but for a few points D that are removed from it and a few E that are added. In this
order R = L L^T, and the leading blocks of L are the factors of those of R: one factor serves all.
With B = L^-T and P the projection on the leading coordinates, the forces on a set that close gaps e
are

    lambda = B P (B^T e + B_D^T w - L_E^T lambda_E) + lambda_E,

    [ B_D P B_D^T      -B_D P L_E^T   ] [    w     ]   [ -B_D P B^T e     ]
    [ L_E P B_D^T   L_E (1 - P) L_E^T ] [ lambda_E ] = [ L_E (1 - P) B^T e],

with w the openings that leave D without force. The small matrix is the part of the principal pivot
transform of R that belongs to D and E; both its diagonal blocks are positive definite, so that it
is never singular (Cottle, Pang, Stone, The Linear Complementarity Problem, 1992, sec. 2.3).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri

from fenics_nnm.arrays import Array, Indices, Mask

#: Sets may leave their leading parts by this many points more than twice those at first.
_FEW = 8


@dataclass(frozen=True, slots=True)
class NestedOrder:
    """An order of the points in which some sets are nearly leading parts.

    Attributes:
        points: Points in that order, shape (n_c,).
        place: Place of each point in it, shape (n_c,).
        flips: Most points removed from the leading part of a set and added to it, at first.
    """

    points: Indices
    place: Indices
    flips: int

    @classmethod
    def of(cls, sets: Mask) -> NestedOrder:
        """Those points first that belong to most of the sets, shape (s, n_c)."""
        points = np.argsort(-sets.sum(axis=0), kind="stable")
        order = cls(points, np.argsort(points), 0)
        return replace(order, flips=order.most_flips(sets))

    def leading(self, sets: Mask) -> Indices:
        """Length of the leading part that is nearest to each set, shape (s, 1)."""
        apart = np.zeros((len(sets), len(self.points) + 1), dtype=np.int64)
        np.cumsum(1 - 2 * sets[:, self.points], axis=1, out=apart[:, 1:])
        return np.argmin(apart, axis=1)[:, None]

    def flipped(self, sets: Mask, leading: Indices) -> Mask:
        """Points removed from leading parts of these lengths, and added to them, (s, n_c)."""
        return sets ^ (self.place < leading)

    def most_flips(self, sets: Mask) -> int:
        """Most points removed and added of any of the sets."""
        return int(self.flipped(sets, self.leading(sets)).sum(axis=1).max(initial=0))

    def suits(self, sets: Mask) -> bool:
        """Whether sets are leading parts about as nearly as those it was made for."""
        return self.most_flips(sets) <= 2 * self.flips + _FEW


@dataclass(frozen=True, slots=True)
class NestedFactor:
    """Cholesky factor of a flexibility in an order in which some sets are nearly nested.

    Attributes:
        order: The order.
        R: Flexibility, symmetric positive definite, shape (n_c, n_c).
        rows: Rows of L of the points, R = rows rows^T, shape (n_c, n_c).
        dual: Rows of B = L^-T of the points, R^-1 = dual dual^T, shape (n_c, n_c).
    """

    order: NestedOrder
    R: Array
    rows: Array
    dual: Array

    @classmethod
    def of(cls, R: Array, order: NestedOrder) -> NestedFactor:
        """The factor of R, symmetric, shape (n_c, n_c).

        Raises:
            numpy.linalg.LinAlgError: if R is not positive definite to round-off.
        """
        L, failed = dpotrf(R[order.points[:, None], order.points], lower=True)
        if failed:
            raise np.linalg.LinAlgError("the contact flexibility is not positive definite")
        inverse, _ = dtrtri(L, lower=True)
        return cls(order, R, L[order.place], inverse.T[order.place])

    def on(self, sets: Mask) -> FactoredSets:
        """Sets of points of shape (s, n_c), each by the leading part that is nearest to it."""
        leading = self.order.leading(sets)
        points, used = compressed(self.order.flipped(sets, leading))
        belongs = np.take_along_axis(sets, points, 1)
        return FactoredSets(
            factor=self,
            sets=sets,
            leading=np.arange(sets.shape[1]) < leading,
            points=points,
            removed=used & ~belongs,
            added=used & belongs,
        )


@dataclass(frozen=True, slots=True)
class FactoredSets:
    """Sets of points as leading parts of an order, less some points, and some others.

    Attributes:
        factor: Factor in this order.
        sets: The sets, shape (s, n_c).
        leading: Coordinates of the leading parts, shape (s, n_c).
        points: Points removed or added, padded, shape (s, k).
        removed: Which of them are removed, shape (s, k).
        added: Which of them are added, shape (s, k).
    """

    factor: NestedFactor
    sets: Mask
    leading: Mask
    points: Indices
    removed: Mask
    added: Mask

    def closing(self, gaps: Array) -> Array:
        """Forces at the points of each set that close gaps there, both of shape (s, n_c).

        The inverse factor leaves gaps of round-off times the condition of R, which are closed too.
        """
        force = self._closing(gaps)
        return force + self._closing(gaps - force @ self.factor.R)

    def _closing(self, gaps: Array) -> Array:
        local = np.where(self.sets, gaps, 0.0)
        projected, flipped = self._projected((local @ self.factor.dual)[:, :, None])
        force = projected[:, :, 0] @ self.factor.dual.T
        kept = np.take_along_axis(force, self.points, 1)
        flips = np.where(self.added, flipped[:, :, 0], np.where(self.removed, 0.0, kept))
        np.put_along_axis(force, self.points, flips, 1)
        return np.where(self.sets, force, 0.0)

    def stiffness(self, shapes: Array) -> Array:
        """Phi_A^T R_AA^-1 Phi_A for shapes Phi of shape (n_c, J), shape (s, J, J)."""
        along = self.factor.dual.T @ shapes
        projected, flipped = self._projected(along[None])
        at_added = shapes[self.points] * self.added[:, :, None]
        return along.T @ projected + np.swapaxes(at_added, 1, 2) @ flipped

    def _projected(self, along: Array) -> tuple[Array, Array]:
        """P (z + B_D^T w - L_E^T lambda_E) and (w, lambda_E), for z of shape (1 or s, n_c, r)."""
        added, used = self.added[:, :, None], (self.added | self.removed)[:, :, None]
        rows = np.where(added, self.factor.rows[self.points], self.factor.dual[self.points]) * used
        upper = np.where(self.leading[:, None, :], rows, 0.0)
        lower = rows - upper
        upper_down, lower_down = np.swapaxes(upper, 1, 2), np.swapaxes(lower, 1, 2)
        sign = np.where(added, -1.0, 1.0)
        both_added = added & np.swapaxes(added, 1, 2)
        matrix = (upper @ upper_down) * np.swapaxes(sign, 1, 2)
        matrix = np.where(both_added, lower @ lower_down, matrix) + np.eye(rows.shape[1]) * ~used
        right = np.where(added, lower @ along, -(upper @ along))
        flipped = np.linalg.solve(matrix, right)
        projected = along + upper_down @ (sign * flipped)
        return np.where(self.leading[:, :, None], projected, 0.0), flipped


def compressed(chosen: Mask) -> tuple[Indices, Mask]:
    """Indices of the points chosen in each row, these first, and which are no padding."""
    count = chosen.sum(axis=1)
    width = int(count.max(initial=0))
    points = np.argsort(~chosen, axis=1, kind="stable")[:, :width]
    return points, np.arange(width) < count[:, None]
