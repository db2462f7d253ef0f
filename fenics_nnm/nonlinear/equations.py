"""Harmonic equations of a nonlinear mode: residual, Jacobian, energies, virial identity.

Everything here is dimensionless or not as its model is; nothing depends on the units.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces, ContactLaw
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.rest import RestState


@dataclass(frozen=True, slots=True)
class Energies:
    """Energies of a periodic motion (Laxalde and Legrand 2011, Eqs. 9-12, with n^2 in h).

    All count from the state of rest: U is the displacement from there, lambda_s and c_s are forces
    and clearances at rest, c the clearances; <,> is the mean over the period of the sum over the
    contact points. With positive gaps lambda_s = 0 and c_s is the gap.

    Attributes:
        stiffness: k^ = sum_n U_n* K U_n, twice the mean strain energy of U.
        mass: m^ = sum_n n^2 U_n* M U_n; omega^2 m^ is twice the mean kinetic energy.
        virial: <lambda, c_s> + <lambda_s, c>.
        lifted: <lambda_s, c>, the mean work done against the forces at rest.
        touch: Mean force times reference displacement of points that touch at rest.
    """

    stiffness: float
    mass: float
    virial: float
    lifted: float = 0.0
    touch: float = 0.0

    @property
    def gamma(self) -> float:
        """Modal energy coordinate gamma = m^ / 2."""
        return self.mass / 2

    @property
    def rayleigh_quotient(self) -> float:
        """R = k^ / m^, the square of the frequency only where no force acts across a gap."""
        return self.stiffness / self.mass

    def total(self, omega: float) -> float:
        """Energy E, constant in time: mean strain energy + mean kinetic energy."""
        return (self.stiffness + omega**2 * self.mass) / 2 + self.lifted

    @property
    def contact(self) -> float:
        """How much contact changes: 0 for a linear motion about the state of rest, or positive."""
        return self.virial + self.touch

    def virial_error(self, omega: float) -> float:
        """Relative error of omega^2 m^ = k^ + virial, which every exact solution obeys."""
        return abs(omega**2 * self.mass - self.stiffness - self.virial) / self.stiffness


@dataclass(frozen=True, slots=True)
class HarmonicEquations:
    r"""Harmonic balance of a reduced model under a contact law.

    For harmonic n and mode j, with lambda_n the harmonics of the sampled contact forces,

        (omega_j^2 - n^2 omega^2) q_nj + (Phi^T lambda_n)_j = 0,      n = 0..N.

    Coefficients `q` have the shape (N + 1, J) throughout; (2 N + 1, J) for a general series. There
    a term `drift` q' is added: a motion can be shifted in time, so one equation too many is left
    when its phase is fixed, and the drift is the unknown that goes with it. Contact does no work
    over a period, so it comes out as zero.
    """

    model: ReducedModel
    series: Series
    law: ContactLaw
    rest: RestState = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "rest", self.model.at_rest())

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the coefficients: (N + 1, J)."""
        return len(self.series.order), self.model.modes

    @property
    def static_flexibility(self) -> Array:
        """Static flexibility of each contact point, shape (n_c,)."""
        return self.model.static_flexibility

    def motion(self, q: Array) -> Array:
        """Coefficients of the motion about the state of rest, shape (N + 1, J)."""
        motion = q.copy()
        motion[0] -= self.rest.q
        return motion

    def scaled(self, q: Array, factor: float) -> Array:
        """Coefficients of a motion of the same shape, with its displacements from rest scaled."""
        scaled = factor * self.motion(q)
        scaled[0] += self.rest.q
        return scaled

    def with_law(self, law: ContactLaw) -> HarmonicEquations:
        """The same under another contact law."""
        return replace(self, law=law)

    def free_harmonics(self, q: Array, omega: float) -> Array:
        """Harmonics of the free displacement Phi q of the contact points, shape (N + 1, n_c)."""
        return q @ self.model.Phi.T

    def forces(self, q: Array, omega: float, near: ContactForces | None = None) -> ContactForces:
        """Contact forces at the samples of the motion q; those of a motion nearby may help."""
        return self.law(self.series.synthesis @ self.free_harmonics(q, omega), near)

    def dynamic_stiffness(self, omega: float) -> Array:
        """omega_j^2 - n^2 omega^2, shape (N + 1, J)."""
        return self.model.omega**2 - (self.series.order[:, None] * omega) ** 2

    def residual(self, q: Array, omega: float, forces: ContactForces, drift: float = 0.0) -> Array:
        """Left-hand sides of the harmonic equations, shape (N + 1, J)."""
        balance = self.dynamic_stiffness(omega) * q + self.force_harmonics(forces) @ self.model.Phi
        return balance + drift * self.drift_column(q) if drift else balance

    def drift_column(self, q: Array) -> Array:
        """Derivative of the residual by the drift: q' by the phase, shape (2 N + 1, J)."""
        return self.series.rotation() @ q

    def force_harmonics(self, forces: ContactForces) -> Array:
        """Harmonics lambda_n of the contact forces, shape (N + 1, n_c)."""
        return self.series.analysis @ forces.force

    def jacobian(self, omega: float, forces: ContactForces, drift: float = 0.0) -> Array:
        """Derivative of the residual by q, shape ((N + 1) J, (N + 1) J), rows and columns (n, j).

        The contact part is sum_k A_nk C_kn' (Phi^T D_k Phi) over the samples k in contact.
        """
        rows, modes = self.shape
        at = forces.samples
        contact = forces.stiffness(self.model.Phi)
        mixing = self.series.analysis[:, None, at] * self.series.synthesis.T[None, :, at]
        blocks = mixing.reshape(rows * rows, len(at)) @ contact.reshape(len(at), modes * modes)
        matrix = blocks.reshape(rows, rows, modes, modes).swapaxes(1, 2).reshape(rows * modes, -1)
        diagonal = np.arange(rows * modes)
        matrix[diagonal, diagonal] += self.dynamic_stiffness(omega).ravel()
        if drift:
            matrix += drift * np.kron(self.series.rotation(), np.eye(modes))
        return matrix

    def frequency_column(self, q: Array, omega: float, forces: ContactForces) -> Array:
        """Derivative of the residual by omega, shape (N + 1, J)."""
        return -2 * omega * self.series.order[:, None] ** 2 * q

    def gamma(self, q: Array, omega: float) -> float:
        """Modal energy coordinate gamma = m^ / 2."""
        return float(np.sum(self.gamma_weight * q**2) / 2)

    def gamma_gradient(self, q: Array, omega: float) -> tuple[Array, float]:
        """Derivatives of gamma by q, shape (N + 1, J), and by omega."""
        return self.gamma_weight * q, 0.0

    def energies(self, q: Array, omega: float, forces: ContactForces) -> Energies:
        """Energies of the motion; the strain energy of R is the mean of lambda^T R lambda."""
        rest, weight = self.rest, self.series.weight
        mean_square = self.series.mean_square[:, None]
        change = forces.force - rest.force
        residual_part = np.sum((change @ self.model.R) * change, axis=1)
        lifted = float(weight @ (self._clearance(q, omega, forces) @ rest.force))
        return Energies(
            stiffness=float(
                np.sum(mean_square * (self.model.omega * self.motion(q)) ** 2)
                + weight @ residual_part
            ),
            mass=2 * self.gamma(q, omega),
            virial=float(weight @ (forces.force @ rest.clearance)) + lifted,
            lifted=lifted,
            touch=float(weight @ forces.force[:, rest.touching].sum(axis=1)) * rest.scale,
        )

    def _clearance(self, q: Array, omega: float, forces: ContactForces) -> Array:
        """Clearances at the samples of the points that are closed at rest, else 0."""
        if not self.rest.closed.any():
            return np.zeros_like(forces.force)
        free = self.series.synthesis @ self.free_harmonics(q, omega)
        clearance = self.model.gap - free + forces.force @ self.model.R
        return np.where(self.rest.closed & (forces.force == 0), clearance, 0.0)

    def row_scale(self, omega: float) -> Array:
        """Size of each equation per unit of its coordinate: omega_j^2 + n^2 omega^2."""
        return self.model.omega**2 + (self.series.order[:, None] * omega) ** 2

    def relative_residual(self, q: Array, omega: float, residual: Array) -> float:
        """Norm of the residual as displacements, relative to that of the motion; inf at rest."""
        size = float(np.linalg.norm(self.motion(q)))
        return float(np.linalg.norm(residual / self.row_scale(omega))) / size if size else np.inf

    @property
    def gamma_weight(self) -> Array:
        """Mean square of each basis function times n^2, shape (N + 1, 1)."""
        return (self.series.mean_square * self.series.order**2)[:, None]
