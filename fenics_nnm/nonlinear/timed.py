"""Harmonic equations whose contact forces are integrated between the times of contact.

They are those of `nonlinear.equations` with the integrals of contact forces over the period exact,
see `mechanics.contact_times`: smooth where the equations with samples have kinks. Contact does no
work then, so that over a period of a driven motion the work that is put in is that dissipated.
With second-order kinematics contact points move by a series of twice as many harmonics.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity, ContactForces, ContactLaw
from fenics_nnm.mechanics.contact_times import FreeMotion, Margins, forces_in_time
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.condensed import Condensation, eliminated, pays
from fenics_nnm.nonlinear.equations import EnergyMeasure, HarmonicEquations
from fenics_nnm.nonlinear.unknowns import Unknowns


@dataclass(frozen=True, slots=True)
class TimedEquations:
    """Harmonic balance with exact integrals of contact forces, of points without mass.

    Attributes:
        mechanics: What a motion obeys.
        series: Series in time.
        given: Harmonics of what moves the contact points besides the coordinates, shape (c, n_c).
    """

    mechanics: Mechanics
    series: FourierSeries
    given: Array
    law: Complementarity = field(init=False, repr=False, compare=False)
    margins: Margins = field(init=False, repr=False, compare=False)
    sampled: HarmonicEquations = field(init=False, repr=False, compare=False)
    energy: EnergyMeasure = field(init=False, repr=False, compare=False)
    static_flexibility: Array = field(init=False, repr=False, compare=False)
    free_phase: bool = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        model = self.mechanics.model
        law = Complementarity(model.R, model.gap)
        sampled = HarmonicEquations(self.mechanics, self.series, law)
        object.__setattr__(self, "law", law)
        object.__setattr__(self, "margins", Margins(model.R))
        object.__setattr__(self, "sampled", sampled)
        for name in ("energy", "static_flexibility", "free_phase"):
            object.__setattr__(self, name, getattr(sampled, name))

    @classmethod
    def of(cls, mechanics: Mechanics, series: FourierSeries) -> Self:
        """Equations of a model whose contact points move with the coordinates, and their gaps."""
        shape = len(series.order), mechanics.model.points
        moved = np.broadcast_to(mechanics.gap_motion.coefficients(series), shape)
        return cls(mechanics, series, 0.0 - moved)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return self.sampled.parameters

    def with_law(self, law: ContactLaw) -> TimedEquations:
        """Refused: times of contact are those of points without mass."""
        raise TypeError("times of contact are found for points without mass alone")

    def free_harmonics(self, at: Unknowns) -> Array:
        """Harmonics of the free displacement of the contact points, shape (c, n_c)."""
        return self.sampled.free_harmonics(at) + self.given

    def forces(self, at: Unknowns, near: ContactForces | None = None) -> ContactForces:
        """Contact forces at the points of integration of a motion."""
        linear, closing = self.free_harmonics(at), self.sampled.closing
        series, free = closing.free_motion(self.series, at.q, linear)
        return forces_in_time(FreeMotion(series, free, self.law, self.margins))

    def residual(self, at: Unknowns, forces: ContactForces) -> Array:
        """Left-hand sides of the harmonic equations, shape (c, J)."""
        return self.sampled.residual(at, forces)

    def jacobian(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivative of the residual by q, shape (c J, c J), rows and columns (n, j)."""
        matrix = self.sampled.closing.timed_tangent(
            self.series, self.mechanics.model.Phi, at.q, forces
        )
        self.sampled.linear(at).add_to(matrix)
        for force in self.mechanics.acting:
            matrix += force.tangent(SampledMotion(self.series, at.q, at.omega))
        return matrix

    def slopes(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivatives of the residual by the parameters, shape (p, c, J)."""
        return self.sampled.slopes(at, forces)

    def phase_shift(self, q: Array) -> Array:
        """Derivative of q by the phase, shape (2 N + 1, J)."""
        return self.sampled.phase_shift(q)

    def row_scale(self, omega: float) -> Array:
        """Size of each equation per unit of its coordinate: omega_j^2 + n^2 omega^2."""
        return self.sampled.row_scale(omega)

    def motion(self, q: Array) -> Array:
        """Coefficients of the motion about the state of rest, shape (c, J)."""
        return self.sampled.motion(q)

    def modal(self, q: Array) -> Array:
        """Coefficients of the modal coordinates: all of them."""
        return q

    def stacked(self, q: Array, force: Array) -> Array:
        """Coefficients from those of the modal coordinates: these."""
        return q

    def solved(self, at: Unknowns, forces: ContactForces, border: Border) -> Array:
        """Solution of the bordered system: condensed on the pairs in contact where that pays."""
        if self.mechanics.acting or not pays(forces, at.q.size):
            return border.dense_solution(self.jacobian(at, forces), self.row_scale(at.omega))
        operator = self.sampled.linear(at)
        Phi = self.mechanics.model.Phi
        return eliminated(TimedCondensation.of(operator, self.series, Phi, forces), border)


@dataclass(frozen=True, slots=True)
class TimedCondensation(Condensation):
    """A condensation whose pairs are at any instants, not at evenly spread samples."""

    def flexibility(self) -> Array:
        """F + M, shape (P, P): what forces of the pairs move, one after the other."""
        pushed = self.pushed(np.eye(len(self.sample)))
        return self.with_local(self.moved(self.operator.solve(pushed)).T)
