r"""Condensed linear systems with second-order kinematics: masters are kept, all others eliminated.

To the Jacobian of `condensed` second-order kinematics add, with m the masters,

    * T dq: derivatives of forces on the coordinates, between masters, and between them and others,
      with lambda . Theta among the masters;
    * Psi = Phi + Theta q in place of Phi in U and V, which differs in the columns of masters alone.

So masters are coordinates that are kept, beside those in resonance: what is eliminated is as it
was, and the table of dynamic flexibility serves again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.linear_part import HarmonicOperator
from fenics_nnm.mechanics.master_tangent import MasterTangent
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.condensed import Condensation, eliminated


@dataclass(frozen=True, slots=True)
class Bending:
    """What second-order kinematics add to a system.

    Attributes:
        turned: Theta q of the pairs in contact, at their samples, shape (P, k).
        tangent: T.
    """

    turned: Array
    tangent: MasterTangent

    @property
    def masters(self) -> Indices:
        """Places of the masters, shape (k,)."""
        return self.tangent.masters


def bent_solution(
    operator: HarmonicOperator,
    series: Series,
    Phi: Array,
    forces: ContactForces,
    bending: Bending,
    border: Border,
) -> Array:
    """Solution of the bordered system of the Jacobian, q first, shape (c J + b,).

    Args:
        operator: Linear part at the frequency, separate.
        series: Series in time.
        Phi: Displacement of the contact points per modal coordinate, shape (n_c, J).
        forces: Contact forces.
        bending: What second-order kinematics add.
        border: Further unknowns and equations, and right-hand sides.

    Raises:
        numpy.linalg.LinAlgError: if the system is singular.
    """
    base = Condensation.of(operator.keeping(bending.masters), series, Phi, forces)
    return eliminated(_BentCondensation(operator, base, bending), border)


@dataclass(frozen=True, slots=True)
class _BentCondensation:
    """The elimination.

    Attributes:
        whole: Z of all coordinates.
        base: Elimination of what is no master, and not in resonance.
        bending: What second-order kinematics add.
    """

    whole: HarmonicOperator
    base: Condensation
    bending: Bending

    @property
    def operator(self) -> HarmonicOperator:
        """Z of what is eliminated; masters are kept."""
        return self.base.operator

    def flexibility(self) -> Array:
        """F + M, shape (P, P)."""
        return self.base.flexibility()

    def acted(self, q: Array) -> Array:
        """Z q and T q, shape (.., c, J)."""
        return self.whole.times(q) + self.coupled(q)

    def coupled(self, q: Array) -> Array:
        """T q of coefficients (.., c, J)."""
        return self.bending.tangent.times(q)

    def moved(self, q: Array) -> Array:
        """V q: free displacements of the pairs, shape (.., P)."""
        base, masters = self.base, self.bending.masters
        at_samples = base.series.synthesis[base.forces.samples] @ q[:, :, masters]
        turned = np.sum(at_samples[:, base.sample] * self.bending.turned, axis=2)
        return base.moved(q) + turned

    def pushed(self, pairs: Array) -> Array:
        """U lambda: what forces of the pairs do to the equations, shape (.., c, J)."""
        base, masters = self.base, self.bending.masters
        found = base.pushed(pairs)
        analysis = base.series.analysis[:, base.forces.samples[base.sample]]
        found[:, :, masters] += analysis @ (pairs[:, :, None] * self.bending.turned)
        return found
