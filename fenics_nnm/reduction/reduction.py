"""A reduced model and the way back to the whole structure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.reduction.model import ReducedModel
from fenics_nnm.reduction.truncation import Truncation


@dataclass(frozen=True, slots=True)
class Reduction:
    """A reduced model and the way back to the displacement of the whole structure.

    With modal coordinates q and contact forces lambda the displacement in m is

        u = shapes q - residual_shapes lambda.

    Attributes:
        model: Reduced model.
        shapes: Displacement per modal coordinate, kg^-1/2, shape (n, J), signed so that the contact
            point that moves most moves towards its obstacle; n degrees of freedom, of this rank.
        residual_shapes: Displacement per unit contact force that these do not bring, m/N,
            shape (n, n_c); zero where the contact points carry mass.
        truncation: What the model leaves out, for an error estimate.
    """

    model: ReducedModel
    shapes: Array
    residual_shapes: Array
    truncation: Truncation

    def displacement(self, q: Array, force: Array) -> Array:
        """Displacement u in m, shape (n,), of coordinates (J,) and contact forces in N (n_c,)."""
        return np.asarray(self.shapes @ q - self.residual_shapes @ force)
