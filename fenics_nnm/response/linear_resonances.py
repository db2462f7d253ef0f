"""Phase resonances of a driven structure as long as nothing touches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.resonant import ResonantEquations
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.response.structure import DrivenStructure

#: Frequencies beside a natural one are looked at down to this power of a half of it.
_CLOSEST = 14


@dataclass(frozen=True, slots=True)
class LinearResonance:
    """A motion whose force is in phase with the velocity.

    Attributes:
        omega: Circular frequency in rad/s.
        q: Coefficients at level 1, as if there were no obstacles, shape (c, J).
        grazing: Level at which the first gap is closed; inf if none ever is.
    """

    omega: float
    q: Array
    grazing: float

    def at_level(self, level: float) -> Unknowns:
        """The motion at a level."""
        return Unknowns.of(level * self.q, self.omega, level)


def linear_resonances(
    structure: DrivenStructure, equations: ResonantEquations, frequencies: Array
) -> Iterator[LinearResonance]:
    """Phase resonances within a range of frequencies, ascending.

    The displacement against which the force pushes falls through zero there with the frequency.
    Between resonances, at antiresonances, it rises: these are left out.

    Args:
        structure: Driven structure, all of whose forces have one harmonic.
        equations: Its equations.
        frequencies: Wanted frequencies in Hz, ascending, shape (f,).
    """
    n = structure.drive.harmonics[0]
    few = ResonantEquations.of(structure.mechanics, FourierSeries(n, 8 * n))

    def against(omega: float) -> float:
        return float(np.sum(few.push * _linear(few, omega)))

    grid = _grid(structure, 2 * np.pi * frequencies)
    values = np.array([against(float(omega)) for omega in grid])
    for here in np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0)):
        low, high = map(float, grid[here : here + 2])
        yield _resonance(equations, brentq(against, low, high, xtol=1e-15 * high, rtol=1e-15))


def _linear(equations: ResonantEquations, omega: float) -> Array:
    """Coefficients of the motion at level 1 without obstacles, shape (c, J)."""
    operator = equations.mechanics.linear.at(equations.series, omega)
    return np.asarray(operator.solve(equations.push))


def _resonance(equations: ResonantEquations, omega: float) -> LinearResonance:
    q, push = _linear(equations, omega), equations.push
    q -= push * np.sum(push * q) / np.sum(push * push)
    reached = np.linalg.norm(equations.free_harmonics(Unknowns.of(q, omega)), axis=0)
    gap = equations.mechanics.model.gap
    with np.errstate(divide="ignore", invalid="ignore"):
        levels = np.where(reached > 0, gap / reached, np.inf)
    return LinearResonance(omega, q, float(levels.min(initial=np.inf)))


def _grid(structure: DrivenStructure, omega: Array) -> Array:
    """Circular frequencies of which no two neighbours have two resonances between them."""
    beside = 0.5 ** np.arange(2, _CLOSEST)
    factors = np.concatenate([1 - beside, [1.0], 1 + beside])
    natural = structure.natural / structure.drive.harmonics[0]
    every = np.concatenate([omega, np.outer(natural, factors).ravel()])
    return np.unique(every[(every >= omega[0]) & (every <= omega[-1])])
