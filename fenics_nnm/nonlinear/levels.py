"""Levels of truncation, coarse to fine: the way on to the main branch of a mode.

Modes whose frequency is a multiple of the followed one trap Newton's iteration and continuation
in energy. A model of the followed mode alone has no such mode, so its branch is smooth; each
further level adds modes and harmonics and starts from the solution of the level before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.nonlinear.augmented_lagrangian import (
    MultiplierLoop,
    first_law,
    solve_with_multipliers,
)
from fenics_nnm.nonlinear.contact_law import Complementarity
from fenics_nnm.nonlinear.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.nonlinear.mode import HarmonicEquations
from fenics_nnm.nonlinear.newton import FixedEnergy, Newton, Solution, solve
from fenics_nnm.reduction.model import ReducedModel

#: Modes and harmonics of the levels; the last one is what the study asks for.
LADDER = ((1, 2), (2, 2), (3, 3), (6, 4), (8, 5), (12, 8), (20, 10), (30, 15), (40, 20), (80, 40))


@dataclass(frozen=True, slots=True)
class Guess:
    """Where an iteration starts: motion (N + 1, J), frequency, contact forces (s, n_c)."""

    q: Array
    omega: float
    force: Array


@dataclass(frozen=True, slots=True)
class Level:
    """Harmonic equations on some of the modes of the full reduced model.

    Attributes:
        equations: Equations at this truncation.
        modes: Indices of its modes in the full model, ascending.
        total_modes: Number of modes of the full model.
        multipliers: How contact is found where the points carry mass, else None.
    """

    equations: HarmonicEquations
    modes: Indices
    total_modes: int
    multipliers: MultiplierLoop | None

    def solve(self, gamma: float, guess: Guess, newton: Newton) -> Solution:
        """Motion of given gamma, by the method that the model asks for."""
        if self.multipliers is None:
            target = FixedEnergy(gamma)
            return solve(self.equations, target, guess.q, guess.omega, options=newton)
        return solve_with_multipliers(
            self.equations,
            gamma,
            guess.q,
            guess.omega,
            guess.force,
            loop=self.multipliers,
            newton=newton,
        )

    def restricted(self, q: Array) -> Array:
        """Coefficients of this level from coefficients over all modes."""
        return self.equations.series.fitted(q)[:, self.modes]

    def extended(self, q: Array) -> Array:
        """Coefficients over all modes from coefficients of this level."""
        extended = np.zeros((len(q), self.total_modes))
        extended[:, self.modes] = q
        return extended


def levels(
    model: ReducedModel,
    *,
    mode: int,
    harmonics: int,
    samples: int,
    multipliers: MultiplierLoop | None = None,
    general: bool = False,
) -> tuple[Level, ...]:
    """Levels from the followed mode alone to all modes and harmonics of the study.

    Args:
        model: Full reduced model, dimensionless.
        mode: Index of the followed mode, from 0. It is part of every level.
        harmonics: Harmonics N of the finest level.
        samples: Time samples m a period, the same at every level.
        multipliers: How contact is found at the finest level of a model with R = 0. The levels
            below have R > 0 from the modes that they leave out, and use complementarity.
        general: Sines too, instead of the cosines of a time-reversible motion.
    """
    sizes = [size for size in LADDER if size[0] < model.modes or size[1] < harmonics]
    clipped = [(min(J, model.modes), min(N, harmonics)) for J, N in sizes]
    distinct = sorted({*clipped, (model.modes, harmonics)})
    parts = [(_part(model, mode, J), N) for J, N in distinct]
    loop = multipliers or MultiplierLoop()
    return tuple(
        _level(model, chosen, (FourierSeries if general else CosineSeries)(N, samples), loop)
        for chosen, N in parts
        if len(chosen) == model.modes or model.with_modes(chosen).massless
    )


def _part(model: ReducedModel, mode: int, count: int) -> Indices:
    others = [index for index in range(model.modes) if index != mode]
    return np.array(sorted([mode, *others[: count - 1]]))


def _level(model: ReducedModel, chosen: Indices, series: Series, loop: MultiplierLoop) -> Level:
    part = model.with_modes(chosen)
    if part.massless:
        law = Complementarity(part.R, part.gap)
        return Level(HarmonicEquations(part, series, law), chosen, model.modes, None)
    nothing = np.zeros((len(series.phase), part.points))
    equations = HarmonicEquations(part, series, first_law(part, loop, nothing))
    return Level(equations, chosen, model.modes, loop)
