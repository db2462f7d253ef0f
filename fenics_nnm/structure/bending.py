"""Second-order kinematics of a body: how it gets them, and for which gaps they hold as well."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.contact_sites import ContactSites
from fenics_nnm.fem.deflection import BodyForces
from fenics_nnm.fem.linear import operators_of
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.obstacle_curvature import obstacle_closing
from fenics_nnm.fem.solid import Solid
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.reduction.modal_derivatives import Deflection, with_second_order
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.structure.point_choice import Choices, chosen_of


class Bendable(Protocol):
    """A body with its contact points and its reduced model."""

    @property
    def solid(self) -> Solid:
        """Assembled body."""

    @property
    def interface(self) -> ContactInterface:
        """Contact points."""

    @property
    def sites(self) -> ContactSites:
        """Vertices of the contact patches."""

    @property
    def choices(self) -> Choices:
        """Which of them are contact points."""

    @property
    def forces(self) -> BodyForces:
        """Derivatives of its internal force."""

    @property
    def reduction(self) -> Reduction:
        """Reduced model, and the way back to the body."""

    @property
    def model(self) -> ReducedModel:
        """Reduced model."""

    def largest_displacement(self, q: Array, force: Array) -> float:
        """Largest displacement in m, of coordinates in kg^1/2 m and forces in N; on all ranks."""


@dataclass(frozen=True, slots=True)
class Bending:
    """Reduced models of a body to choose from.

    Attributes:
        straight: With linear kinematics.
        bent: With second-order kinematics of the followed mode, or of the masters of the study;
            `straight` where there are none. Of the followed mode alone where contact points carry
            mass, as the other modes are not those of the body then.
        mode: Index of the followed mode of `straight`.
    """

    straight: Reduction
    bent: Reduction
    mode: int

    @property
    def masters(self) -> Indices:
        """Places of the modes that bend the body, none where that is not known."""
        return self.bent.model.kinematics.masters

    @property
    def own(self) -> int:
        """Index of the followed mode of `bent`."""
        return min(self.mode, self.bent.model.modes - 1)

    def at_gaps(self, body: Bendable) -> Bending:
        """The same with the gaps and obstacles of a body whose contact points have the same rows.

        Args:
            body: The body with its new contact points; its reduction does not matter.
        """
        gap = body.interface.gap
        straight = self.straight.with_gap(gap)
        if not len(self.masters):
            return Bending(straight, straight, self.mode)
        bent, tensors = self.bent.with_gap(gap), self.bent.model.kinematics.tensors
        order = SecondOrder(self.masters, **{**tensors, "Theta": self._closing(body)})
        found = replace(bent, model=replace(bent.model, kinematics=order))
        return Bending(straight, found, self.mode)

    def _closing(self, body: Bendable) -> Array:
        """Second derivatives of the closing of contact points by the masters, (n_c, k, k)."""
        place, phi = Pairs.of(len(self.masters)).place, self.bent.shapes[:, self.masters]
        moved = body.interface.displacement(self.bent.bent_shapes)[:, place]
        return moved + _obstacle(body, phi)


def bent(body: Bendable, reduction: Reduction, masters: Indices, solver: ModalSolver) -> Reduction:
    """A linear reduction of a body with second-order kinematics of some masters; on all ranks.

    Raises:
        ModelError: if its internal force has no potential.
    """
    operators = operators_of(body.solid, body.interface, solver)
    operators = body.forces.remembering(operators, type(solver).__name__)
    return with_second_order(reduction, masters, operators, deflection_of(body))


def of_mode_alone(reduction: Reduction, mode: int) -> Reduction:
    """A reduction with one of its modes, and nothing that follows it."""
    model = reduction.model
    omega, Phi = model.omega[[mode]], model.Phi[:, [mode]]
    alone = replace(model, omega=omega, Phi=Phi)
    return replace(reduction, model=alone, shapes=reduction.shapes[:, [mode]], added=0)


def deflection_of(body: Bendable) -> Deflection:
    """What large deflection adds to the internal force of a body, and its curved obstacles."""
    forces = body.forces
    return Deflection(forces.second, forces.third, partial(_obstacle, body))


def _obstacle(body: Bendable, shapes: Array) -> Array:
    """How much the curvature of obstacles closes contact points, shape (n_c, k, k)."""
    return obstacle_closing(body.interface, body.sites, chosen_of(body.choices), shapes)
