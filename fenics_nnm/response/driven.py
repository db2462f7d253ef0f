r"""Motions of a driven structure over frequency, for one level of its forces.

As long as nothing touches, and without springs that are not linear, the equations are linear: with
the complex modal force p of each harmonic

    (Lambda - n^2 omega^2 + i n omega C) x_n = p_n,      q(t) = Re(sum_n x_n exp(i n omega t)),

is solved exactly at the wanted frequencies. Springs that are not linear take Newton's iteration,
which starts there. Where a motion closes a gap, the response is followed along its curve through
all frequencies, see `response.curve`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.conditions import FixedFrequency
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import solve
from fenics_nnm.nonlinear.solution import Solution, evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.response.balance import LARGEST_IMBALANCE, imbalance
from fenics_nnm.response.displacements import displacements
from fenics_nnm.response.judge import judge_of
from fenics_nnm.response.point import Displacements, Judgement, ResponsePoint, Status
from fenics_nnm.response.structure import DrivenStructure


@dataclass(frozen=True, slots=True)
class NothingTouches:
    """The contact law of motions that keep clear of all obstacles: no forces."""

    def __call__(
        self, free_displacement: Array, near: ContactForces | None = None
    ) -> ContactForces:
        """No forces, at displacements of shape (s, n_c)."""
        return ContactForces.alone(np.zeros_like(free_displacement))


def open_response(
    structure: DrivenStructure,
    series: FourierSeries,
    frequencies: Array,
    *,
    on_progress: Callable[[float], None] = lambda part: None,
) -> tuple[ResponsePoint, ...]:
    """Motions at some frequencies as if there were no obstacles; those that close a gap say so.

    Args:
        structure: Driven structure.
        series: Series in time.
        frequencies: Frequencies in Hz, shape (f,).
        on_progress: Called with the part of the frequencies that is done.

    Raises:
        ModelError: if a gap is not positive where contact points carry mass.
    """
    equations = HarmonicEquations(structure.mechanics, series, NothingTouches())
    judge = judge_of(structure.mechanics)
    points = []
    for number, frequency in enumerate(map(float, frequencies), start=1):
        solution = open_motion(equations, 2 * np.pi * frequency)
        known = judge.of_linear(solution.omega)
        if structure.forces:
            known = judge.of_contact(series, solution.q, solution.omega)
        points.append(_open_point(structure, series, frequency, solution, known))
        on_progress(number / len(frequencies))
    return tuple(points)


def open_motion(equations: HarmonicEquations, omega: float) -> Solution:
    """The motion at a circular frequency in rad/s, as if there were no obstacles."""
    mechanics, series = equations.mechanics, equations.series
    push = np.zeros((len(series.order), mechanics.model.modes))
    for each in mechanics.excitations:
        push += each.harmonics(series)
    linear = Unknowns.of(mechanics.linear.at(series, omega).solve(push), omega)
    if not mechanics.acting:
        return evaluated(equations, linear)
    return solve(equations, FixedFrequency(omega), linear)


def point_of(
    structure: DrivenStructure, series: FourierSeries, solution: Solution, judgement: Judgement
) -> ResponsePoint:
    """A motion that was found, and what is known of it, as a point of the response."""
    error = imbalance(structure.mechanics, series, solution)
    if not error <= LARGEST_IMBALANCE:
        judgement = Judgement(
            Status.FAILED, f"the work of the forces differs from the dissipation by {error:.1e}"
        )
    found = displacements(structure, series, solution)
    frequency = solution.omega / (2 * np.pi)
    return ResponsePoint(
        frequency, judgement, found, solution.residual, solution.q, imbalance=error
    )


def _open_point(
    structure: DrivenStructure,
    series: FourierSeries,
    frequency: float,
    solution: Solution,
    known: Judgement,
) -> ResponsePoint:
    """A motion without contact as a point of the response."""
    point = replace(point_of(structure, series, solution, known), frequency=frequency)
    judgement = _judged(solution, point)
    if judgement.status in (Status.FAILED, Status.TOUCHES):
        nothing = Displacements.unknown(len(structure.monitors), structure.model.points)
        return replace(point, judgement=judgement, displacements=nothing)
    return point


def _judged(solution: Solution, point: ResponsePoint) -> Judgement:
    """What is known of a motion without contact, and why it has no amplitudes."""
    if solution.failure:
        return Judgement(Status.FAILED, solution.failure)
    if point.gap.min() <= 0:
        closed = int(np.argmin(point.gap)) + 1
        return Judgement(Status.TOUCHES, f"closes the gap at contact point {closed}")
    return point.judgement
