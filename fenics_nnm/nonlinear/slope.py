"""How the frequency of a branch changes with its energy, at one of its points."""

from __future__ import annotations

import numpy as np

from fenics_nnm.nonlinear.contact_law import Complementarity
from fenics_nnm.nonlinear.mode import HarmonicEquations
from fenics_nnm.nonlinear.newton import (
    FixedEnergy,
    Solution,
    Unknowns,
    bordered_jacobian,
    phase_row,
)


def frequency_slope(equations: HarmonicEquations, solution: Solution) -> float:
    """Slope d ln omega / d ln gamma of the branch; nan at folds, and where forces have no slope.

    At full order it is that of the explicit modes.

    Args:
        equations: Harmonic equations of a reduced model.
        solution: A motion, with the slopes of its forces.
    """
    if not isinstance(equations.law, Complementarity):
        return float("nan")
    q, omega = solution.q, solution.omega
    at_energy = FixedEnergy(equations.gamma(q, omega))
    matrix = bordered_jacobian(
        equations, at_energy, Unknowns(q, omega), solution.forces, phase_row(equations, q)
    )
    right = np.zeros(len(matrix))
    right[q.size] = 1.0  # gamma over its value, less 1
    try:
        return float(np.linalg.solve(matrix, right)[q.size]) / omega
    except np.linalg.LinAlgError:
        return float("nan")
