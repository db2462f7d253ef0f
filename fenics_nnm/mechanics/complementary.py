"""The linear complementarity problems of contact at the samples, by projected Newton steps.

    0 <= lambda   _|_   w = R lambda - e >= 0,      R symmetric positive definite,

are the conditions of the smallest 1/2 lambda^T R lambda - lambda^T e over lambda >= 0, whose
gradient is w. At each sample the points with lambda > 0 or w < 0 are taken to be in contact; the
forces that close them are the aim of a step, cut off at zero and halved until it lowers the energy
enough (Bertsekas, SIAM J. Control Optim. 20 (1982) 221). Where many steps do not end, points come
into contact one at a time and steps go to the first force that vanishes, which ends in any case
(Lawson, Hanson, Solving Least Squares Problems, 1974, ch. 23).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.set_flexibility import SetFlexibility

#: Openings count as zero to this part of the size of what they are differences of.
ROUND_OFF = 4e-15

#: A step lowers the energy by at least this part of what its first slope promises.
_ENOUGH = 1e-4

#: Steps are halved no further.
_SHORTEST = 2.0**-40

#: After so many steps points come into contact one at a time.
_TOGETHER = 50

#: Steps that are taken a point beyond these, unless R is singular to round-off.
_STEPS_PER_POINT = 10

#: With more points than this, a first guess comes from every other one.
_MANY = 48


def complementary(
    flexibility: SetFlexibility, excess: Array, guess: Mask | None = None
) -> tuple[Array, SetFlexibility]:
    """Forces lambda at s samples, shape (s, n_c), and R with a factor that suits them.

    Args:
        flexibility: R.
        excess: e, shape (s, n_c).
        guess: Points that may be in contact, shape (s, n_c), if known.

    Raises:
        numpy.linalg.LinAlgError: if R is singular to round-off.
    """
    active = first_guess(flexibility.R, excess) if guess is None else guess.copy()
    nothing = np.zeros_like(excess)
    search = _Search(flexibility, excess, active, force=nothing, opening=nothing.copy())
    search.run()
    return search.force, search.flexibility.suited(search.force > 0)


def first_guess(R: Array, excess: Array) -> Mask:
    """Points that may be in contact, shape (s, n_c).

    A step moves the rim of a patch of contact by little more than a point, so that many points are
    found from fewer: those in contact where every other point alone can touch, and what then lies
    beyond its gap.
    """
    if excess.shape[1] <= _MANY:
        return excess > 0
    every_other = SetFlexibility(np.ascontiguousarray(R[::2, ::2]))
    force, _ = complementary(every_other, excess[:, ::2])
    active = force @ R[::2] < excess
    active[:, ::2] = force > 0
    return active


@dataclass(slots=True)
class _Search:
    """Projected Newton steps at all samples together.

    Attributes:
        flexibility: R.
        excess: e, shape (s, n_c).
        active: Points taken to be in contact, shape (s, n_c).
        force: lambda >= 0, shape (s, n_c).
        opening: w, shape (s, n_c).
    """

    flexibility: SetFlexibility
    excess: Array
    active: Mask
    force: Array
    opening: Array

    def run(self) -> None:
        """Step until the forces obey all conditions to round-off."""
        pending: Indices = np.arange(len(self.excess))
        for step in range(_TOGETHER + _STEPS_PER_POINT * self.excess.shape[1]):
            if not pending.size:
                return
            aim = self._closing(pending)
            if step < _TOGETHER:
                whole = self._project(pending, aim, freely=not step)
            else:
                whole = self._go_to_zero(pending, aim)
            pending = self._still_pending(pending, whole, alone=max(step + 2 - _TOGETHER, 0))
        raise np.linalg.LinAlgError("contact forces are not determined to round-off")

    def _closing(self, pending: Indices) -> Array:
        """Forces that close the active points."""
        active = self.active[pending]
        self.flexibility = self.flexibility.suited(active)
        return self.flexibility.on(active).closing(self.excess[pending])

    def _project(self, pending: Indices, aim: Array, *, freely: bool) -> Mask:
        """Go towards an aim, cut off at zero: all the way, or until the energy is lower.

        Returns:
            At which samples the step was not shortened.
        """
        R, excess = self.flexibility.R, self.excess[pending]
        force = np.maximum(aim, 0.0)
        opening, whole = force @ R - excess, np.ones(len(pending), dtype=bool)
        if not freely:
            before, gradient = self.force[pending], self.opening[pending]
            left, fraction = whole.copy(), 1.0
            while True:
                change = force - before
                lowered = np.sum(change * (gradient + opening), axis=1) / 2
                left &= lowered > _ENOUGH * np.sum(change * gradient, axis=1)
                if not left.any() or fraction < _SHORTEST:
                    break
                fraction /= 2
                whole &= ~left
                halved = before[left] + fraction * (aim[left] - before[left])
                force[left] = np.maximum(halved, 0.0)
                opening[left] = force[left] @ R - excess[left]
        self.force[pending], self.opening[pending] = force, opening
        return whole

    def _go_to_zero(self, pending: Indices, aim: Array) -> Mask:
        """Go towards an aim until the first force is zero.

        Returns:
            At which samples none was.
        """
        before, pulled = self.force[pending], aim < 0
        until = np.where(pulled, before / np.where(pulled, before - aim, 1.0), 1.0)
        fraction = until.min(axis=1, keepdims=True)
        force = np.maximum(before + fraction * (aim - before), 0.0)
        force[pulled & (until == fraction)] = 0.0
        self.force[pending] = force
        self.opening[pending] = force @ self.flexibility.R - self.excess[pending]
        return np.asarray(fraction[:, 0] == 1)

    def _still_pending(self, pending: Indices, whole: Mask, *, alone: int) -> Indices:
        """The samples at which forces do not obey all conditions to round-off.

        There the points with w < 0 come into contact. From the first step on that is made `alone`
        it is the worst of them after a whole step, and the longer it takes, the more is round-off.
        """
        force, opening = self.force[pending], self.opening[pending]
        pushed = np.diagonal(self.flexibility.R).max() * force.sum(axis=1)
        size = np.abs(self.excess[pending]).max(axis=1) + pushed
        nothing = ROUND_OFF * (1 + alone) * size[:, None]
        touching, closing = force > 0, opening < -nothing
        wrong = (closing | (touching & (opening > nothing))).any(axis=1)
        if alone:
            closing &= (opening == opening.min(axis=1, keepdims=True)) & whole[:, None]
        self.active[pending] = touching | closing
        return pending[wrong]
