"""Reduced models of any size that move like a blade tip above a flat casing.

Contact points lie at s in [0, 1] along a tip. The followed mode moves all of it alike, mode j as
cos((j - 1) pi s); frequencies are those of a beam that is stiff against shear, roughly evenly
spaced and without integer ratios. R is that of an elastic half-plane edge: it falls off with the
distance, is the stiffer the more points share a force, and positive definite (exponential kernel).
"""

from __future__ import annotations

import numpy as np

from fenics_nnm.mechanics.model import ReducedModel

#: Total flexibility of the tip over that of the followed mode, and length of its decay.
_FLEXIBILITY, _DECAY = 2.0, 0.15

#: The gap grows by this part from the middle of the tip to its ends.
_CROWN = 0.3


def blade_tip(modes: int, points: int) -> ReducedModel:
    """The model of J modes and n_c contact points, dimensionless.

    Args:
        modes: Number of modes J.
        points: Number of contact points n_c.
    """
    s = (np.arange(points) + 0.5) / points
    order = np.arange(modes)
    distance = np.abs(s[:, None] - s)
    return ReducedModel(
        omega=np.sqrt(1 + (1.7321 * order) ** 2),
        Phi=np.cos(np.pi * order * s[:, None]) * np.where(order == 0, 1.0, 0.7),
        R=_FLEXIBILITY * np.exp(-distance / _DECAY),
        gap=1 + _CROWN * (2 * s - 1) ** 2,
    )
