"""A reduced model and the way back to the whole structure."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.force import AddedForce
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.mechanics.second_order_effect import UNASKED, KinematicsChoice
from fenics_nnm.reduction.truncation import Truncation


@dataclass(frozen=True, slots=True)
class Reduction:
    """A reduced model and the way back to the displacement of the whole structure.

    With modal coordinates q and contact forces lambda the displacement in m is

        u = shapes q + 1/2 sum theta_ij q_i q_j - residual_shapes lambda,

    the sum over masters of second-order kinematics, if there are any.

    Attributes:
        model: Reduced model.
        shapes: Displacement per modal coordinate, kg^-1/2, shape (n, J), signed so that the contact
            point that moves most moves towards its obstacle; n degrees of freedom, of this rank.
        residual_shapes: Displacement per unit contact force that these do not bring, m/N,
            shape (n, n_c); zero where the contact points carry mass.
        truncation: What the model leaves out, for an error estimate; None where it is not known.
        forces: Forces besides contact that the motion determines.
        attached: Displacement of further points with forces per modal coordinate, shape (p, J).
        bent_shapes: theta_ij of pairs i <= j of masters, (0, 0), (0, 1) .. (1, 1) and so on, in
            1/(kg m), shape (n, k (k + 1) / 2); none with linear kinematics.
        choice: Which kinematics it has, and why.
        added: So many of the last shapes were added for points with forces, and are no modes.
    """

    model: ReducedModel
    shapes: Array
    residual_shapes: Array
    truncation: Truncation | None
    forces: tuple[AddedForce, ...] = ()
    attached: Array = field(default_factory=lambda: np.zeros((0, 0)))
    bent_shapes: Array = field(default_factory=lambda: np.zeros((0, 0)))
    choice: KinematicsChoice = UNASKED
    added: int = 0

    @property
    def free(self) -> int:
        """Number of free modes among the coordinates of the model, which come first."""
        return self.model.modes - self.added

    def displacement(self, q: Array, force: Array) -> Array:
        """Displacement u in m, shape (n,), of coordinates (J,) and contact forces in N (n_c,)."""
        linear = np.asarray(self.shapes @ q - self.residual_shapes @ force)
        masters = self.model.kinematics.masters
        if not len(masters):
            return linear
        return linear + self.bent_shapes @ Pairs.of(len(masters)).products(q[masters])

    def with_gap(self, gap: Array) -> Reduction:
        """The same with other gaps in m, shape (n_c,), which enter the model as they are."""
        return replace(self, model=replace(self.model, gap=gap, reference=None))

    def first_modes(self, count: int) -> Reduction:
        """The massless-boundary reduction with the lowest modes alone, as if made with these.

        Raises:
            TypeError: if the contact points carry mass: fewer modes span another basis then.
        """
        if self.forces or self.truncation is None:
            raise TypeError("shapes that were added for points with forces are no modes")
        omega, Phi = self.model.omega[count:], self.model.Phi[:, count:]
        return replace(
            self,
            model=self.model.with_modes(np.arange(count)),
            bent_shapes=self._bent_with(count),
            shapes=self.shapes[:, :count],
            residual_shapes=self.residual_shapes + (self.shapes[:, count:] / omega**2) @ Phi.T,
            truncation=self.truncation.without(omega, Phi),
        )

    def _bent_with(self, count: int) -> Array:
        """Theta with the shapes of the modes above the lowest, which follow statically then."""
        tensors, pairs = self.model.kinematics.tensors, Pairs.of(len(self.model.kinematics.masters))
        if not tensors:
            return self.bent_shapes
        alpha = tensors["alpha"][count:, pairs.first, pairs.second]
        follows = -2 * alpha / self.model.omega[count:, None] ** 2
        return np.asarray(self.bent_shapes + self.shapes[:, count:] @ follows)
