"""One linearised step from a motion to the one of richer equations, at the same gamma."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.nonlinear.conditions import FixedEnergy, own_conditions
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import bordered_solution
from fenics_nnm.nonlinear.unknowns import Unknowns


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
    whole = at.completed(len(equations.parameters))
    gamma = equations.energy.gamma(whole)
    conditions = (FixedEnergy(gamma), *own_conditions(equations, at.q))
    violations = np.zeros(len(conditions))
    violations[0] = gamma_left_out / gamma
    step = bordered_solution(equations, conditions, whole, forces, left_out, violations)
    return None if step is None else step.times(-1.0)
