"""Contact forces at few points, from a table of the inverse flexibility of each set of them.

Of n points there are 2^n sets A that may be in contact, each with an inverse R_AA^-1 that does not
depend on the motion: it is computed where it is first met, and looked up from then on. Samples
whose sets do not settle in a few rounds are left to `complementary`. The forces are unique, so
that it does not matter how their sets were found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.complementary import ROUND_OFF, complementary
from fenics_nnm.mechanics.set_flexibility import SetFlexibility

#: With more points than this the table is too large.
_MOST = 10

#: A flexibility whose eigenvalues are further apart than this is not inverted.
_APART = 1e8

#: Rounds in which points change sides all at once before `complementary` takes over.
_ROUNDS = 4


@dataclass(frozen=True, slots=True, eq=False)
class FewPoints:
    """A flexibility and the inverses of its parts that were met so far.

    Attributes:
        R: Flexibility, symmetric positive definite, shape (n_c, n_c).
        inverse: R_AA^-1 of each set A, 0 outside of it, by the number of the set: the sum of 2^c
            over its points c; shape (2^n_c, n_c, n_c).
        known: Which of them were computed, shape (2^n_c,).
        places: 2^c, shape (n_c,).
        stiffest: Largest flexibility of a point.
    """

    R: Array
    inverse: Array
    known: Mask
    places: Indices
    stiffest: float

    @classmethod
    def of(cls, R: Array) -> FewPoints:
        """Nothing known yet."""
        count = len(R)
        known = np.zeros(2**count, dtype=bool)
        known[0] = True  # no point in contact
        inverse = np.zeros((2**count, count, count))
        return cls(R, inverse, known, 2 ** np.arange(count), float(np.diagonal(R).max()))

    @staticmethod
    def suits(R: Array) -> bool:
        """Whether a flexibility is that of few points, and far from singular."""
        if not 0 < len(R) <= _MOST:
            return False
        values = np.linalg.eigvalsh(R)
        return bool(values[0] * _APART > values[-1])

    def about(self, excess: Array) -> FewPoints:
        """This: all points take part."""
        return self

    def known_of(self, R: Array) -> FewPoints | None:
        """This, if it is of this very array."""
        return self if R is self.R else None

    def light(self) -> FewPoints:
        """This: the table belongs to the law."""
        return self

    def blocks(self, points: Indices, used: Mask) -> Array:
        """Rows and columns of R at points of shape (s, k), a multiple of 1 where not `used`."""
        return SetFlexibility(self.R).blocks(points, used)

    def stiffness(self, sets: Mask, shapes: Array) -> Array:
        """Phi_A^T R_AA^-1 Phi_A for sets A, shape (s, n_c), and Phi, shape (n_c, J): (s, J, J)."""
        numbers, own = np.unique(sets @ self.places, return_inverse=True)
        return np.asarray((shapes.T @ self._inverses(numbers) @ shapes)[own])

    def forces(self, excess: Array, guess: Mask | None = None) -> tuple[Array, FewPoints]:
        """Forces lambda at s samples, shape (s, n_c), and this.

        Args:
            excess: e, shape (s, n_c).
            guess: Points that may be in contact, shape (s, n_c), if known.
        """
        force, active, wrong = self._round(excess, excess > 0 if guess is None else guess)
        pending = np.flatnonzero(wrong)
        for _ in range(_ROUNDS - 1):
            if not pending.size:
                return force, self
            force[pending], active, wrong = self._round(excess[pending], active[wrong])
            pending = pending[wrong]
        if pending.size:
            flexibility = SetFlexibility(self.R)
            force[pending], _ = complementary(flexibility, excess[pending], active[wrong])
        return force, self

    def _round(self, excess: Array, active: Mask) -> tuple[Array, Mask, Mask]:
        """Forces of sets, shape (s, n_c), cut off at 0; better sets; where they are wrong, (s,).

        Sets are right if their forces obey all conditions to round-off, as in `complementary`.
        """
        inverse = self._inverses(active @ self.places)
        force = np.einsum("sij,sj->si", inverse, excess)
        force += np.einsum("sij,sj->si", inverse, excess - force @ self.R)  # to round-off
        force = np.maximum(force, 0.0)
        opening = force @ self.R - excess
        size = np.abs(excess).max(axis=1) + self.stiffest * force.sum(axis=1)
        nothing = (ROUND_OFF * size)[:, None]
        touching, closing = force > 0, opening < -nothing
        wrong = (closing | (touching & (opening > nothing))).any(axis=1)
        return force, touching | closing, wrong

    def _inverses(self, numbers: Indices) -> Array:
        """Inverses of the sets of some numbers, shape (s, n_c, n_c)."""
        if not self.known[numbers].all():
            for number in np.unique(numbers[~self.known[numbers]]):
                self._invert(int(number))
        return self.inverse[numbers]

    def _invert(self, number: int) -> None:
        points = np.flatnonzero(self.places & number)
        part = np.ix_(points, points)
        self.inverse[number][part] = np.linalg.inv(self.R[part])
        self.known[number] = True
