"""How the frequency of a branch changes with its energy, at one of its points."""

from __future__ import annotations

import numpy as np

from fenics_nnm.backbone.coarse import GRAZING_GAMMA, CoarseBranch
from fenics_nnm.backbone.levels import Level
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.linear_step import linear_step
from fenics_nnm.nonlinear.solution import Solution

#: A branch with a smaller slope d ln omega / d ln gamma is level.
_LEVEL = 1e-10

#: Below 1 + this gamma ratio a motion grazes: round-off decides whether a sample touches.
_GRAZES = 1e-8


def frequency_slope(equations: HarmonicEquations, solution: Solution) -> float:
    """Slope d ln omega / d ln gamma of the branch; nan at folds.

    At full order it is that of the explicit modes.

    Args:
        equations: Harmonic equations of a reduced model under complementarity.
        solution: A motion, with the slopes of its forces.
    """
    at = solution.at
    gamma = equations.energy.gamma(at)
    step = linear_step(equations, at, solution.forces, np.zeros_like(at.q), gamma_left_out=-gamma)
    return float("nan") if step is None else step.omega / at.omega


def slope_ratio(alone: CoarseBranch, finest: Level, solution: Solution) -> float:
    """Slope d omega / d gamma of a motion over that of the followed mode alone.

    Args:
        alone: The followed mode alone.
        finest: The finest level.
        solution: A motion of it.

    Returns:
        nan up to grazing, at folds, where the mode alone has no slope, and where forces have none.
    """
    rest, ratio = finest.equations.rest, solution.energies.gamma / GRAZING_GAMMA
    one_way = rest.closed.all() or not rest.pressed  # else it falls and rises
    coarse = alone.at(ratio) if ratio > 1 + _GRAZES and one_way else None
    if coarse is None or not alone.level.solver.knows_slopes or not finest.solver.knows_slopes:
        return float("nan")
    coarsest = alone.level.equations
    slope = frequency_slope(coarsest, coarse.completed(coarsest))
    if not abs(slope) > _LEVEL:
        return float("nan")
    return frequency_slope(finest.equations, solution) / slope
