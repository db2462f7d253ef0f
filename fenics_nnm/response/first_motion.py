"""A first motion of a driven structure in contact at one frequency, from no motion nearby.

Newton's iteration starts at the motion without obstacles, with few harmonics; each motion found is
the guess of one with about twice as many. Where it fails the forces grow to their size in steps.
A structure that obstacles alone drive rests without them: it begins as if pushed by their forces on
the structure at rest, no farther than they reach; in the end with what it does in time from rest.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.conditions import FixedFrequency
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.timed import TimedEquations
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.response.driven import NothingTouches, open_motion
from fenics_nnm.response.settling import settled_from_rest
from fenics_nnm.response.structure import DrivenStructure
from fenics_nnm.time_domain.driven_flow import has_equations_in_time

#: Newton's iteration from a guess far away.
_FAR = Newton(tolerance=1e-12, round_off=1e-10, iterations=60)

#: The same from a motion under forces that are a little smaller.
_NEAR = Newton(tolerance=1e-12, round_off=1e-10, iterations=25)

#: The forces begin with this part at least, and grow by no smaller factor than 1 and this.
_SMALLEST_PART, _SMALLEST_GROWTH = 1e-2, 1e-2

#: Harmonics to begin with, and by what factor they grow.
_FEW, _MORE = 5, 1.6


def first_motion(structure: DrivenStructure, equations: TimedEquations, omega: float) -> Solution:
    """A motion at a circular frequency in rad/s; a failure is told in the solution.

    Args:
        structure: Driven structure.
        equations: Its equations, in the series that the motion is wanted in.
        omega: Circular frequency in rad/s.
    """
    guess = _guess(equations, omega)
    found = solve(equations, FixedFrequency(omega), guess, options=_FAR)
    if found.failure:
        for coarse in _coarse(structure, equations):
            found = _grown(structure, coarse, guess)
            if found.failure:
                return _settled(structure, equations, found)
            guess = found.at
    return found


def _settled(structure: DrivenStructure, equations: TimedEquations, failed: Solution) -> Solution:
    """The motion that a start from rest settles on, where gaps move; else what failed."""
    mechanics = equations.mechanics
    if not structure.gap_motion.moves or not has_equations_in_time(mechanics):
        return failed
    guess = settled_from_rest(mechanics, equations.series, failed.omega)
    return solve(equations, FixedFrequency(failed.omega), guess, options=_FAR)


def _opened(equations: TimedEquations, omega: float) -> Solution:
    """The motion as if there were no obstacles."""
    opened = HarmonicEquations(equations.mechanics, equations.series, NothingTouches())
    return open_motion(opened, omega)


def _guess(equations: TimedEquations, omega: float) -> Unknowns:
    """The motion without obstacles; that under their forces at rest where it is none."""
    opened = _opened(equations, omega).at
    return opened if opened.q.any() else _pushed(equations, opened)


def _pushed(equations: TimedEquations, rest: Unknowns) -> Unknowns:
    """The motion under the contact forces of the structure at rest, not beyond what they reach."""
    series, mechanics = equations.series, equations.mechanics
    push = equations.forces(rest).harmonics(series) @ mechanics.model.Phi
    q = -np.asarray(mechanics.linear.at(series, rest.omega).solve(push))
    reached = series.synthesis @ equations.free_harmonics(rest) - mechanics.model.gap
    farthest = float(np.abs(series.synthesis @ q @ mechanics.model.Phi.T).max(initial=0.0))
    if not farthest:
        return rest
    return Unknowns.of(q * min(1.0, float(reached.max()) / farthest), rest.omega)


def _coarse(structure: DrivenStructure, equations: TimedEquations) -> Iterator[TimedEquations]:
    """The equations with more and more harmonics, up to those wanted."""
    wanted = equations.series.harmonics
    number = max(_FEW, structure.highest_harmonic)
    while number < wanted:
        series = FourierSeries(number, max(4 * number + 1, 32))
        yield TimedEquations.of(equations.mechanics, series)
        number = int(np.ceil(_MORE * number))
    yield equations


def _grown(structure: DrivenStructure, equations: TimedEquations, guess: Unknowns) -> Solution:
    """The motion near a guess of any number of harmonics; else the forces grow to their size."""
    condition, fitted = FixedFrequency(guess.omega), equations.series.fitted
    near = Unknowns(fitted(guess.q), guess.parameters)
    found = solve(equations, condition, near, options=_FAR)
    part, growth, linear = _grazing(equations, guess), 0.5, _guess(equations, guess.omega)
    near = Unknowns(part * linear.q, guess.parameters)
    while found.failure and growth > _SMALLEST_GROWTH:
        tried = min(1.0, (1 + growth) * part)
        mechanics = structure.at_level(tried).mechanics
        grown = TimedEquations.of(mechanics, equations.series)
        step = solve(grown, condition, near, options=_NEAR)
        if step.failure:
            growth /= 2
            continue
        part, near = tried, step.at
        if part == 1.0:
            return step
    return found


def _grazing(equations: TimedEquations, guess: Unknowns) -> float:
    """The part of the forces at which the first gap is closed; a small one where none is open."""
    gap, series = equations.mechanics.model.gap, equations.series
    linear = _opened(equations, guess.omega).at
    reached = (series.synthesis @ equations.free_harmonics(linear)).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = np.where(reached > 0, gap / reached, np.inf)
    return float(np.clip(parts.min(), _SMALLEST_PART, 1.0))
