"""Contact forces at many points, of which those near contact alone take part.

Most points of a large patch stay open by a wide margin at all samples. The forces are found among
the others, and where these leave a point beyond its gap it takes part, too: so they obey the same
conditions at all points, and they are unique.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.complementary import ROUND_OFF, complementary
from fenics_nnm.mechanics.set_flexibility import SetFlexibility

#: With fewer points than this, or if more than this part of them are near contact, all take part.
_MANY, _MOST = 160, 0.6

#: Points whose excess comes nearer to zero than this part of the largest excess are near contact.
_NEAR = 0.3


@dataclass(frozen=True, slots=True)
class NearContact:
    """A flexibility, and which points take part.

    Attributes:
        R: Flexibility of all points, symmetric positive definite, shape (n_c, n_c).
        chosen: Points that take part, ascending, shape (k,).
        among: Flexibility among them.
        rows: Rows of R of these points, shape (k, n_c).
    """

    R: Array
    chosen: Indices
    among: SetFlexibility
    rows: Array

    @classmethod
    def of(cls, R: Array, near: Mask) -> NearContact:
        """The points of a mask of shape (n_c,), or all if they are few or most are near."""
        if len(R) < _MANY or np.count_nonzero(near) > _MOST * len(R):
            return cls.whole(R)
        chosen = np.flatnonzero(near)
        rows = R[chosen]
        return cls(R, chosen, SetFlexibility(np.ascontiguousarray(rows[:, chosen])), rows)

    @classmethod
    def at(cls, R: Array, excess: Array) -> NearContact:
        """The points near contact at any of s samples, from e of shape (s, n_c)."""
        return cls.of(R, _near(excess))

    @classmethod
    def whole(cls, R: Array) -> NearContact:
        """All points, without copies of R."""
        return cls(R, np.arange(len(R)), SetFlexibility(R), R)

    def about(self, excess: Array) -> NearContact:
        """The points near contact at any of s samples, from e of shape (s, n_c)."""
        return NearContact.at(self.R, excess)

    def known_of(self, R: Array) -> NearContact | None:
        """This, if it is of this very array."""
        return self if R is self.R else None

    def light(self) -> NearContact:
        """The same without factors and copies of R, to be kept."""
        return NearContact.whole(self.R)

    def blocks(self, points: Indices, used: Mask) -> Array:
        """Rows and columns of R at points of shape (s, k), a multiple of 1 where not `used`."""
        return SetFlexibility(self.R).blocks(points, used)

    def stiffness(self, sets: Mask, shapes: Array) -> Array:
        """Phi_A^T R_AA^-1 Phi_A for sets A of points that take part, shape (s, J, J)."""
        if self.among.R is self.R and self.among.bare:
            part = NearContact.of(self.R, np.asarray(sets.any(axis=0)))
            return part.among.stiffness(sets[:, part.chosen], shapes[part.chosen])
        return self.among.stiffness(sets[:, self.chosen], shapes[self.chosen])

    def forces(self, excess: Array, guess: Mask | None = None) -> tuple[Array, NearContact]:
        """Forces lambda at s samples, shape (s, n_c), and the points that took part.

        Args:
            excess: e, shape (s, n_c).
            guess: Points that may be in contact, shape (s, n_c), if known.

        Raises:
            numpy.linalg.LinAlgError: if R is singular to round-off.
        """
        near = self
        if near.lacks(excess.max(axis=0) > 0):
            near = near.with_more(_near(excess))
        while True:
            force, near = near.forces_among(excess, guess)
            beyond = near.beyond(excess, force)
            if not beyond.any():
                return force, near
            near = near.with_more(np.asarray(beyond.any(axis=0)))
            guess = (force > 0) | beyond

    def lacks(self, wanted: Mask) -> bool:
        """Whether not all of some points, shape (n_c,), take part."""
        return int(np.count_nonzero(wanted[self.chosen])) < int(np.count_nonzero(wanted))

    def with_more(self, wanted: Mask) -> NearContact:
        """The same with more points, shape (n_c,)."""
        wanted = wanted.copy()
        wanted[self.chosen] = True
        more = NearContact.of(self.R, wanted)
        parts = self.among.parts.among(np.searchsorted(more.chosen, self.chosen))
        return replace(more, among=replace(more.among, parts=parts))

    def forces_among(self, excess: Array, guess: Mask | None) -> tuple[Array, NearContact]:
        """Forces of the points that take part, shape (s, n_c), as if there were no others."""
        if len(self.chosen) == len(self.R):
            force, among = complementary(self.among, excess, guess)
            return force, replace(self, among=among)
        force, own = np.zeros_like(excess), None if guess is None else guess[:, self.chosen]
        force[:, self.chosen], among = complementary(self.among, excess[:, self.chosen], own)
        return force, replace(self, among=among)

    def beyond(self, excess: Array, force: Array) -> Mask:
        """Points that do not take part and lie beyond their gaps, shape (s, n_c)."""
        if len(self.chosen) == len(self.R):
            return np.zeros(excess.shape, dtype=bool)
        pushed = np.diagonal(self.R).max() * force.sum(axis=1)
        size = np.abs(excess).max(axis=1) + pushed
        opening = force[:, self.chosen] @ self.rows - excess
        opening[:, self.chosen] = 0.0
        return np.asarray(opening < -ROUND_OFF * size[:, None])


def _near(excess: Array) -> Mask:
    """Points near contact at any of s samples, shape (n_c,), from e of shape (s, n_c)."""
    nearest = excess.max(axis=0)
    return np.asarray(nearest > -_NEAR * max(float(nearest.max()), 0.0))
