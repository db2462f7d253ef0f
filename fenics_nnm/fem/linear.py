"""All that is linear of an analysis, in one record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.modes import LinearModes
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.massless import massless_model
from fenics_nnm.reduction.model import ReducedModel


@dataclass(frozen=True, slots=True)
class LinearAnalysis:
    """All that is linear: the body, its modes, its contact points and the reduced model.

    Attributes:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes; shapes are signed so that the contact point that moves most
            moves towards its obstacle.
        residual_shapes: Displacement per unit contact force that the modes do not bring, m/N,
            shape (n_owned, n_c): u = shapes q - residual_shapes lambda.
        model: Reduced model.
    """

    solid: Solid
    interface: ContactInterface
    modes: LinearModes
    residual_shapes: Array
    model: ReducedModel


def reduced(
    solid: Solid, interface: ContactInterface, modes: LinearModes, attachments: Array
) -> LinearAnalysis:
    """Massless-boundary model of a body, with signed mode shapes.

    Args:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes.
        attachments: Static displacements under unit contact forces, shape (n_owned, n_c).

    Raises:
        ModelError: if the body cannot be reduced with so many modes or points.
    """
    Phi = interface.displacement(modes.shapes)
    largest = Phi[np.argmax(np.abs(Phi), axis=0), np.arange(Phi.shape[1])]
    sign = np.where(largest < 0, -1.0, 1.0)
    shapes, Phi = modes.shapes * sign, Phi * sign
    S = interface.displacement(attachments)
    return LinearAnalysis(
        solid=solid,
        interface=interface,
        modes=LinearModes(modes.omega, shapes, modes.checked_below),
        residual_shapes=attachments - (shapes / modes.omega**2) @ Phi.T,
        model=massless_model(modes.omega, Phi, S, interface.gap),
    )
