"""Static flexibility on many sets of points, by one factor where these are nearly nested.

Large sets that are not nested as a whole have factors in groups, see `mechanics.factored_parts`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.factored_parts import FactoredParts
from fenics_nnm.mechanics.nested_factor import NestedFactor, NestedOrder, compressed

#: With fewer points than this in contact one factor for all sets saves nothing.
_MANY = 32

#: Sets are nearly nested if they differ from leading parts by this part of the largest set.
_FEW = 0.25

#: With more points in contact than this, sets that are less nearly nested have factors in groups.
_LARGE, _FEW_OF_LARGE = 128, 0.1


class Sets(Protocol):
    """Sets A of points at s samples."""

    def closing(self, gaps: Array) -> Array:
        """Forces R_AA^-1 e_A that close gaps e, both of shape (s, n_c); 0 outside of the sets."""

    def stiffness(self, shapes: Array) -> Array:
        """Phi_A^T R_AA^-1 Phi_A for shapes Phi of shape (n_c, J), shape (s, J, J)."""


@dataclass(frozen=True, slots=True)
class SetFlexibility:
    """A flexibility and, where sets are nearly nested, its factor in their order.

    Attributes:
        R: Flexibility, symmetric positive definite, shape (n_c, n_c).
        factor: Factor, or None where each set has its own, or a group of sets.
        parts: Factors of groups of large sets.
    """

    R: Array
    factor: NestedFactor | None = None
    parts: FactoredParts = field(default_factory=FactoredParts)

    @property
    def bare(self) -> bool:
        """Whether there is no factor yet."""
        return self.factor is None and not self.parts.parts

    def suited(self, sets: Mask) -> SetFlexibility:
        """This, with another factor if sets of shape (s, n_c) ask for one."""
        if self.factor is not None and self.factor.order.suits(sets):
            return self
        widest = int(sets.sum(axis=1).max(initial=0))
        if widest <= _MANY:
            return replace(self, factor=None)
        order, large = NestedOrder.of(sets), widest > _LARGE
        if order.flips <= (_FEW_OF_LARGE if large else _FEW) * widest:
            return replace(self, factor=NestedFactor.of(self.R, order))
        parts = self.parts.suited(self.R, sets) if large else self.parts
        return replace(self, factor=None, parts=parts)

    def on(self, sets: Mask) -> Sets:
        """What to do with sets of shape (s, n_c)."""
        if self.factor is not None:
            return self.factor.on(sets)
        large = int(sets.sum(axis=1).max(initial=0)) > _LARGE
        return self.parts.on(self.R, sets) if large else ScatteredSets(self, sets)

    def blocks(self, points: Indices, used: Mask) -> Array:
        """Rows and columns of R at points of shape (s, k), a multiple of 1 where not `used`."""
        both = used[:, :, None] & used[:, None, :]
        found = self.R[points[:, :, None], points[:, None, :]]
        return np.where(both, found, np.eye(points.shape[1]) * np.diagonal(self.R).max())

    def stiffness(self, sets: Mask, shapes: Array) -> Array:
        """Phi_A^T R_AA^-1 Phi_A for sets A and shapes Phi of shape (n_c, J), shape (s, J, J)."""
        return self.suited(sets).on(sets).stiffness(shapes)


@dataclass(frozen=True, slots=True)
class ScatteredSets:
    """Sets of points, each with a flexibility matrix of its own.

    Attributes:
        flexibility: Flexibility of all points.
        sets: The sets, shape (s, n_c).
    """

    flexibility: SetFlexibility
    sets: Mask

    def closing(self, gaps: Array) -> Array:
        """Forces at the points of each set that close gaps there, both of shape (s, n_c)."""
        points, used = compressed(self.sets)
        local = np.where(used, np.take_along_axis(gaps, points, 1), 0.0)[:, :, None]
        solved = np.linalg.solve(self.flexibility.blocks(points, used), local)[:, :, 0]
        force = np.zeros_like(gaps)
        np.put_along_axis(force, points, np.where(used, solved, 0.0), 1)
        return force

    def stiffness(self, shapes: Array) -> Array:
        """Phi_A^T R_AA^-1 Phi_A for shapes Phi of shape (n_c, J), shape (s, J, J)."""
        points, used = compressed(self.sets)
        local = shapes[points] * used[:, :, None]
        solved = np.linalg.solve(self.flexibility.blocks(points, used), local)
        return np.swapaxes(local, 1, 2) @ solved
