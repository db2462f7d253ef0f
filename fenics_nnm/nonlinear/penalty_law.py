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

    def __call__(self, free_displacement: Array) -> ContactForces:
        """Forces and derivative at displacements Phi q of shape (s, n_c)."""
        shifted = free_displacement - self.gap + self.theta
        active = shifted > 0
        samples = np.flatnonzero(active.any(axis=1))
        points, used = compressed(active[samples])
        stiffness = np.where(used, np.take_along_axis(self.kappa[samples], points, 1), 0.0)
        return ContactForces(
            force=self.kappa * np.maximum(shifted, 0.0),
            samples=samples,
            points=points,
            slope=stiffness[:, :, None] * np.eye(points.shape[1]),
        )
