"""Energies of a periodic motion of a reduced model, and the virial identity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.cubic_samples import CubicSamples
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.nonlinear.unknowns import Unknowns


@dataclass(frozen=True, slots=True)
class Energies:
    """Energies of a periodic motion (Laxalde and Legrand 2011, Eqs. 9-12, with n^2 in h).

    All count from the state of rest: U is the displacement from there, lambda_s and c_s are forces
    and clearances at rest, c the clearances; <,> is the mean over the period of the sum over the
    contact points. With positive gaps lambda_s = 0 and c_s is the gap.

    Attributes:
        stiffness: k^ = sum_n U_n* K U_n, twice the mean strain energy of U.
        mass: m^ = sum_n n^2 U_n* M U_n; omega^2 m^ is twice the mean kinetic energy of the modal
            coordinates.
        virial: <lambda, c_s> + <lambda_s, c>, and the mean of all other forces times U, and of
            1/2 U^T (lambda . Theta) U where contact points close in second order.
        lifted: <lambda_s, c>, the mean work done against the forces at rest.
        touch: Mean force times reference displacement of points that touch at rest.
        potential: Mean energy that forces besides contact and stiffness store, springs that are
            not linear or the polynomial stiffness of second-order kinematics.
        other_virial: The part of the virial that these forces, second-order inertia and closing
            have.
        bent_mass: m2^; omega^2 m2^ is twice the mean kinetic energy of M(q) - 1, that of the
            second-order displacement.
    """

    stiffness: float
    mass: float
    virial: float
    lifted: float = 0.0
    touch: float = 0.0
    potential: float = 0.0
    other_virial: float = 0.0
    bent_mass: float = 0.0

    @property
    def gamma(self) -> float:
        """Modal energy coordinate gamma = m^ / 2."""
        return self.mass / 2

    @property
    def rayleigh_quotient(self) -> float:
        """R = (k^ + 2 <V>) / (m^ + m2^), strain over kinetic energy with omega^2 left out.

        It is k^ / m^ where springs and kinematics are linear: the square of the frequency, only
        where no force acts across a gap.
        """
        return (self.stiffness + 2 * self.potential) / (self.mass + self.bent_mass)

    def total(self, omega: float) -> float:
        """Energy E, constant in time: mean strain energy + mean kinetic energy."""
        kinetic = omega**2 * (self.mass + self.bent_mass) / 2
        return self.stiffness / 2 + kinetic + self.lifted + self.potential

    @property
    def contact(self) -> float:
        """How much contact changes: 0 for a motion without any about the state of rest, or more."""
        return self.virial - self.other_virial + self.touch

    def virial_error(self, omega: float) -> float:
        """Relative error of omega^2 m^ = k^ + virial, which every exact free motion obeys."""
        return abs(omega**2 * self.mass - self.stiffness - self.virial) / self.stiffness


@dataclass(frozen=True, slots=True)
class ModalEnergy:
    """Energies of motions of the modal coordinates.

    Attributes:
        mechanics: What a motion obeys.
        series: Series in time.
    """

    mechanics: Mechanics
    series: Series

    def gamma(self, at: Unknowns) -> float:
        """Modal energy coordinate gamma = m^ / 2."""
        return float(np.sum(self.weight * at.q**2) / 2)

    def gamma_gradient(self, at: Unknowns) -> Unknowns:
        """Derivatives of gamma by coefficients and parameters."""
        return Unknowns(self.weight * at.q, np.zeros(len(at.parameters)))

    def energies(self, at: Unknowns, forces: ContactForces) -> Energies:
        """Energies of the motion; the strain energy of R is the mean of lambda^T R lambda."""
        model, rest = self.mechanics.model, self.mechanics.rest
        weight = forces.instants.weight(self.series)
        mean_square = self.series.mean_square[:, None]
        change = forces.force - rest.force
        residual_part = np.sum((change @ model.R) * change, axis=1)
        lifted = float(weight @ (self._clearance(at, forces) @ rest.force))
        motion, bent_mass = SampledMotion(self.series, at.q, at.omega), self._bent_mass(at.q)
        other = sum(force.mean_virial(motion) for force in self.mechanics.acting)
        other += model.kinematics.closing.mean_bending_work(self.series, at.q, forces)
        return Energies(
            stiffness=float(
                np.sum(mean_square * (model.omega * rest.motion_from(at.q)) ** 2)
                + weight @ residual_part
            ),
            mass=2 * self.gamma(at),
            virial=float(weight @ (forces.force @ rest.clearance)) + lifted + other,
            lifted=lifted,
            touch=float(weight @ forces.force[:, rest.touching].sum(axis=1)) * rest.scale,
            potential=sum(float(f.mean_energy(motion)) for f in self.mechanics.acting)
            - at.omega**2 * bent_mass / 2,
            other_virial=float(other),
            bent_mass=bent_mass,
        )

    @property
    def weight(self) -> Array:
        """Mean square of each basis function times n^2, shape (c, 1)."""
        return (self.series.mean_square * self.series.order**2)[:, None]

    def _bent_mass(self, q: Array) -> float:
        """<q'^T (M(q) - 1) q'> with derivatives by the phase."""
        samples, inertia = CubicSamples.of(self.series), self.mechanics.model.kinematics.inertia
        displacement, velocity, _ = samples.states(q, 1.0)
        added = inertia.momentum(displacement, velocity) - velocity
        return float(samples.weight @ np.sum(velocity * added, axis=1))

    def _clearance(self, at: Unknowns, forces: ContactForces) -> Array:
        """Clearances at the samples of the points that are closed at rest, else 0."""
        model, rest = self.mechanics.model, self.mechanics.rest
        if not rest.closed.any():
            return np.zeros_like(forces.force)
        free = forces.instants.synthesis(self.series) @ (at.q @ model.Phi.T)
        clearance = model.gap - free + forces.force @ model.R
        return np.where(rest.closed & (forces.force == 0), clearance, 0.0)
