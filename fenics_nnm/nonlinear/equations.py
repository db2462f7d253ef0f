"""Harmonic equations of a periodic motion: residual and Jacobian.

Everything here is dimensionless or not as its model is; nothing depends on the units.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.closing import Closing
from fenics_nnm.mechanics.contact_law import ContactForces, ContactLaw
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.linear_part import HarmonicOperator
from fenics_nnm.mechanics.master_tangent import MasterTangent
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.rest import RestState
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.condensed import condensed_solution, pays
from fenics_nnm.nonlinear.condensed_bent import Bending, bent_solution
from fenics_nnm.nonlinear.energies import Energies, ModalEnergy
from fenics_nnm.nonlinear.unknowns import Unknowns

#: Names of parameters: circular frequency, and drift of a free motion in a general series.
OMEGA, DRIFT = "omega", "drift"


class EnergyMeasure(Protocol):
    """Energies of the motions of some equations."""

    def gamma(self, at: Unknowns) -> float:
        """Modal energy coordinate gamma = m^ / 2."""

    def gamma_gradient(self, at: Unknowns) -> Unknowns:
        """Derivatives of gamma by coefficients and parameters."""

    def energies(self, at: Unknowns, forces: ContactForces) -> Energies:
        """Energies of the motion."""


class Stated(Protocol):
    """What equations are stated for."""

    @property
    def mechanics(self) -> Mechanics:
        """What a motion obeys."""

    @property
    def series(self) -> Series:
        """Series in time."""

    @property
    def energy(self) -> EnergyMeasure:
        """Energies of the motions."""

    @property
    def static_flexibility(self) -> Array:
        """Static flexibility of each contact point, shape (n_c,)."""

    @property
    def free_phase(self) -> bool:
        """Whether a shift in time gives another motion: the phase has to be fixed."""


class Equations(Stated, Protocol):
    """What Newton's iteration solves."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters; the frequency comes first."""

    def with_law(self, law: ContactLaw) -> Equations:
        """The same under another contact law."""

    def free_harmonics(self, at: Unknowns) -> Array:
        """Harmonics of the free displacement of the contact points, shape (c, n_c)."""

    def forces(self, at: Unknowns, near: ContactForces | None = None) -> ContactForces:
        """Contact forces at the samples; those of a motion nearby may help."""

    def residual(self, at: Unknowns, forces: ContactForces) -> Array:
        """Left-hand sides, shape of the coefficients."""

    def jacobian(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivative of the residual by the coefficients, rows and columns by (n, j)."""

    def slopes(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivatives of the residual by the parameters, shape (p, c, J)."""

    def phase_shift(self, q: Array) -> Array:
        """Derivative of the coefficients by a shift in time, shape of q; free phases alone."""

    def row_scale(self, omega: float) -> Array:
        """Size of each equation per unit of its coordinate, shape of q."""

    def motion(self, q: Array) -> Array:
        """Coefficients of the motion about the state of rest, shape of q."""

    def modal(self, q: Array) -> Array:
        """Coefficients of the modal coordinates alone, shape (c, J)."""

    def stacked(self, q: Array, force: Array) -> Array:
        """Coefficients from those of the modal coordinates and contact forces at the samples."""

    def solved(self, at: Unknowns, forces: ContactForces, border: Border) -> Array:
        """Solution of the bordered system of the Jacobian, q first."""


@dataclass(frozen=True, slots=True)
class HarmonicEquations:
    r"""Harmonic balance of a reduced model under a contact law.

    For harmonic n, with lambda_n the harmonics of the sampled contact forces, f_n those of other
    forces and p_n of the excitation,

        (Lambda - n^2 omega^2) q_n + omega C q'_n + Phi^T lambda_n + f_n = p_n,      n = 0..N,

    with the harmonics of (Phi + Theta q)^T lambda in place of Phi^T lambda_n where contact points
    close in second order.

    Coefficients `q` have the shape (c, J) throughout, c = N + 1 for cosines and 2 N + 1 for a
    general series. There a term `drift` q' is added for a free motion: it can be shifted in time,
    so one equation too many is left when its phase is fixed, and the drift is the unknown that goes
    with it. Contact does no work over a period, so it comes out as zero.
    """

    mechanics: Mechanics
    series: Series
    law: ContactLaw
    model: ReducedModel = field(init=False, repr=False, compare=False)
    rest: RestState = field(init=False, repr=False, compare=False)
    closing: Closing = field(init=False, repr=False, compare=False)
    energy: ModalEnergy = field(init=False, repr=False, compare=False)
    static_flexibility: Array = field(init=False, repr=False, compare=False)
    free_phase: bool = field(init=False, repr=False, compare=False)
    shape: tuple[int, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        mechanics, series = self.mechanics, self.series
        derived = {
            "model": mechanics.model,
            "rest": mechanics.rest,
            "closing": mechanics.model.kinematics.closing,
            "energy": ModalEnergy(mechanics, series),
            "static_flexibility": mechanics.model.static_flexibility,
            "free_phase": series.free_phase and mechanics.free,
            "shape": (len(series.order), mechanics.model.modes),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters: the frequency, and the drift of a free phase."""
        return (OMEGA, DRIFT) if self.free_phase else (OMEGA,)

    def with_law(self, law: ContactLaw) -> HarmonicEquations:
        """The same under another contact law."""
        return replace(self, law=law)

    def motion(self, q: Array) -> Array:
        """Coefficients of the motion about the state of rest, shape (c, J)."""
        return self.rest.motion_from(q)

    def modal(self, q: Array) -> Array:
        """Coefficients of the modal coordinates: all of them."""
        return q

    def stacked(self, q: Array, force: Array) -> Array:
        """Coefficients from those of the modal coordinates: these."""
        return q

    def linear(self, at: Unknowns) -> HarmonicOperator:
        """Linear part at the frequency and drift of a motion."""
        free = self.free_phase and len(at.parameters) > 1
        drift = float(at.parameters[1]) if free else 0.0
        return self.mechanics.linear.at(self.series, at.omega, drift)

    def free_harmonics(self, at: Unknowns) -> Array:
        """Harmonics of the linear part Phi q of their free displacement, shape (c, n_c)."""
        return at.q @ self.model.Phi.T

    def forces(self, at: Unknowns, near: ContactForces | None = None) -> ContactForces:
        """Contact forces at the samples of a motion; those of a motion nearby may help."""
        basis = self.series.synthesis
        linear = basis @ self.free_harmonics(at)
        return self.law(self.closing.displaced(linear, basis, at.q), near)

    def residual(self, at: Unknowns, forces: ContactForces) -> Array:
        """Left-hand sides of the harmonic equations, shape (c, J)."""
        balance = self.linear(at).times(at.q) + force_harmonics(self, at, forces)
        for excitation in self.mechanics.excitations:
            balance -= excitation.harmonics(self.series)
        return balance

    def jacobian(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivative of the residual by q, shape (c J, c J), rows and columns (n, j)."""
        matrix = self.closing.tangent(self.series, self.model.Phi, at.q, forces)
        self.linear(at).add_to(matrix)
        for force in self.mechanics.acting:
            matrix += force.tangent(SampledMotion(self.series, at.q, at.omega))
        return matrix

    def slopes(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivatives of the residual by the parameters, shape (p, c, J)."""
        by_omega = self.linear(at).by_omega(at.q)
        for force in self.mechanics.acting:
            by_omega += force.by_omega(SampledMotion(self.series, at.q, at.omega))
        return np.array([by_omega, self.phase_shift(at.q)] if self.free_phase else [by_omega])

    def phase_shift(self, q: Array) -> Array:
        """Derivative of q by the phase, shape (2 N + 1, J)."""
        return self.series.rotation() @ q

    def row_scale(self, omega: float) -> Array:
        """Size of each equation per unit of its coordinate: omega_j^2 + n^2 omega^2."""
        return self.model.omega**2 + (self.series.order[:, None] * omega) ** 2

    def solved(self, at: Unknowns, forces: ContactForces, border: Border) -> Array:
        """Solution of the bordered system: condensed on the pairs in contact where that pays."""
        operator, free = self.linear(at), at.q.size
        if _bent(self.mechanics) and pays(forces, free):
            bending = _bending(self, at, forces)
            return bent_solution(operator, self.series, self.model.Phi, forces, bending, border)
        if not self.mechanics.acting and pays(forces, free):
            return condensed_solution(operator, self.series, self.model.Phi, forces, border)
        return border.dense_solution(self.jacobian(at, forces), self.row_scale(at.omega))


def _bent(mechanics: Mechanics) -> bool:
    """Whether there are forces of second-order kinematics, and no others."""
    own = mechanics.model.kinematics.forces
    return bool(own) and len(own) == len(mechanics.acting) and mechanics.linear.separate


def _bending(equations: HarmonicEquations, at: Unknowns, forces: ContactForces) -> Bending:
    """What second-order kinematics add to a condensed system."""
    series, closing = equations.series, equations.closing
    kinematics, motion = equations.model.kinematics, SampledMotion(series, at.q, at.omega)
    bent = closing.bent_tangent(series, at.q, forces)
    tangent = MasterTangent.between(kinematics.masters, at.q.shape[1], bent)
    for force in kinematics.forces:
        tangent = tangent.plus(force.master_tangent(motion))
    return Bending(closing.turned_pairs(series, at.q, forces), tangent)


def force_harmonics(equations: HarmonicEquations, at: Unknowns, forces: ContactForces) -> Array:
    """Harmonics of all forces that the motion determines, shape (c, J)."""
    series, closing = equations.series, equations.closing
    linear = forces.harmonics(series) @ equations.model.Phi
    harmonics = closing.pushed(linear, series, at.q, forces)
    for force in equations.mechanics.acting:
        harmonics += force.harmonics(SampledMotion(series, at.q, at.omega))
    return harmonics


def harmonic_equations(model: ReducedModel, series: Series, law: ContactLaw) -> HarmonicEquations:
    """Equations of free motions of a model; its state of rest is computed for them.

    Raises:
        ModelError: if a gap is not positive where contact points carry mass.
    """
    return HarmonicEquations(Mechanics.of(model), series, law)
