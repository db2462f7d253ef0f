"""Levels of truncation, coarse to fine: the way on to the main branch of a mode.

Modes whose frequency is a multiple of the followed one trap Newton's iteration and continuation
in energy. A model of the followed mode alone has no such mode, so its branch is smooth; each
further level adds modes and harmonics and starts from the solution of the level before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.nonlinear.contact_law import Complementarity
from fenics_nnm.nonlinear.fourier import CosineSeries
from fenics_nnm.nonlinear.mode import HarmonicEquations
from fenics_nnm.reduction.model import ReducedModel

#: Modes and harmonics of the levels; the last one is what the study asks for.
LADDER = ((1, 2), (2, 2), (3, 3), (6, 4), (8, 5), (12, 8), (20, 10), (30, 15), (40, 20), (80, 40))


@dataclass(frozen=True, slots=True)
class Level:
    """Harmonic equations on some of the modes of the full reduced model.

    Attributes:
        equations: Equations at this truncation.
        modes: Indices of its modes in the full model, ascending.
        total_modes: Number of modes of the full model.
    """

    equations: HarmonicEquations
    modes: Indices
    total_modes: int

    def restricted(self, q: Array) -> Array:
        """Coefficients of this level from coefficients over all modes."""
        return self.equations.series.fitted(q)[:, self.modes]

    def extended(self, q: Array) -> Array:
        """Coefficients over all modes from coefficients of this level."""
        extended = np.zeros((len(q), self.total_modes))
        extended[:, self.modes] = q
        return extended


def levels(model: ReducedModel, *, mode: int, harmonics: int, samples: int) -> tuple[Level, ...]:
    """Levels from the followed mode alone to all modes and harmonics of the study.

    Args:
        model: Full reduced model, dimensionless.
        mode: Index of the followed mode, from 0. It is part of every level.
        harmonics: Harmonics N of the finest level.
        samples: Time samples m a period, the same at every level.
    """
    sizes = [size for size in LADDER if size[0] < model.modes or size[1] < harmonics]
    clipped = [(min(J, model.modes), min(N, harmonics)) for J, N in sizes]
    distinct = sorted({*clipped, (model.modes, harmonics)})
    return tuple(_level(model, mode, J, N, samples) for J, N in distinct)


def _level(model: ReducedModel, mode: int, count: int, harmonics: int, samples: int) -> Level:
    others = [index for index in range(model.modes) if index != mode]
    chosen = np.array(sorted([mode, *others[: count - 1]]))
    part = model.with_modes(chosen)
    equations = HarmonicEquations(
        part, CosineSeries(harmonics, samples), Complementarity(part.R, part.gap)
    )
    return Level(equations, chosen, model.modes)
