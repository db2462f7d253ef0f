"""Reduced models of any size that move like a blade tip above a flat casing.

Contact points lie at s in [0, 1] along a tip. The followed mode moves all of it alike, mode j as
cos((j - 1) pi s); frequencies are those of a beam that is stiff against shear, roughly evenly
spaced and without integer ratios. R is that of an elastic half-plane edge: it falls off with the
distance, is the stiffer the more points share a force, and positive definite (exponential kernel).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder, symmetrised

#: Total flexibility of the tip over that of the followed mode, and length of its decay.
_FLEXIBILITY, _DECAY = 2.0, 0.15

#: Second order at the motion that just touches: of the closing, of the frequencies, of the inertia.
_CLOSES, _STIFFENS, _INERTIA = 0.1, 0.05, 0.02

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


def bent_tip(modes: int, points: int, masters: int) -> ReducedModel:
    """The same with second-order kinematics of the modes 1, 3 and so on, made up but consistent.

    A blade that bends gets shorter: motions to both sides lift the tip. Stiffness and inertia are
    random, symmetric and, in fourth order, positive. Mode 2 has twice the frequency of the first:
    nothing quadratic moves it.

    Args:
        modes: Number of modes J.
        points: Number of contact points n_c.
        masters: Number of masters k.
    """
    linear, random = blade_tip(modes, points), np.random.default_rng(37)
    lifted = random.standard_normal((points, masters, masters)) / 4 + 3 * np.eye(masters)
    lengths = random.standard_normal((3, masters, masters))
    lengths += lengths.transpose(0, 2, 1)
    pushed = random.standard_normal((modes, masters, masters))
    pushed += pushed.transpose(0, 2, 1)
    own = 2 * np.arange(masters)
    pushed[own] = symmetrised(pushed[own])
    pushed[1] = 0.0
    fourth = np.einsum("rij,rkl->ijkl", lengths, lengths)
    fourth /= fourth[0, 0, 0, 0]
    kinematics = SecondOrder(
        masters=own,
        Theta=-_CLOSES * (lifted + lifted.transpose(0, 2, 1)) / 3,
        alpha=_STIFFENS * pushed,
        beta=2 * _STIFFENS * symmetrised(fourth),
        D=2 * _INERTIA * fourth,
    )
    return replace(linear, kinematics=kinematics)
