"""Levels of truncation, coarse to fine: the way on to the main branch of a mode.

Modes whose frequency is a multiple of the followed one trap Newton's iteration and continuation
in energy. A model of the followed mode alone has no such mode, so its branch is smooth; each
further level adds modes and harmonics and starts from the solution of the level before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.backbone.level_solver import (
    ComplementarySolver,
    Guess,
    LevelSolver,
    MultiplierSolver,
)
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.force import AddedForce, SampledMotion
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.penalty_law import AugmentedLagrangian
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop
from fenics_nnm.nonlinear.conditions import Condition
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.solution import Solution

#: Modes and harmonics of the levels; the last one is what the study asks for.
LADDER = ((1, 2), (2, 2), (3, 3), (6, 4), (8, 5), (12, 8), (20, 10), (30, 15), (40, 20), (80, 40))


@dataclass(frozen=True, slots=True)
class HarmonicBalance:
    """How motions are written in time, and how contact is found.

    Attributes:
        harmonics: Number of harmonics N.
        samples: Number of time samples m a period, at least 2 N + 1.
        general: Sines too, with a phase condition; else the cosines of a time-reversible motion.
        multipliers: Augmented Lagrangian, for contact points that carry mass; its defaults if
            None where the model has R = 0.
    """

    harmonics: int
    samples: int
    general: bool = False
    multipliers: MultiplierLoop | None = None

    @property
    def series(self) -> Series:
        """Series in time."""
        return self.truncated(self.harmonics)

    def truncated(self, harmonics: int) -> Series:
        """Series of the same samples with another number of harmonics."""
        return (FourierSeries if self.general else CosineSeries)(harmonics, self.samples)


@dataclass(frozen=True, slots=True)
class Level:
    """Harmonic equations on some of the modes of the full reduced model.

    Attributes:
        equations: Equations at this truncation.
        solver: How they are solved.
        modes: Indices of its modes about the state of rest, ascending.
        shapes: Its coordinates in those of the full model, orthonormal columns, shape (J, k).
        rest: Coordinates of the full model at rest, shape (J,).
    """

    equations: HarmonicEquations
    solver: LevelSolver
    modes: Indices
    shapes: Array
    rest: Array

    def at_energy(self, gamma: float, guess: Guess, newton: Newton) -> Solution:
        """Motion of given gamma."""
        return self.solver.at_energy(self.equations, guess, gamma=gamma, newton=newton)

    def at_condition(self, condition: Condition, guess: Guess, newton: Newton) -> Solution:
        """Motion that a condition picks.

        Raises:
            ModelError: if contact points carry mass.
        """
        return self.solver.at_condition(self.equations, guess, condition=condition, newton=newton)

    def problem(self, newton: Newton) -> Problem:
        """Its equations about any frequency, for continuation by arc-length.

        Raises:
            ModelError: if contact points carry mass.
        """
        return self.solver.problem(self.equations, newton)

    def restricted(self, q: Array) -> Array:
        """Coefficients of this level from coefficients over all modes."""
        fitted = self.equations.series.fitted(q)
        fitted[0] -= self.rest
        restricted = fitted @ self.shapes
        restricted[0] += self.equations.rest.q
        return restricted

    def extended(self, q: Array) -> Array:
        """Coefficients over all modes from coefficients of this level."""
        extended = self.equations.motion(q) @ self.shapes.T
        extended[0] += self.rest
        return extended

    def adopted(self, other: Level, q: Array) -> Array:
        """Coefficients of this level from those of another one."""
        return self.restricted(other.extended(q))

    def above(self, lower: Level, solution: Solution) -> Guess:
        """A solution of a lower level, of whose masters the modes that it lacks follow statically.

        They do so in the kinematics of that level, too (`SecondOrder.without_modes`).
        """
        q, model = self.adopted(lower, solution.q), self.equations.model
        new = np.isin(self.modes, lower.modes, invert=True)
        motion = SampledMotion(self.equations.series, q.copy(), solution.omega)
        for force in model.kinematics.forces:
            q[:, new] -= force.harmonics(motion)[:, new] / model.omega[new] ** 2
        return Guess(q, solution.omega, solution.forces.force)

    def scaled(self, solution: Solution, factor: float) -> Guess:
        """A solution at another energy: the same shape at `factor` times gamma."""
        q = self.equations.rest.scaled(solution.q, float(np.sqrt(factor)))
        return Guess(q, solution.omega, solution.forces.force)

    def share(self, q: Array, mode: int) -> float:
        """Share of the kinetic energy in the first harmonic of a mode about the state of rest."""
        series, column = self.equations.series, np.searchsorted(self.modes, mode)
        by_mode = q @ self.equations.rest.shapes
        kinetic = (series.mean_square * series.order**2)[:, None] * by_mode**2
        return float(kinetic[series.order == 1, column].sum() / kinetic.sum())


def levels(
    model: ReducedModel, balance: HarmonicBalance, *, mode: int, forces: Sequence[AddedForce] = ()
) -> tuple[Level, ...]:
    """Levels from the followed mode, and masters, to all modes and harmonics of the study.

    Args:
        model: Full reduced model, dimensionless.
        balance: Series and multipliers of the finest level. The levels below have R > 0 from the
            modes that they leave out, and use complementarity.
        mode: Index of the followed mode, from 0. It is part of every level.
        forces: Forces besides contact that the motion determines, dimensionless.
    """
    sizes = [size for size in LADDER if size[0] < model.modes or size[1] < balance.harmonics]
    least = len(_always(model, mode))
    clipped = [(min(max(J, least), model.modes), min(N, balance.harmonics)) for J, N in sizes]
    distinct = sorted({*clipped, (model.modes, balance.harmonics)})
    loop = balance.multipliers or MultiplierLoop()
    parts = [(_part(model, mode, J), balance.truncated(N)) for J, N in distinct]
    every = [_level(model, forces, chosen, series, loop) for chosen, series in parts]
    return tuple(
        level for level in every if len(level.modes) == model.modes or level.solver.reduced
    )


def _always(model: ReducedModel, mode: int) -> list[int]:
    """Modes of every level: the followed one, and masters of second-order displacement."""
    return [mode, *(int(index) for index in model.kinematics.masters if index != mode)]


def _part(model: ReducedModel, mode: int, count: int) -> Indices:
    always = _always(model, mode)
    others = [index for index in range(model.modes) if index not in always]
    return np.array(sorted([*always, *others[: count - len(always)]]))


def _level(
    model: ReducedModel,
    forces: Sequence[AddedForce],
    chosen: Indices,
    series: Series,
    loop: MultiplierLoop,
) -> Level:
    rest = model.at_rest()
    part, shapes = model.spanned_by(rest, chosen)
    mechanics = Mechanics.of(part, tuple(force.of_part(shapes) for force in forces))
    if part.massless:
        equations = HarmonicEquations(mechanics, series, Complementarity(part.R, part.gap))
        return Level(equations, ComplementarySolver(), chosen, shapes, rest.q)
    open_gap = AugmentedLagrangian(part.gap, np.zeros(1), np.zeros(1))
    equations = HarmonicEquations(mechanics, series, open_gap)
    return Level(equations, MultiplierSolver(loop), chosen, shapes, rest.q)
