"""Contact law of the augmented Lagrangian: a spring with a shifted origin at each sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.contact_law import ContactForces, KnownFlexibility


@dataclass(frozen=True, slots=True)
class Springs:
    """Flexibility of springs at the contact points.

    Attributes:
        kappa: Their stiffnesses at the samples with contact, shape (s_a, n_c).
    """

    kappa: Array

    def blocks(self, points: Indices, used: Mask) -> Array:
        """Diagonal matrices of 1 / kappa at points of shape (s_a, k), 1 where not `used`."""
        held = np.take_along_axis(self.kappa, points, 1)
        flexibility = np.where(used, 1 / np.where(used, held, 1.0), 1.0)
        return flexibility[:, :, None] * np.eye(points.shape[1])

    def stiffness(self, sets: Mask, shapes: Array) -> Array:
        """Phi_A^T kappa Phi_A for sets A, shape (s_a, n_c), and shapes Phi, shape (n_c, J)."""
        return (shapes.T * np.where(sets, self.kappa, 0.0)[:, None, :]) @ shapes

    def light(self) -> Springs:
        """This: springs are all there is."""
        return self

    def known_of(self, R: Array) -> KnownFlexibility | None:
        """Nothing: springs know only themselves."""
        return None


@dataclass(frozen=True, slots=True)
class AugmentedLagrangian:
    """lambda = kappa (g + theta)_+ with g = w - gap, at each sample and contact point.

    With theta = 0 it is a penalty law. The multipliers theta carry the force as the penetration
    goes to zero (Laxalde and Legrand 2011, Eq. 20). For models without residual flexibility.

    Attributes:
        gap: Gaps, shape (n_c,).
        kappa: Penalties, shape (s, n_c).
        theta: Multipliers, a length, shape (s, n_c).
    """

    gap: Array
    kappa: Array
    theta: Array

    def __call__(
        self, free_displacement: Array, near: ContactForces | None = None
    ) -> ContactForces:
        """Forces and derivative at displacements Phi q of shape (s, n_c); needs no forces near."""
        shifted = free_displacement - self.gap + self.theta
        force = self.kappa * np.maximum(shifted, 0.0)
        samples = np.flatnonzero((force > 0).any(axis=1))
        stiffness = np.broadcast_to(self.kappa, force.shape)[samples]
        return ContactForces.of(force, Springs(stiffness))
