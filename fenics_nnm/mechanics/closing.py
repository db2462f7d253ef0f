r"""How contact points close with the coordinates: linear, or with a quadratic part.

    p_c = Phi_c q + 1/2 q^T Theta_c q,      w = p - R lambda,

so that forces act on the coordinates by (Phi + Theta q)^T lambda. The quadratic part is added to
what the linear part gives, so that a linear closing adds nothing and costs nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.fourier import FourierSeries, Series, doubled
from fenics_nnm.mechanics.sampled_tangent import sampled_tangent, tangent_of_few
from fenics_nnm.mechanics.tangent_by_sets import tangent_by_sets

#: A series, and coefficients in it of the displacement of contact points, shape (c, n_c).
Curved = tuple[FourierSeries, Array]


class Closing(Protocol):
    """What a quadratic part of the closing adds."""

    def displaced(self, linear: Array, basis: Array, q: Array) -> Array:
        """Displacement p at phases, shape (s, n_c).

        Args:
            linear: Linear part Phi q there, shape (s, n_c).
            basis: Basis functions there, shape (s, c).
            q: Coefficients of the motion, shape (c, J).
        """

    def displacement_rates(self, linear: Array, basis: Array, rate: Array, q: Array) -> Array:
        """Derivatives of p by the phase from those of the linear part, shape (s, n_c).

        Args:
            linear: Those of Phi q, shape (s, n_c).
            basis: Basis functions, shape (s, c).
            rate: Their derivatives, shape (s, c).
            q: Coefficients of the motion, shape (c, J).
        """

    def pushed(self, linear: Array, series: Series, q: Array, forces: ContactForces) -> Array:
        """Harmonics of (Phi + Theta q)^T lambda from those of Phi^T lambda, shape (c, J).

        Args:
            linear: Harmonics of Phi^T lambda, shape (c, J).
            series: Series in time.
            q: Coefficients of the motion, shape (c, J).
            forces: Contact forces at their instants.
        """

    def free_motion(self, series: FourierSeries, q: Array, linear: Array) -> Curved:
        """Harmonics of p from those of its linear part, in a series that has them all.

        Args:
            series: Series in time.
            q: Coefficients of the motion, shape (c, J).
            linear: Those of Phi q, shape (c, n_c).
        """

    def tangent(self, series: Series, Phi: Array, q: Array, forces: ContactForces) -> Array:
        """Derivative of `pushed` by q, shape (c J, c J), by (n, j)."""

    def timed_tangent(self, series: Series, Phi: Array, q: Array, forces: ContactForces) -> Array:
        """The same where few sets of points are in contact in turn."""

    def turned_pairs(self, series: Series, q: Array, forces: ContactForces) -> Array:
        """Theta q of the pairs of samples and points in contact, shape (P, k)."""

    def bent_tangent(self, series: Series, q: Array, forces: ContactForces) -> Array:
        """Part of `tangent` with lambda . Theta, among the masters, shape (c, k, c, k)."""

    def mean_bending_work(self, series: Series, q: Array, forces: ContactForces) -> float:
        """Mean over the period of 1/2 q^T (lambda . Theta) q, in J."""

    def curvatures(self, points: int) -> Array:
        """Theta of so many contact points, shape (n_c, k, k)."""

    def shapes_at(self, Phi: Array, q: Array) -> Array:
        """Phi + Theta q at coordinates of shape (.., J), shape (.., n_c, J)."""

    def stiffened(self, linear: Array, force: Array) -> Array:
        """Stiffnesses of shape (.., J, J), and lambda . Theta of forces of shape (.., n_c)."""


class LinearClosing:
    """Nothing is added."""

    __slots__ = ()

    def displaced(self, linear: Array, basis: Array, q: Array) -> Array:
        """The linear part."""
        return linear

    def displacement_rates(self, linear: Array, basis: Array, rate: Array, q: Array) -> Array:
        """The linear part."""
        return linear

    def pushed(self, linear: Array, series: Series, q: Array, forces: ContactForces) -> Array:
        """The linear part."""
        return linear

    def free_motion(self, series: FourierSeries, q: Array, linear: Array) -> Curved:
        """The linear part, in the series itself."""
        return series, linear

    def tangent(self, series: Series, Phi: Array, q: Array, forces: ContactForces) -> Array:
        """That of the forces alone."""
        return forces.tangent(series, Phi)

    def timed_tangent(self, series: Series, Phi: Array, q: Array, forces: ContactForces) -> Array:
        """That of the forces alone."""
        return tangent_by_sets(series, Phi, forces)

    def turned_pairs(self, series: Series, q: Array, forces: ContactForces) -> Array:
        """There are no masters."""
        return np.zeros((np.count_nonzero(forces.used), 0))

    def bent_tangent(self, series: Series, q: Array, forces: ContactForces) -> Array:
        """There are no masters."""
        return np.zeros((len(q), 0, len(q), 0))

    def mean_bending_work(self, series: Series, q: Array, forces: ContactForces) -> float:
        """None."""
        return 0.0

    def curvatures(self, points: int) -> Array:
        """There are no masters."""
        return np.zeros((points, 0, 0))

    def shapes_at(self, Phi: Array, q: Array) -> Array:
        """Phi."""
        return np.broadcast_to(Phi, (*q.shape[:-1], *Phi.shape))

    def stiffened(self, linear: Array, force: Array) -> Array:
        """The stiffness."""
        return linear


LINEAR_CLOSING = LinearClosing()


@dataclass(frozen=True, slots=True)
class QuadraticClosing:
    """1/2 q^T Theta q of some of the coordinates is added.

    Attributes:
        masters: Places of these coordinates, shape (k,).
        Theta: Shape (n_c, k, k), symmetric in the last two.
    """

    masters: Indices
    Theta: Array

    def displaced(self, linear: Array, basis: Array, q: Array) -> Array:
        """Displacement p at phases, shape (s, n_c)."""
        moved = basis @ q[:, self.masters]
        return np.asarray(linear + self._by_pairs(moved, moved) / 2)

    def displacement_rates(self, linear: Array, basis: Array, rate: Array, q: Array) -> Array:
        """Derivatives of p by the phase, shape (s, n_c)."""
        masters = q[:, self.masters]
        return np.asarray(linear + self._by_pairs(basis @ masters, rate @ masters))

    def pushed(self, linear: Array, series: Series, q: Array, forces: ContactForces) -> Array:
        """Harmonics of (Phi + Theta q)^T lambda, shape (c, J)."""
        force, instants = forces.force, forces.instants
        at = np.flatnonzero(force.any(axis=1))
        moved = instants.synthesis(series)[at] @ q[:, self.masters]
        whole, stiffness = linear.copy(), self._bent(force[at])
        whole[:, self.masters] += instants.analysis(series)[:, at] @ _times(stiffness, moved)
        return whole

    def free_motion(self, series: FourierSeries, q: Array, linear: Array) -> Curved:
        """Harmonics of p, of which it has twice as many as the motion."""
        finer = doubled(series)
        moved = finer.synthesis @ finer.fitted(q[:, self.masters])
        return finer, finer.fitted(linear) + finer.analysis @ (self._by_pairs(moved, moved) / 2)

    def tangent(self, series: Series, Phi: Array, q: Array, forces: ContactForces) -> Array:
        """Derivative of `pushed`: sum_k A_nk (Psi_k^T D_k Psi_k + lambda_k . Theta) S_kn'."""
        at, own, instants = forces.samples, self.masters, forces.instants
        analysis, synthesis = instants.analysis(series)[:, at], instants.synthesis(series)[at]
        stiffness = self._turned_stiffness(Phi, forces, synthesis @ q[:, own])
        stiffness[:, own[:, None], own] += self._bent(forces.force[at])
        return sampled_tangent(analysis, synthesis, stiffness)

    def timed_tangent(self, series: Series, Phi: Array, q: Array, forces: ContactForces) -> Array:
        """The same: where Phi + Theta q changes in time there is nothing to put together."""
        return self.tangent(series, Phi, q, forces)

    def _turned_stiffness(self, Phi: Array, forces: ContactForces, moved: Array) -> Array:
        """Psi^T D Psi with Psi = Phi + Theta q from that of the columns of Phi and Theta.

        Args:
            Phi: Shape (n_c, J).
            forces: Contact forces, in contact at s_a samples.
            moved: Masters there, shape (s_a, k).
        """
        modes, k, own = Phi.shape[1], len(self.masters), self.masters
        both = forces.stiffness(np.hstack([Phi, self.Theta.reshape(len(Phi), -1)]))
        stiffness = both[:, :modes, :modes].copy()
        turned = both[:, modes:].reshape(-1, k, k, modes + k**2).swapaxes(2, 3)
        turned = (turned @ moved[:, None, :, None])[..., 0]  # (Theta q)^T D of all columns
        stiffness[:, own] += turned[:, :, :modes]
        stiffness[:, :, own] += turned[:, :, :modes].swapaxes(1, 2)
        twice = turned[:, :, modes:].reshape(-1, k, k, k) @ moved[:, None, :, None]
        stiffness[:, own[:, None], own] += twice[..., 0]
        return stiffness

    def turned_pairs(self, series: Series, q: Array, forces: ContactForces) -> Array:
        """Theta q of the pairs of samples and points in contact, shape (P, k)."""
        sample = np.nonzero(forces.used)[0]
        moved = forces.instants.synthesis(series)[forces.samples] @ q[:, self.masters]
        return np.einsum("pjk,pk->pj", self.Theta[forces.points[forces.used]], moved[sample])

    def bent_tangent(self, series: Series, q: Array, forces: ContactForces) -> Array:
        """Part of `tangent` with lambda . Theta, among the masters, shape (c, k, c, k)."""
        at, instants = forces.samples, forces.instants
        analysis, synthesis = instants.analysis(series)[:, at], instants.synthesis(series)[at]
        return tangent_of_few(analysis, synthesis, self._bent(forces.force[at]))

    def mean_bending_work(self, series: Series, q: Array, forces: ContactForces) -> float:
        """Mean over the period of 1/2 q^T (lambda . Theta) q, in J."""
        moved = forces.instants.synthesis(series) @ q[:, self.masters]
        work = np.sum(forces.force * self._by_pairs(moved, moved), axis=1)
        return float(forces.instants.weight(series) @ work) / 2

    def curvatures(self, points: int) -> Array:
        """Theta."""
        return self.Theta

    def shapes_at(self, Phi: Array, q: Array) -> Array:
        """Phi + Theta q at coordinates of shape (.., J), shape (.., n_c, J)."""
        shapes = np.tile(Phi, (*q.shape[:-1], 1, 1))
        shapes[..., self.masters] += np.tensordot(q[..., self.masters], self.Theta, (-1, 1))
        return shapes

    def stiffened(self, linear: Array, force: Array) -> Array:
        """Stiffnesses of shape (.., J, J), and lambda . Theta of forces of shape (.., n_c)."""
        whole = linear.copy()
        whole[..., self.masters[:, None], self.masters] += self._bent(force)
        return whole

    def _bent(self, force: Array) -> Array:
        """Sums of Theta over forces of shape (.., n_c), shape (.., k, k)."""
        points, k = self.Theta.shape[:2]
        return (force @ self.Theta.reshape(points, k**2)).reshape(*force.shape[:-1], k, k)

    def _by_pairs(self, one: Array, other: Array) -> Array:
        """x^T Theta y of vectors (s, k), shape (s, n_c)."""
        pairs = (one[:, :, None] * other[:, None, :]).reshape(len(one), one.shape[1] ** 2)
        return np.asarray(pairs @ self.Theta.reshape(len(self.Theta), -1).T)


def _times(matrices: Array, vectors: Array) -> Array:
    """Products of matrices (s, k, k) and vectors (s, k), shape (s, k)."""
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])
