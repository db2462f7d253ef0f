"""A driven structure: what its motion obeys, and where it is watched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import Force
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel


@dataclass(frozen=True, slots=True)
class DrivenStructure:
    r"""A damped structure under harmonic forces at some points, as long as it touches nothing.

        q'' + C q' + Lambda q + f(q) = sum_p psi_p^T Re(F_p exp(i omega t)),      w = Phi q

    Attributes:
        model: Reduced model, Lambda = diag(omega_j^2), whose gaps are all positive.
        rate: C in 1/s, shape (J, J).
        excited: psi, displacement of the excited points along their forces per modal coordinate,
            kg^-1/2, shape (p, J).
        amplitudes: F, complex amplitudes of the forces in N, 0-peak, shape (p,).
        forces: f, forces that the motion determines.
    """

    model: ReducedModel
    rate: Array
    excited: Array
    amplitudes: Complex
    forces: tuple[Force, ...] = ()

    @property
    def mechanics(self) -> Mechanics:
        """What its motion obeys."""
        force = self.amplitudes @ self.excited
        return Mechanics(
            self.model,
            self.model.at_rest(),
            RatedPart(self.model.omega, self.rate),
            self.forces,
            (Excitation(1, force.real, -force.imag),),
        )

    @property
    def monitors(self) -> tuple[str, ...]:
        """Names of the points that are watched: excited ones, then contact points."""
        excited = _numbered("excitation", len(self.excited))
        return (*excited, *(f"contact {n + 1}" for n in range(self.model.points)))

    @property
    def watched(self) -> Array:
        """Displacement of these points per modal coordinate, shape (p + n_c, J)."""
        return np.vstack([self.excited, self.model.Phi])


def _numbered(name: str, count: int) -> tuple[str, ...]:
    """A name for each of several, without a number where there is only one."""
    return (name,) if count == 1 else tuple(f"{name} {n + 1}" for n in range(count))
