"""Displacement of all nodes by the coordinates of a reduced model, to find the largest one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.motion import Motion, forces_at
from fenics_nnm.mechanics.pairs import Pairs

#: Instants of a period that are looked at; the first is an extreme of a motion without phase.
_INSTANTS = 96


@dataclass(frozen=True, slots=True)
class DisplacementBasis:
    """The displacement of n nodes with d components, as `Reduction` has it.

    Attributes:
        shapes: Displacement per modal coordinate, kg^-1/2, shape (J, n, d).
        residual: Displacement per unit contact force, m/N, shape (n_c, n, d).
        bent: Second-order shapes of pairs of masters, shape (p, n, d); none without masters.
    """

    shapes: Array
    residual: Array
    bent: Array

    def largest(self, model: ReducedModel, series: Series, motion: Motion) -> float:
        """Largest distance in m of any node from rest over a period.

        Args:
            model: Model that the motion obeys, in SI units.
            series: Series that it is written in.
            motion: Motion.
        """
        return self.largest_at(model, series, motion)[0]

    def largest_at(self, model: ReducedModel, series: Series, motion: Motion) -> tuple[float, int]:
        """The same, and the number of the node from 0."""
        phase = 2 * np.pi * np.arange(_INSTANTS) / _INSTANTS
        q = series.basis_at(phase) @ motion.q
        forces = forces_at(model, series, motion, phase)
        masters = model.kinematics.masters
        pairs = Pairs.of(len(masters)).products(q[:, masters])
        found = (self._largest(q[s], forces[s], pairs[s]) for s in range(_INSTANTS))
        return max(found, key=lambda each: each[0])

    def _largest(self, q: Array, force: Array, products: Array) -> tuple[float, int]:
        """Largest distance at an instant, and its node."""
        moved = np.tensordot(q, self.shapes, 1) - np.tensordot(force, self.residual, 1)
        if len(products):
            moved += np.tensordot(products, self.bent, 1)
        square = np.sum(moved**2, axis=-1)
        node = int(np.argmax(square))
        return float(np.sqrt(square[node])), node
