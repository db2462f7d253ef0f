"""How the frequency of a branch changes with its energy, at one of its points."""

from __future__ import annotations

import numpy as np

from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.linear_step import linear_step
from fenics_nnm.nonlinear.solution import Solution


def frequency_slope(equations: HarmonicEquations, solution: Solution) -> float:
    """Slope d ln omega / d ln gamma of the branch; nan at folds, and where forces have no slope.

    At full order it is that of the explicit modes.

    Args:
        equations: Harmonic equations of a reduced model.
        solution: A motion, with the slopes of its forces.
    """
    if not isinstance(equations.law, Complementarity):
        return float("nan")
    at = solution.at
    gamma = equations.energy.gamma(at)
    step = linear_step(equations, at, solution.forces, np.zeros_like(at.q), gamma_left_out=-gamma)
    return float("nan") if step is None else step.omega / at.omega
