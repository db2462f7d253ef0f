"""Contact law of the augmented Lagrangian: a spring with a shifted origin at each sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.contact_law import ContactForces, compressed


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
        active = force > 0
        samples = np.flatnonzero(active.any(axis=1))
        points, used = compressed(active[samples])
        stiffness = np.take_along_axis(np.broadcast_to(self.kappa, force.shape)[samples], points, 1)
        flexibility = np.where(used, 1 / np.where(used, stiffness, 1.0), 1.0)
        return ContactForces(
            force, samples, points, used, flexibility[:, :, None] * np.eye(points.shape[1])
        )
