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

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces, ContactLaw
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.equations import Energies, HarmonicEquations
from fenics_nnm.reduction.flexibility import ResidualFlexibility


@dataclass(frozen=True, slots=True)
class FullOrderEquations:
    """Harmonic equations with the residual flexibility of the full model.

    The unknowns have the shape (N + 1, J + n_c): q, and S ell with S the static flexibility of
    each contact point, so that all of them are displacements. What the methods return is as in
    `HarmonicEquations`, for these unknowns.

    Attributes:
        reduced: Equations of the J modes, with the law of all contact points.
        flexibility: D about the frequency sought.
    """

    reduced: HarmonicEquations
    flexibility: ResidualFlexibility

    @property
    def model(self) -> ReducedModel:
        """Reduced model of the J modes."""
        return self.reduced.model

    @property
    def series(self) -> Series:
        """Series in time."""
        return self.reduced.series

    @property
    def static_flexibility(self) -> Array:
        """S, static flexibility of each contact point, shape (n_c,)."""
        return self.reduced.static_flexibility + np.diagonal(self.flexibility.value[0])

    def with_law(self, law: ContactLaw) -> FullOrderEquations:
        """The same under another contact law."""
        return replace(self, reduced=self.reduced.with_law(law))

    def stacked(self, q: Array, force: Array) -> Array:
        """Unknowns of modal coordinates q and contact forces at the samples."""
        return np.hstack([q, self.static_flexibility * (self.series.analysis @ force)])

    def free_harmonics(self, unknowns: Array, omega: float) -> Array:
        """Harmonics of Phi q - D ell, shape (N + 1, n_c)."""
        q, ell = self._parts(unknowns)
        D, _, _ = self._flexibility(omega)
        return self.reduced.free_harmonics(q, omega) - _times(D, ell)

    def motion(self, unknowns: Array) -> Array:
        """The unknowns: at full order gaps are positive, and nothing is displaced at rest."""
        return unknowns

    def forces(
        self, unknowns: Array, omega: float, near: ContactForces | None = None
    ) -> ContactForces:
        """Contact forces at the samples; those of a motion nearby may help."""
        return self.reduced.law(self.series.synthesis @ self.free_harmonics(unknowns, omega), near)

    def residual(
        self, unknowns: Array, omega: float, forces: ContactForces, drift: float = 0.0
    ) -> Array:
        """Left-hand sides: modal equations, then S (ell - lambda); shape of the unknowns."""
        q, ell = self._parts(unknowns)
        modal = self.reduced.dynamic_stiffness(omega) * q + ell @ self.model.Phi
        contact = self.static_flexibility * (ell - self.reduced.force_harmonics(forces))
        balance = np.hstack([modal, contact])
        return balance + drift * self.drift_column(unknowns) if drift else balance

    def drift_column(self, unknowns: Array) -> Array:
        """Derivative of the residual by the drift."""
        q, ell = self._parts(unknowns)
        return np.hstack([self.reduced.drift_column(q), np.zeros_like(ell)])

    def jacobian(self, omega: float, forces: ContactForces, drift: float = 0.0) -> Array:
        """Derivative of the residual by the unknowns, rows and columns by (n, j or c)."""
        rows, modes = self.reduced.shape
        points = self.model.points
        D, _, _ = self._flexibility(omega)
        S, Phi = self.static_flexibility, self.model.Phi
        blocks = np.zeros((rows, modes + points, rows, modes + points))
        each = np.arange(rows)
        for j, row in enumerate(self.reduced.dynamic_stiffness(omega).T):
            blocks[each, j, each, j] = row
        blocks[each, :modes, each, modes:] = Phi.T / S
        scaled = S[:, None, None] * self.contact_tangent(forces)
        blocks[:, modes:, :, :modes] = -scaled @ Phi
        blocks[:, modes:, :, modes:] = np.einsum("acbd,bde->acbe", scaled, D / S)
        blocks[each, modes:, each, modes:] += np.eye(points)
        if drift:
            rotation = drift * self.series.rotation()
            for j in range(modes):
                blocks[:, j, :, j] += rotation
        return blocks.reshape(rows * (modes + points), -1)

    def contact_tangent(self, forces: ContactForces) -> Array:
        """Derivatives of lambda_n by harmonics of w, shape (N + 1, n_c, N + 1, n_c)."""
        at, points = forces.samples, self.model.points
        dense = np.zeros((len(at), points, points))
        index = np.arange(len(at))[:, None, None]
        dense[index, forces.points[:, :, None], forces.points[:, None, :]] = forces.slope
        rows = len(self.series.order)
        mixing = self.series.analysis[:, None, at] * self.series.synthesis.T[None, :, at]
        coupled = mixing.reshape(rows * rows, len(at)) @ dense.reshape(len(at), points**2)
        return coupled.reshape(rows, rows, points, points).swapaxes(1, 2)

    def frequency_column(self, unknowns: Array, omega: float, forces: ContactForces) -> Array:
        """Derivative of the residual by omega, shape of the unknowns."""
        q, ell = self._parts(unknowns)
        _, slope, _ = self._flexibility(omega)
        change = self._growth(omega)[:, None] * _times(slope, ell)
        contact = np.einsum("acbd,bd->ac", self.contact_tangent(forces), change)
        return np.hstack(
            [self.reduced.frequency_column(q, omega, forces), self.static_flexibility * contact]
        )

    def gamma(self, unknowns: Array, omega: float) -> float:
        """m^ / 2 of the full field: U_n = phi q_n - X_n ell_n, with X_n^T M X_n = D'."""
        q, ell = self._parts(unknowns)
        _, slope, _ = self._flexibility(omega)
        residual_part = self.reduced.gamma_weight * ell * _times(slope, ell)
        return self.reduced.gamma(q, omega) + float(np.sum(residual_part) / 2)

    def gamma_gradient(self, unknowns: Array, omega: float) -> tuple[Array, float]:
        """Derivatives of gamma by the unknowns and by omega."""
        q, ell = self._parts(unknowns)
        _, slope, curvature = self._flexibility(omega)
        weight = self.reduced.gamma_weight
        by_q, _ = self.reduced.gamma_gradient(q, omega)
        by_ell = weight * _times(slope, ell)
        change = weight * self._growth(omega)[:, None] * ell * _times(curvature, ell)
        return np.hstack([by_q, by_ell / self.static_flexibility]), float(np.sum(change) / 2)

    def energies(self, unknowns: Array, omega: float, forces: ContactForces) -> Energies:
        """Energies of the full field: X_n^T K X_n = D (+ R) + s D'."""
        q, ell = self._parts(unknowns)
        D, slope, _ = self._flexibility(omega)
        modal = self.reduced.energies(q, omega, forces)
        squared = (self.series.order * omega)[:, None] ** 2
        strain = ell * (_times(D, ell) + squared * _times(slope, ell))
        return replace(
            modal,
            stiffness=modal.stiffness + float(np.sum(self.series.mean_square[:, None] * strain)),
            mass=2 * self.gamma(unknowns, omega),
        )

    def row_scale(self, omega: float) -> Array:
        """Size of each equation per unit of its unknown."""
        modal = self.reduced.row_scale(omega)
        return np.hstack([modal, np.ones((len(modal), self.model.points))])

    def relative_residual(self, unknowns: Array, omega: float, residual: Array) -> float:
        """Norm of the residual as displacements, relative to that of the motion; inf at rest."""
        size = float(np.linalg.norm(unknowns))
        return float(np.linalg.norm(residual / self.row_scale(omega))) / size if size else np.inf

    def _parts(self, unknowns: Array) -> tuple[Array, Array]:
        """Split into q and ell."""
        modes = self.model.modes
        return unknowns[:, :modes], unknowns[:, modes:] / self.static_flexibility

    def _flexibility(self, omega: float) -> tuple[Array, Array, Array]:
        """D, D' and D'' for each row of the series."""
        of_row = self.series.order.astype(int)
        D, slope, curvature = self.flexibility.at(omega)
        return D[of_row], slope[of_row], curvature[of_row]

    def _growth(self, omega: float) -> Array:
        """Derivative of s = (n omega)^2 by omega, for each row of the series."""
        return 2 * self.series.order**2 * omega


def _times(matrices: Array, vectors: Array) -> Array:
    """Product of each row's matrix with that row, shape (N + 1, n_c)."""
    return np.einsum("ncd,nd->nc", matrices, vectors)


Equations = HarmonicEquations | FullOrderEquations
"""What Newton's iteration solves."""
