"""Forces on the modal coordinates over a whole period, besides contact.

Contact forces follow from a law at each sample (`mechanics.contact_law`), since flexibility that
the modes lack takes part in them. All other forces follow from the motion of the coordinates: a
force sees displacement, velocity and acceleration at all samples in order, and gives its harmonics
and their derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.master_tangent import MasterTangent


@dataclass(frozen=True, slots=True)
class SampledMotion:
    """A periodic motion of the coordinates: what a force sees of it.

    Attributes:
        series: Series in time.
        q: Coefficients, shape (c, J).
        omega: Circular frequency.
    """

    series: Series
    q: Array
    omega: float

    @property
    def displacement(self) -> Array:
        """Coordinates at the samples, shape (s, J)."""
        return self.series.synthesis @ self.q

    @property
    def velocity(self) -> Array:
        """Their velocities, shape (s, J)."""
        return self.omega * self.series.rate_at(self.series.phase) @ self.q

    @property
    def acceleration(self) -> Array:
        """Their accelerations, shape (s, J)."""
        return self.series.synthesis @ (-((self.series.order[:, None] * self.omega) ** 2) * self.q)


class PeriodicForce(Protocol):
    """A force on a periodic motion: its harmonics follow from those of the coordinates."""

    def harmonics(self, motion: SampledMotion) -> Array:
        """Its harmonics, on the left-hand side of the equations of motion, shape (c, J)."""

    def tangent(self, motion: SampledMotion) -> Array:
        """Derivative of the harmonics by the coefficients, shape (c J, c J), by (n, j)."""

    def by_omega(self, motion: SampledMotion) -> Array:
        """Derivative of the harmonics by the frequency, shape (c, J)."""

    def mean_virial(self, motion: SampledMotion) -> float:
        """Mean over the period of the force times the coordinates."""

    def mean_energy(self, motion: SampledMotion) -> float:
        """Mean over the period of the energy that it stores."""


class Force(PeriodicForce, Protocol):
    """A force that the motion of the coordinates determines, at any time."""

    def at(self, q: Array, velocity: Array) -> Array:
        """The force at states without acceleration, shape (.., J)."""

    def tangent_at(self, q: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array]:
        """Its derivatives by coordinates and velocities at states, each of shape (.., J, J)."""

    def energy_at(self, q: Array, velocity: Array) -> Array:
        """The energy that it stores at states of shape (.., J), shape (..)."""


class MasterForce(Force, Protocol):
    """A force that masters make, or that acts on them."""

    def master_tangent(self, motion: SampledMotion) -> MasterTangent:
        """Derivative of the harmonics, by its columns and rows of masters."""


class AddedForce(Force, Protocol):
    """A force that is given beside a reduced model, not by it."""

    def scaled(self, amplitude: float, energy: float) -> AddedForce:
        """The same in units of coordinates and energy of a dimensionless model."""

    def of_part(self, shapes: Array) -> AddedForce:
        """The force on a part of the model, whose coordinates move these by (J, k) shapes."""


@dataclass(frozen=True, slots=True)
class CubicSprings:
    r"""Springs with a force k3 x^3 along rows of shapes, x = psi q.

    The harmonics are exact where the series has m > 4 N samples: the cube of N harmonics, projected
    on N.

    Attributes:
        shapes: Displacement of each spring per modal coordinate (psi), kg^-1/2, shape (p, J).
        cubic: Cubic stiffnesses k3 in N/m^3, shape (p,).
    """

    shapes: Array
    cubic: Array

    def harmonics(self, motion: SampledMotion) -> Array:
        """Harmonics of psi^T k3 x^3, shape (c, J).

        Raises:
            ModelError: if the samples are too few for them to be exact.
        """
        series = motion.series
        if series.samples <= 4 * series.harmonics:
            raise ModelError(
                f"samples = {series.samples} with harmonics = {series.harmonics}: must be above 4 "
                "harmonics with cubic springs, whose force has three times as many"
            )
        force = self.cubic * self._moved(motion) ** 3
        return np.asarray(motion.series.analysis @ force @ self.shapes)

    def tangent(self, motion: SampledMotion) -> Array:
        """Derivative: sum_k A_nk S_kn' psi^T 3 k3 x_k^2 psi."""
        series, modes = motion.series, self.shapes.shape[1]
        stiffness = 3 * self.cubic * self._moved(motion) ** 2
        by_spring = np.einsum("ak,kp,kb->abp", series.analysis, stiffness, series.synthesis)
        whole = np.einsum("abp,pi,pj->aibj", by_spring, self.shapes, self.shapes, optimize=True)
        size = len(series.order) * modes
        return np.asarray(whole.reshape(size, size))

    def by_omega(self, motion: SampledMotion) -> Array:
        """It does not depend on the frequency."""
        return np.zeros_like(motion.q)

    def mean_virial(self, motion: SampledMotion) -> float:
        """<k3 x^4>."""
        return float(motion.series.weight @ (self._moved(motion) ** 4 @ self.cubic))

    def mean_energy(self, motion: SampledMotion) -> float:
        """<k3 x^4> / 4."""
        return self.mean_virial(motion) / 4

    def at(self, q: Array, velocity: Array) -> Array:
        """The force at states, shape (.., J)."""
        return np.asarray((self.cubic * (q @ self.shapes.T) ** 3) @ self.shapes)

    def tangent_at(self, q: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array]:
        """Its derivatives by coordinates and velocities at states."""
        stiffness = 3 * self.cubic * (q @ self.shapes.T) ** 2
        by_q = (self.shapes.T * stiffness[..., None, :]) @ self.shapes
        return by_q, np.zeros_like(by_q)

    def energy_at(self, q: Array, velocity: Array) -> Array:
        """Its potential at coordinates of shape (.., J), shape (..)."""
        return np.asarray((q @ self.shapes.T) ** 4 @ self.cubic / 4)

    def scaled(self, amplitude: float, energy: float) -> CubicSprings:
        """The same in units of coordinates (kg^1/2 m) and energy (J)."""
        return CubicSprings(self.shapes, self.cubic * amplitude**4 / energy)

    def of_part(self, shapes: Array) -> CubicSprings:
        """The force on a part of the model, whose coordinates move these by (J, k) shapes."""
        return CubicSprings(self.shapes @ shapes, self.cubic)

    def _moved(self, motion: SampledMotion) -> Array:
        """Displacements of the springs at the samples, shape (s, p)."""
        return motion.displacement @ self.shapes.T
