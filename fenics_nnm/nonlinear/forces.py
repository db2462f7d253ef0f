"""Contact forces of a converged motion at any time, not only at its samples."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.contact_law import Complementarity
from fenics_nnm.nonlinear.fourier import Series
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.reduction.model import ReducedModel


def contact_forces(model: ReducedModel, series: Series, point: BranchPoint, phase: Array) -> Array:
    """Contact forces in N at phases omega t, shape (len(phase), n_c).

    Where the contact points carry no mass the forces follow from q alone, by Signorini's
    conditions; otherwise they are known at the samples and linear between them.
    """
    if not model.massless:
        return series.interpolated(point.force, phase)
    law = Complementarity(model.R, model.gap)
    return law(series.basis_at(phase) @ point.q @ model.Phi.T).force


def contact_force_rates(
    model: ReducedModel, series: Series, point: BranchPoint, phase: Array
) -> Array:
    """Derivatives of the contact forces by the phase in N, shape (len(phase), n_c).

    Only for contact points without mass, from the slope of the contact law; it jumps where a
    point comes into contact or leaves it.
    """
    law = Complementarity(model.R, model.gap)
    forces = law(series.basis_at(phase) @ point.q @ model.Phi.T)
    free_rate = series.rate_at(phase) @ point.q @ model.Phi.T
    local = np.take_along_axis(free_rate[forces.samples], forces.points, 1)
    rows = np.zeros((len(forces.samples), model.points))
    np.put_along_axis(rows, forces.points, np.einsum("skl,sl->sk", forces.slope, local), 1)
    rates = np.zeros_like(forces.force)
    rates[forces.samples] = rows
    return rates
