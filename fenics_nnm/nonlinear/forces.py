"""Contact forces of a converged motion at any time, not only at its samples."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel


def contact_forces(model: ReducedModel, series: Series, point: BranchPoint, phase: Array) -> Array:
    """Contact forces in N at phases omega t, shape (len(phase), n_c).

    Where the contact points carry no mass the forces follow from the motion alone, by Signorini's
    conditions. Otherwise only their harmonics 0..N act on the motion, and these are given: those
    above are not determined.
    """
    if not model.massless:
        return np.asarray(series.basis_at(phase) @ (series.analysis @ point.force))
    law = Complementarity(model.R, model.gap)
    return law(series.basis_at(phase) @ point.free).force


def contact_force_rates(
    model: ReducedModel, series: Series, point: BranchPoint, phase: Array
) -> Array:
    """Derivatives of the contact forces by the phase in N, shape (len(phase), n_c).

    Without mass they follow from the slope of the contact law, and jump where a point comes into
    contact or leaves it.
    """
    if not model.massless:
        return np.asarray(series.rate_at(phase) @ (series.analysis @ point.force))
    law = Complementarity(model.R, model.gap)
    forces = law(series.basis_at(phase) @ point.free)
    return forces.change(series.rate_at(phase) @ point.free)
