"""One linearised step from a motion to the one of richer equations, at the same gamma."""

from __future__ import annotations

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import FixedEnergy, Unknowns, bordered_solution, phase_row


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
    constraint = FixedEnergy(gamma)
    step = bordered_solution(
        equations, constraint, at, forces, phase, left_out, gamma_left_out / gamma
    )
    return None if step is None else Unknowns(-step.q, -step.omega)
