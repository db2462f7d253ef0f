"""A motion that an iteration ended with."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.nonlinear.energies import Energies
from fenics_nnm.nonlinear.equations import Equations
from fenics_nnm.nonlinear.unknowns import Unknowns


@dataclass(frozen=True, slots=True)
class Solution:
    """A motion that Newton's iteration ended with.

    Attributes:
        at: Coefficients, shape (c, J), and parameters.
        forces: Contact forces at the samples.
        free: Harmonics of the free displacement of the contact points, shape (c, n_c); what
            they move is this less R lambda.
        energies: Energies.
        residual: Relative residual.
        iterations: Newton steps taken.
        failure: Empty where converged, else why not.
    """

    at: Unknowns
    forces: ContactForces
    free: Array
    energies: Energies
    residual: float
    iterations: int
    failure: str = ""

    @property
    def q(self) -> Array:
        """Coefficients, shape (c, J)."""
        return self.at.q

    @property
    def omega(self) -> float:
        """Circular frequency."""
        return self.at.omega

    @property
    def converged(self) -> bool:
        """Whether the tolerance was met."""
        return not self.failure

    def with_q(self, q: Array) -> Solution:
        """The same with other coefficients."""
        return replace(self, at=Unknowns(q, self.at.parameters))

    def thinned(self) -> Solution:
        """The same without the derivative of its forces, which is most of its memory."""
        return replace(self, forces=ContactForces.alone(self.forces.force))

    def light(self) -> Solution:
        """The same without the factors that the derivative of its forces was computed with."""
        return replace(self, forces=self.forces.light())

    def completed(self, equations: Equations) -> Solution:
        """The same with the derivative of its forces."""
        return replace(self, forces=equations.forces(self.at, self.forces))


def evaluated(equations: Equations, at: Unknowns) -> Solution:
    """A motion as it is, whether it solves the equations or not, with their residual."""
    forces = equations.forces(at)
    return Solution(
        at=at,
        forces=forces,
        free=equations.free_harmonics(at),
        energies=equations.energy.energies(at, forces),
        residual=relative_residual(equations, at, equations.residual(at, forces)),
        iterations=0,
    )


def relative_residual(equations: Equations, at: Unknowns, residual: Array) -> float:
    """Norm of the residual as displacements, relative to that of the motion; inf at rest."""
    size = float(np.linalg.norm(equations.motion(at.q)))
    scaled = residual / equations.row_scale(at.omega)
    return float(np.linalg.norm(scaled)) / size if size else np.inf
