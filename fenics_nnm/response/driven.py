r"""Motions of a driven structure at given frequencies, from the harmonic equations.

Without forces that depend on the motion the equations are linear: with the complex modal force p

    (Lambda - omega^2 + i omega C) x = p,      q(t) = Re(x exp(i omega t)),

is solved exactly. Springs that are not linear take Newton's iteration, which starts there.

Nothing presses a contact point in these motions. One that closes a gap is no motion of the
structure, and is reported as such, without amplitudes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.conditions import FixedFrequency
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import solve
from fenics_nnm.nonlinear.solution import Solution, evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.response.structure import DrivenStructure

#: Instants of a period at which the largest displacement of several harmonics is looked for.
_INSTANTS = 4096


class Status(StrEnum):
    """What is known of the motion at a frequency."""

    EXACT = "exact"
    CONVERGED = "converged"
    TOUCHES = "touches"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class ResponsePoint:
    """The motion of a driven structure at one frequency.

    Attributes:
        frequency: Frequency in Hz.
        status: What is known of the motion.
        displacement: Complex amplitudes of the first harmonic of the points that are watched, in
            m, 0-peak; nan where the motion touches or was not found, shape (p + n_c,).
        gap: Smallest remaining gap of each contact point over the period in m; nan where the
            motion touches or was not found, shape (n_c,).
        residual: Relative residual of the harmonic equations.
        reason: Why there are no amplitudes, or nothing.
    """

    frequency: float
    status: Status
    displacement: Complex
    gap: Array
    residual: float
    reason: str = ""

    @property
    def found(self) -> bool:
        """Whether there are amplitudes."""
        return self.status in (Status.EXACT, Status.CONVERGED)

    @property
    def amplitude(self) -> Array:
        """Amplitudes in m, 0-peak, shape (p + n_c,)."""
        return np.abs(self.displacement)

    @property
    def phase(self) -> Array:
        """Lags behind cos(omega t) in degrees, 0 to 360, shape (p + n_c,).

        Of an excited point whose force has no phase it is the lag behind the force, between 0 and
        180 for a single mode: 90 at phase resonance.
        """
        return np.asarray(np.rad2deg(-np.angle(self.displacement)) % 360.0)


@dataclass(frozen=True, slots=True)
class NothingTouches:
    """The contact law of motions that keep clear of all obstacles: no forces."""

    def __call__(
        self, free_displacement: Array, near: ContactForces | None = None
    ) -> ContactForces:
        """No forces, at displacements of shape (s, n_c)."""
        return ContactForces.alone(np.zeros_like(free_displacement))


def response(
    structure: DrivenStructure,
    series: FourierSeries,
    frequencies: Array,
    *,
    on_progress: Callable[[float], None] = lambda part: None,
) -> tuple[ResponsePoint, ...]:
    """Motions of a driven structure at some frequencies.

    Args:
        structure: Driven structure.
        series: Series in time.
        frequencies: Frequencies in Hz, shape (f,).
        on_progress: Called with the part of the frequencies that is done.

    Raises:
        ModelError: if a gap is not positive.
    """
    equations = HarmonicEquations(structure.mechanics, series, NothingTouches())
    points = []
    for number, frequency in enumerate(map(float, frequencies), start=1):
        solution = _solution(equations, 2 * np.pi * frequency)
        points.append(_point(structure, series, frequency, solution))
        on_progress(number / len(frequencies))
    return tuple(points)


def _solution(equations: HarmonicEquations, omega: float) -> Solution:
    """The motion at a frequency, as if there were no obstacles."""
    mechanics, series = equations.mechanics, equations.series
    push = sum(each.harmonics(series) for each in mechanics.excitations)
    linear = Unknowns.of(mechanics.linear.at(series, omega).solve(np.asarray(push)), omega)
    if not mechanics.forces:
        return evaluated(equations, linear)
    return solve(equations, FixedFrequency(omega), linear)


def _point(
    structure: DrivenStructure, series: FourierSeries, frequency: float, solution: Solution
) -> ResponsePoint:
    """A motion as a point of the response."""
    watched = solution.q @ structure.watched.T
    first, second = np.flatnonzero(series.order == 1)
    gap = structure.model.gap - _largest(series, solution.free)
    status, reason = _verdict(solution, gap, linear=not structure.forces)
    if reason:
        gap, watched = np.full_like(gap, np.nan), np.full_like(watched, np.nan)
    displacement = watched[first] - 1j * watched[second]
    return ResponsePoint(frequency, status, displacement, gap, solution.residual, reason)


def _verdict(solution: Solution, gap: Array, *, linear: bool) -> tuple[Status, str]:
    """Status of a motion with such gaps left, and why it has no amplitudes."""
    if solution.failure:
        return Status.FAILED, solution.failure
    if gap.min() <= 0:
        closed = int(np.argmin(gap)) + 1
        return Status.TOUCHES, (
            f"closes the gap at contact point {closed}: the response with contact is not "
            "available yet"
        )
    return (Status.EXACT if linear else Status.CONVERGED), ""


def _largest(series: FourierSeries, harmonics: Array) -> Array:
    """Largest values over a period, shape (n_c,), of coefficients of shape (c, n_c)."""
    if not harmonics[series.order > 1].any():
        return np.asarray(harmonics[0] + np.linalg.norm(harmonics[series.order == 1], axis=0))
    phase = 2 * np.pi * np.arange(_INSTANTS) / _INSTANTS
    return np.asarray((series.basis_at(phase) @ harmonics).max(axis=0))
