"""Contact forces and energy of states, where motion is not linear between changes of contact."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_law import Complementarity, ContactForces
from fenics_nnm.mechanics.mechanics import Mechanics

#: Basis functions of a state by itself.
_AT_ONE = np.ones((1, 1))


@dataclass(frozen=True, slots=True)
class States:
    """What a state of modal coordinates q and velocities q' has.

    Attributes:
        mechanics: What a motion obeys.

    Raises:
        ModelError: if contact points carry mass, or points are pressed at rest.
    """

    mechanics: Mechanics
    _law: Complementarity = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        model = self.mechanics.model
        if not model.massless:
            raise ModelError("the motion in time needs contact points without mass")
        if self.mechanics.rest.pressed:
            raise ModelError("the motion in time by steps needs positive gaps")
        object.__setattr__(self, "_law", Complementarity(model.R, model.gap))

    def contact(self, q: Array) -> ContactForces:
        """Contact forces at coordinates of shape (J,)."""
        model = self.mechanics.model
        linear = (model.Phi @ q)[None]
        return self._law(model.kinematics.closing.displaced(linear, _AT_ONE, q[None]))

    def conservative(self, q: Array) -> Array:
        """omega^2 q + Psi^T lambda(q), shape (J,)."""
        model = self.mechanics.model
        shapes = model.kinematics.closing.shapes_at(model.Phi, q)
        return np.asarray(model.omega**2 * q + self.contact(q).force[0] @ shapes)

    def energy(self, q: Array, velocity: Array) -> float:
        """Total energy in J from the state of rest."""
        return self.energy_of(q, velocity, self.contact(q).force[0])

    def energy_of(self, q: Array, velocity: Array, force: Array) -> float:
        """The same with contact forces that are known, shape (n_c,)."""
        model = self.mechanics.model
        modal = velocity @ velocity + np.sum((model.omega * q) ** 2)
        stored = sum(each.energy_at(q, velocity) for each in self.mechanics.forces)
        return float(modal + force @ model.R @ force) / 2 + float(stored)

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of the energy: omega^2 q + Psi^T lambda(q) + f(q) by q, then p, (2 J,)."""
        inertia, at_rest = self.mechanics.model.kinematics.inertia, np.zeros_like(q)
        by_q = self.conservative(q) + sum(f.at(q, at_rest) for f in self.mechanics.forces)
        by_q = by_q + inertia.energy_gradient(q, velocity)
        return np.concatenate([by_q, inertia.momentum(q, velocity)])
