"""One linearised step from a motion to the one of richer equations, at the same gamma."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.contact_law import ContactForces
from fenics_nnm.nonlinear.mode import HarmonicEquations
from fenics_nnm.nonlinear.newton import FixedEnergy, Unknowns, bordered_jacobian, phase_row


def linear_step(
    equations: HarmonicEquations,
    at: Unknowns,
    forces: ContactForces,
    left_out: Array,
    *,
    gamma_left_out: float = 0.0,
) -> Unknowns | None:
    """The step that makes up for what equations lack; None where the Jacobian is singular.

    Args:
        equations: Harmonic equations whose Jacobian is taken.
        at: Motion to begin at; gamma stays as it is there.
        forces: Its contact forces.
        left_out: Terms that the motion should obey besides, shape of its coefficients.
        gamma_left_out: What gamma lacks.
    """
    q, omega = at.q, at.omega
    gamma = equations.gamma(q, omega)
    phase = phase_row(equations, q)
    matrix = bordered_jacobian(equations, FixedEnergy(gamma), at, forces, phase)
    right = np.append((left_out / equations.row_scale(omega)).ravel(), gamma_left_out / gamma)
    if equations.series.free_phase:
        right = np.append(right, 0.0)
    try:
        step = -np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return None
    return Unknowns(step[: q.size].reshape(q.shape), float(step[q.size]))
