"""Contact laws: from displacements at the time samples to contact forces and their derivative.

A law treats all samples at once. Its derivative is block-diagonal over the samples and touches
only the points in contact, so it is kept as one small matrix a sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

from fenics_nnm.arrays import Array, Indices

_ACTIVE_SET_ROUNDS = 30


@dataclass(frozen=True, slots=True)
class ContactForces:
    """Contact forces at s samples and their derivative by the free displacement Phi q.

    Attributes:
        force: lambda >= 0, shape (s, n_c).
        samples: Indices of the samples with contact, shape (s_a,).
        points: Indices of the points in contact at each of these, padded, shape (s_a, k).
        used: Which of them are no padding, shape (s_a, k).
        flexibility: d (Phi q) / d lambda among these points, a multiple of the identity in the
            padding, shape (s_a, k, k).
    """

    force: Array
    samples: Indices
    points: Indices
    used: NDArray[np.bool_]
    flexibility: Array

    @classmethod
    def alone(cls, force: Array) -> ContactForces:
        """Forces without their derivative."""
        nothing = np.empty((0, 0), dtype=np.int64)
        return cls(force, nothing.ravel(), nothing, nothing > 0, np.empty((0, 0, 0)))

    def assert_complete(self) -> None:
        """Refuse forces that were kept without their derivative: it would be taken for zero.

        Raises:
            ValueError: if there is none.
        """
        if not self.samples.size and self.force.any():
            raise ValueError("contact forces without their derivative")

    @property
    def slope(self) -> Array:
        """D lambda / d (Phi q) among the points in contact, 0 in the padding, (s_a, k, k)."""
        self.assert_complete()
        return np.linalg.inv(self.flexibility) * (self.used[:, :, None] & self.used[:, None, :])

    def change(self, moved: Array) -> Array:
        """Change of the forces under small changes of Phi q, both of shape (s, n_c)."""
        local = np.take_along_axis(moved[self.samples], self.points, 1)
        touching = np.zeros((len(self.samples), moved.shape[1]))
        held = np.einsum("skl,sl->sk", self.slope, local)
        np.put_along_axis(touching, self.points, held, 1)
        change = np.zeros_like(moved)
        change[self.samples] = touching
        return change


class ContactLaw(Protocol):
    """What the harmonic equations ask of a law."""

    def __call__(
        self, free_displacement: Array, near: ContactForces | None = None
    ) -> ContactForces:
        """Forces that belong to free displacements Phi q of shape (s, n_c).

        Args:
            free_displacement: Phi q.
            near: Forces of a motion nearby, which may help to find them sooner.
        """


@dataclass(frozen=True, slots=True)
class Complementarity:
    """Signorini's conditions at each sample, exactly, for contact points without mass.

    At every sample lambda solves the linear complementarity problem

        0 <= lambda   _|_   R lambda - (Phi q - gap) >= 0

    with R symmetric positive definite: primal-dual active set for all samples at once, and
    non-negative least squares, which always ends, for samples where the set cycles.

    Attributes:
        R: Residual flexibility, shape (n_c, n_c).
        gap: Gaps, shape (n_c,).
    """

    R: Array
    gap: Array

    def __call__(
        self, free_displacement: Array, near: ContactForces | None = None
    ) -> ContactForces:
        """Forces and derivative at free displacements Phi q of shape (s, n_c).

        Args:
            free_displacement: Phi q.
            near: Forces of a motion nearby: their points in contact are tried first.
        """
        excess = free_displacement - self.gap
        pushed = excess > 0
        pending = np.flatnonzero(pushed.any(axis=1))
        force = np.zeros_like(excess)
        active = pushed if near is None else near.force > 0
        for _ in range(_ACTIVE_SET_ROUNDS):
            if not pending.size:
                break
            chosen, at = active[pending], excess[pending]
            found = _solve_on(self.R, at, chosen)
            updated = np.where(chosen, found > 0, at - found @ self.R > 0)
            force[pending], active[pending] = found, updated
            pending = pending[(updated != chosen).any(axis=1)]
        for sample in pending:
            chosen = _least_squares_active_set(self.R, excess[sample])[None]
            force[sample] = np.maximum(_solve_on(self.R, excess[[sample]], chosen), 0.0)
        return self._with_flexibility(force)

    def _with_flexibility(self, force: Array) -> ContactForces:
        active = force > 0
        samples = np.flatnonzero(active.any(axis=1))
        points, used = compressed(active[samples])
        return ContactForces(force, samples, points, used, _submatrices(self.R, points, used))


def compressed(active: NDArray[np.bool_]) -> tuple[Indices, NDArray[np.bool_]]:
    """Indices of the active points of each row, active ones first, and which are no padding."""
    width = int(active.sum(axis=1).max(initial=0))
    points = np.argsort(~active, axis=1, kind="stable")[:, :width]
    return points, np.take_along_axis(active, points, 1)


def _submatrices(R: Array, points: Indices, used: NDArray[np.bool_]) -> Array:
    """Rows and columns `points` of R for each sample, the identity in the padding."""
    both = used[:, :, None] & used[:, None, :]
    blocks = R[points[:, :, None], points[:, None, :]]
    return np.where(both, blocks, np.eye(points.shape[1]) * np.abs(R).max())


def _solve_on(R: Array, excess: Array, active: NDArray[np.bool_]) -> Array:
    """Forces that close the gap exactly at the active points of each sample."""
    points, used = compressed(active)
    local = np.where(used, np.take_along_axis(excess, points, 1), 0.0)
    solved = np.linalg.solve(_submatrices(R, points, used), local[:, :, None])[:, :, 0]
    force = np.zeros_like(excess)
    np.put_along_axis(force, points, np.where(used, solved, 0.0), 1)
    return force


def _least_squares_active_set(R: Array, excess: Array) -> NDArray[np.bool_]:
    """Active set of min 1/2 lambda R lambda - lambda excess over lambda >= 0."""
    factor = cholesky(R, lower=True)
    force, _ = nnls(factor.T, solve_triangular(factor, excess, lower=True))
    return force > 0
