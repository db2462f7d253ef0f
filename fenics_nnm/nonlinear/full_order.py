"""Harmonic equations of the full finite-element model, without reduction.

A reduced model of J modes leaves out the inertia of all other modes. At the frequencies n omega of
the harmonics their flexibility R(s), s = (n omega)^2, can be had from the full matrices, so no
mode is left out: with ell_n the harmonics of the contact forces,

    (omega_j^2 - n^2 omega^2) q_nj + (Phi^T ell_n)_j = 0,     j = 1..J
    ell_n = lambda_n,     lambda(t) the contact law at     Phi q(t) - sum_n D_n(omega) ell_n(t)

is the same as U_n = -(K - (n omega)^2 M)^-1 B^T lambda_n for n = 0..N. The J modes stay explicit,
because the inverse is singular where n omega meets a natural frequency.

Two variants: *massless boundary* has D = R(s) - R(0) and complementarity with R(0), so force
harmonics above N meet the static flexibility; *mass-carrying* has D = R(s) and the augmented
Lagrangian, so they meet none.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces, ContactLaw
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.energies import Energies
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.reduction.flexibility import ResidualFlexibility


@dataclass(frozen=True, slots=True)
class FlexibilityAtRows:
    """D and its derivatives by s = (n omega)^2 for each row of a series, shapes (c, n_c, n_c).

    Attributes:
        value: D.
        slope: D'.
        curvature: D''.
        growth: Derivative of s by omega, shape (c,).
    """

    value: Array
    slope: Array
    curvature: Array
    growth: Array

    @classmethod
    def of(
        cls, flexibility: ResidualFlexibility, series: Series, omega: float
    ) -> FlexibilityAtRows:
        """At a frequency."""
        of_row = series.order.astype(int)
        D, slope, curvature = flexibility.at(omega)
        growth = 2 * series.order**2 * omega
        return cls(D[of_row], slope[of_row], curvature[of_row], growth)


@dataclass(frozen=True, slots=True)
class FullEnergy:
    """Energies of the full field U_n = phi q_n - X_n ell_n, for the unknowns (q, S ell).

    X_n^T M X_n = D', X_n^T K X_n = D (+ R) + s D'.

    Attributes:
        reduced: Equations of the modes.
        flexibility: D about the frequency sought.
        static_flexibility: S.
    """

    reduced: HarmonicEquations
    flexibility: ResidualFlexibility
    static_flexibility: Array

    def gamma(self, at: Unknowns) -> float:
        """m^ / 2 of the full field."""
        modal, ell = self.parts(at)
        slope = self._flexibility(at).slope
        residual_part = self.reduced.energy.weight * ell * _times(slope, ell)
        return self.reduced.energy.gamma(modal) + float(np.sum(residual_part) / 2)

    def gamma_gradient(self, at: Unknowns) -> Unknowns:
        """Derivatives of gamma by unknowns and parameters."""
        modal, ell = self.parts(at)
        found = self._flexibility(at)
        weight, gradient = self.reduced.energy.weight, self.reduced.energy.gamma_gradient(modal)
        by_ell = weight * _times(found.slope, ell)
        change = weight * found.growth[:, None] * ell * _times(found.curvature, ell)
        by_parameter = gradient.parameters.copy()
        by_parameter[0] = float(np.sum(change) / 2)
        return Unknowns(np.hstack([gradient.q, by_ell / self.static_flexibility]), by_parameter)

    def energies(self, at: Unknowns, forces: ContactForces) -> Energies:
        """Energies of the full field."""
        modal, ell = self.parts(at)
        found, series = self._flexibility(at), self.reduced.series
        squared = (series.order * at.omega)[:, None] ** 2
        strain = ell * (_times(found.value, ell) + squared * _times(found.slope, ell))
        of_modes = self.reduced.energy.energies(modal, forces)
        return replace(
            of_modes,
            stiffness=of_modes.stiffness + float(np.sum(series.mean_square[:, None] * strain)),
            mass=2 * self.gamma(at),
        )

    def parts(self, at: Unknowns) -> tuple[Unknowns, Array]:
        """Split into the unknowns of the modes and ell."""
        modes = self.reduced.model.modes
        modal = Unknowns(at.q[:, :modes], at.parameters)
        return modal, at.q[:, modes:] / self.static_flexibility

    def _flexibility(self, at: Unknowns) -> FlexibilityAtRows:
        return FlexibilityAtRows.of(self.flexibility, self.reduced.series, at.omega)


@dataclass(frozen=True, slots=True)
class FullOrderEquations:
    """Harmonic equations with the residual flexibility of the full model.

    The unknowns have the shape (c, J + n_c): q, and S ell with S the static flexibility of
    each contact point, so that all of them are displacements. What the methods return is as in
    `HarmonicEquations`, for these unknowns.

    Attributes:
        reduced: Equations of the J modes, with the law of all contact points.
        flexibility: D about the frequency sought.
    """

    reduced: HarmonicEquations
    flexibility: ResidualFlexibility
    mechanics: Mechanics = field(init=False, repr=False, compare=False)
    model: ReducedModel = field(init=False, repr=False, compare=False)
    series: Series = field(init=False, repr=False, compare=False)
    energy: FullEnergy = field(init=False, repr=False, compare=False)
    static_flexibility: Array = field(init=False, repr=False, compare=False)
    free_phase: bool = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        reduced, flexibility = self.reduced, self.flexibility
        if reduced.mechanics.forces or reduced.mechanics.excitations:
            raise ValueError("full order knows no forces besides contact")
        static = reduced.static_flexibility + np.diagonal(flexibility.value[0])
        derived = {
            "mechanics": reduced.mechanics,
            "model": reduced.model,
            "series": reduced.series,
            "energy": FullEnergy(reduced, flexibility, static),
            "static_flexibility": static,
            "free_phase": reduced.free_phase,
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return self.reduced.parameters

    def with_law(self, law: ContactLaw) -> FullOrderEquations:
        """The same under another contact law."""
        return replace(self, reduced=self.reduced.with_law(law))

    def stacked(self, q: Array, force: Array) -> Array:
        """Unknowns of modal coordinates q and contact forces at the samples."""
        return np.hstack([q, self.static_flexibility * (self.series.analysis @ force)])

    def modal(self, unknowns: Array) -> Array:
        """Coefficients of the modal coordinates, shape (c, J)."""
        return unknowns[:, : self.model.modes]

    def motion(self, unknowns: Array) -> Array:
        """The unknowns: at full order gaps are positive, and nothing is displaced at rest."""
        return unknowns

    def free_harmonics(self, at: Unknowns) -> Array:
        """Harmonics of Phi q - D ell, shape (c, n_c)."""
        modal, ell = self.energy.parts(at)
        return self.reduced.free_harmonics(modal) - _times(self._flexibility(at).value, ell)

    def forces(self, at: Unknowns, near: ContactForces | None = None) -> ContactForces:
        """Contact forces at the samples; those of a motion nearby may help."""
        return self.reduced.law(self.series.synthesis @ self.free_harmonics(at), near)

    def residual(self, at: Unknowns, forces: ContactForces) -> Array:
        """Left-hand sides: modal equations, then S (ell - lambda); shape of the unknowns."""
        modal, ell = self.energy.parts(at)
        balance = self.reduced.linear(modal).times(modal.q) + ell @ self.model.Phi
        contact = ell - self.series.analysis @ forces.force
        return np.hstack([balance, self.static_flexibility * contact])

    def jacobian(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivative of the residual by the unknowns, rows and columns by (n, j or c)."""
        rows, modes = self.reduced.shape
        points = self.model.points
        D = self._flexibility(at).value
        S, Phi = self.static_flexibility, self.model.Phi
        blocks = np.zeros((rows, modes + points, rows, modes + points))
        each = np.arange(rows)
        linear = np.zeros((rows * modes, rows * modes))
        self.reduced.linear(at).add_to(linear)
        blocks[:, :modes, :, :modes] = linear.reshape(rows, modes, rows, modes)
        blocks[each, :modes, each, modes:] = Phi.T / S
        scaled = S[:, None, None] * forces.harmonic_tangent(self.series)
        blocks[:, modes:, :, :modes] = -scaled @ Phi
        blocks[:, modes:, :, modes:] = np.einsum("acbd,bde->acbe", scaled, D / S)
        blocks[each, modes:, each, modes:] += np.eye(points)
        return blocks.reshape(rows * (modes + points), -1)

    def slopes(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivatives of the residual by the parameters, shape (p, c, J + n_c)."""
        modal, ell = self.energy.parts(at)
        found = self._flexibility(at)
        change = found.growth[:, None] * _times(found.slope, ell)
        contact = np.einsum("acbd,bd->ac", forces.harmonic_tangent(self.series), change)
        of_modes = self.reduced.slopes(modal, forces)
        slopes = np.zeros((len(of_modes), *at.q.shape))
        slopes[:, :, : self.model.modes] = of_modes
        slopes[0, :, self.model.modes :] = self.static_flexibility * contact
        return slopes

    def phase_shift(self, unknowns: Array) -> Array:
        """Derivative of the modal coordinates by the phase; forces follow from them."""
        shift = np.zeros_like(unknowns)
        shift[:, : self.model.modes] = self.reduced.phase_shift(self.modal(unknowns))
        return shift

    def row_scale(self, omega: float) -> Array:
        """Size of each equation per unit of its unknown."""
        modal = self.reduced.row_scale(omega)
        return np.hstack([modal, np.ones((len(modal), self.model.points))])

    def solved(self, at: Unknowns, forces: ContactForces, border: Border) -> Array:
        """Solution of the bordered system of the Jacobian, q first."""
        return border.dense_solution(self.jacobian(at, forces), self.row_scale(at.omega))

    def _flexibility(self, at: Unknowns) -> FlexibilityAtRows:
        return FlexibilityAtRows.of(self.flexibility, self.series, at.omega)


def _times(matrices: Array, vectors: Array) -> Array:
    """Product of each row's matrix with that row, shape (c, n_c)."""
    return np.einsum("ncd,nd->nc", matrices, vectors)
