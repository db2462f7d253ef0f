"""Contact laws: from displacements at the time samples to contact forces and their derivative.

A law treats all samples at once. Its derivative is block-diagonal over the samples and touches
only the points in contact, so it is one small matrix a sample, made where it is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.few_points import FewPoints
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.instants import SAMPLES, Instants
from fenics_nnm.mechanics.near_contact import NearContact
from fenics_nnm.mechanics.nested_factor import compressed
from fenics_nnm.mechanics.sampled_tangent import sampled_tangent


class LocalFlexibility(Protocol):
    """d (Phi q) / d lambda among the points in contact at s_a samples."""

    def blocks(self, points: Indices, used: Mask) -> Array:
        """It at points of shape (s_a, k), a multiple of the identity where not `used`."""

    def stiffness(self, sets: Mask, shapes: Array) -> Array:
        """Phi_A^T F_AA^-1 Phi_A for sets A, shape (s_a, n_c), and shapes Phi, shape (n_c, J)."""

    def known_of(self, R: Array) -> KnownFlexibility | None:
        """What is known of the flexibility R already, or nothing."""

    def light(self) -> LocalFlexibility:
        """The same without what can be computed again."""


class KnownFlexibility(LocalFlexibility, Protocol):
    """A flexibility of points without mass, with what is known of it already."""

    def about(self, excess: Array) -> KnownFlexibility:
        """It for displacements beyond the gaps of shape (s, n_c)."""

    def forces(self, excess: Array, guess: Mask | None = None) -> tuple[Array, KnownFlexibility]:
        """Forces lambda at s samples, shape (s, n_c), and what is known then.

        Args:
            excess: e, shape (s, n_c).
            guess: Points that may be in contact, shape (s, n_c), if known.

        Raises:
            numpy.linalg.LinAlgError: if R is singular to round-off.
        """


@dataclass(frozen=True, slots=True)
class ContactForces:
    """Contact forces at s samples and their derivative by the free displacement Phi q.

    Attributes:
        force: lambda >= 0, shape (s, n_c).
        samples: Indices of the samples with contact, shape (s_a,).
        points: Indices of the points in contact at each of these, padded, shape (s_a, k).
        used: Which of them are no padding, shape (s_a, k).
        local: What d (Phi q) / d lambda follows from; None without contact, or if it is not kept.
        instants: When the samples are.
    """

    force: Array
    samples: Indices
    points: Indices
    used: Mask
    local: LocalFlexibility | None
    instants: Instants = SAMPLES

    @classmethod
    def alone(cls, force: Array) -> ContactForces:
        """Forces without their derivative."""
        nothing = np.empty((0, 0), dtype=np.int64)
        return cls(force, nothing.ravel(), nothing, nothing > 0, None)

    @classmethod
    def of(cls, force: Array, local: LocalFlexibility) -> ContactForces:
        """Forces with their derivative."""
        active = force > 0
        samples = np.flatnonzero(active.any(axis=1))
        points, used = compressed(active[samples])
        return cls(force, samples, points, used, local)

    def light(self) -> ContactForces:
        """The same without factors, which are computed again when they are asked for."""
        return replace(self, local=self.local.light()) if self.local else self

    def assert_complete(self) -> None:
        """Refuse forces that were kept without their derivative: it would be taken for zero.

        Raises:
            ValueError: if there is none.
        """
        if not self.samples.size and self.force.any():
            raise ValueError("contact forces without their derivative")

    @property
    def flexibility(self) -> Array:
        """D (Phi q) / d lambda among the points in contact, (s_a, k, k).

        In the padding it is a multiple of the identity.
        """
        self.assert_complete()
        if self.local is None:
            return np.empty((0, 0, 0))
        return self.local.blocks(self.points, self.used)

    @property
    def slope(self) -> Array:
        """D lambda / d (Phi q) among the points in contact, 0 in the padding, (s_a, k, k)."""
        return np.linalg.inv(self.flexibility) * (self.used[:, :, None] & self.used[:, None, :])

    def stiffness(self, shapes: Array) -> Array:
        """Phi^T (d lambda / d (Phi q)) Phi at the samples with contact, shape (s_a, J, J).

        Args:
            shapes: Phi, shape (n_c, J).
        """
        self.assert_complete()
        if self.local is None:
            return np.zeros((0, shapes.shape[1], shapes.shape[1]))
        return self.local.stiffness(self.force[self.samples] > 0, shapes)

    def tangent(self, series: Series, shapes: Array) -> Array:
        """Derivative of the harmonics of Phi^T lambda by q, shape (c J, c J), by (n, j).

        It is sum_k A_nk C_kn' (Phi^T D_k Phi) over the samples k in contact.

        Args:
            series: Series in time.
            shapes: Phi, shape (n_c, J).
        """
        at = self.samples
        analysis, synthesis = self.instants.analysis(series), self.instants.synthesis(series)
        return sampled_tangent(analysis[:, at], synthesis[at], self.stiffness(shapes))

    def harmonics(self, series: Series) -> Array:
        """Harmonics of the forces, shape (c, n_c)."""
        return np.asarray(self.instants.analysis(series) @ self.force)

    def harmonic_tangent(self, series: Series) -> Array:
        """Derivatives of lambda_n by harmonics of Phi q, shape (c, n_c, c, n_c)."""
        at, points = self.samples, self.force.shape[1]
        dense = np.zeros((len(at), points, points))
        index = np.arange(len(at))[:, None, None]
        dense[index, self.points[:, :, None], self.points[:, None, :]] = self.slope
        rows = len(series.order)
        analysis, synthesis = self.instants.analysis(series), self.instants.synthesis(series)
        mixing = analysis[:, None, at] * synthesis.T[None, :, at]
        coupled = mixing.reshape(rows * rows, len(at)) @ dense.reshape(len(at), points**2)
        return coupled.reshape(rows, rows, points, points).swapaxes(1, 2)

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

    with R symmetric positive definite; see `complementary`.

    Attributes:
        R: Residual flexibility, shape (n_c, n_c).
        gap: Gaps, shape (n_c,).
        flexibility: R with what is known of it at first.
    """

    R: Array
    gap: Array
    flexibility: KnownFlexibility = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        few = FewPoints.suits(self.R)
        flexibility = FewPoints.of(self.R) if few else NearContact.whole(self.R)
        object.__setattr__(self, "flexibility", flexibility)

    def __call__(
        self, free_displacement: Array, near: ContactForces | None = None
    ) -> ContactForces:
        """Forces and derivative at free displacements Phi q of shape (s, n_c).

        Args:
            free_displacement: Phi q.
            near: Forces of a motion nearby: their points in contact are tried first.

        Raises:
            numpy.linalg.LinAlgError: if R is singular to round-off.
        """
        excess = free_displacement - self.gap
        force = np.zeros_like(excess)
        pushed = np.flatnonzero((excess > 0).any(axis=1))
        if not pushed.size:
            return ContactForces.alone(force)
        guess = None if near is None else near.force[pushed] > 0
        known = near.local.known_of(self.R) if near is not None and near.local else None
        flexibility = known or self.flexibility.about(excess[pushed])
        force[pushed], flexibility = flexibility.forces(excess[pushed], guess)
        return ContactForces.of(force, flexibility)
