"""What a driven structure is reduced to."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import TooManyModesError
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.force import Force
from fenics_nnm.mechanics.kinematics import LINEAR, Kinematics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.mechanics.second_order_effect import UNASKED, KinematicsChoice
from fenics_nnm.reduction.attached import AttachedPoints, EnrichedModes, enriched
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.massless import massless_model
from fenics_nnm.reduction.operators import Operators, Product
from fenics_nnm.reduction.reduction import Reduction

#: What second-order kinematics need of contact points.
NEEDS_FLEXIBILITY = (
    "second-order kinematics need contact points that the modes leave flexibility of their own: "
    "must be fewer modes, or forces beside the contact points"
)


def undamped(columns: Array) -> Array:
    """No damping forces."""
    return np.zeros_like(columns)


@dataclass(frozen=True, slots=True)
class DrivenPlaces:
    """Places of a structure where forces act or displacements are watched.

    Attributes:
        springs: Points with springs that are not linear.
        excited: Unit forces at the excited places, shape (n, p).
        sizes: Sizes of the forces in N, 0-peak, shape (p,).
        monitored: Unit forces at the places that are watched besides, shape (n, w).
        dampers: Unit forces at the places of dashpots, and Coriolis forces of the lowest modes,
            whose static displacements the modes may lack, shape (n, d).
        contact: Unit contact forces, B^T, shape (n, n_c).
        gap: Gaps of the contact points in m, shape (n_c,).
        damping: C u in N s/m times m, of all dashpots and of a damping matrix, and Coriolis
            forces per unit rate.
        gap_motion: How gaps move, in harmonics of the speed.
    """

    springs: AttachedPoints
    excited: Array
    sizes: Array
    monitored: Array
    dampers: Array
    contact: Array
    gap: Array
    damping: Product = undamped
    gap_motion: GapMotion = STILL

    def turning(self, coriolis: Product, shapes: Array) -> DrivenPlaces:
        """The same with Coriolis forces.

        Args:
            coriolis: From shapes to their Coriolis forces, but for the sign, per unit rate, in N.
            shapes: Lowest modes, shape (n, J).
        """
        damping = self.damping
        return replace(
            self,
            dampers=np.hstack([self.dampers, coriolis(shapes)]),
            damping=lambda u: damping(u) + coriolis(u),
        )


@dataclass(frozen=True, slots=True)
class BentModes:
    """Free modes of a structure that bends far, or does not.

    Attributes:
        modes: Free modes, J of them.
        kinematics: Kinematics of a reduced model of these alone.
        theta: Modal derivatives of pairs of its masters, M-orthogonal to the modes, in 1/(kg m),
            shape (n, k (k + 1) / 2).
        choice: Which kinematics these are, and why.
    """

    modes: LinearModes
    kinematics: Kinematics
    theta: Array
    choice: KinematicsChoice = UNASKED

    @classmethod
    def straight(cls, modes: LinearModes, choice: KinematicsChoice = UNASKED) -> BentModes:
        """Those of a structure with linear kinematics."""
        return cls(modes, LINEAR, np.zeros((len(modes.shapes), 0)), choice)

    @classmethod
    def of(cls, modes: LinearModes, reduction: Reduction) -> BentModes:
        """Those of a reduction to free modes alone, which may have other signs."""
        signed, kinematics = replace(modes, shapes=reduction.shapes), reduction.model.kinematics
        return cls(signed, kinematics, reduction.bent_shapes, reduction.choice)


@dataclass(frozen=True, slots=True)
class DrivenBasis:
    """Free modes, and the shapes that static displacements under forces at places add to them.

    Attributes:
        model: Reduced model. Contact points have no mass, if the modes leave them flexibility of
            their own; else they move with the modes alone, and R = 0.
        modes: Number of free modes J; the shapes that were added come after them.
        excited: Displacement of the excited places, each along its force, per modal coordinate,
            kg^-1/2, shape (p, J').
        sizes: Sizes of the forces in N, 0-peak, shape (p,).
        monitored: The same of the places that are watched, shape (w, J').
        residual: Displacement of excited and watched places under unit contact forces that the
            modes do not bring, m/N, shape (p + w, n_c).
        rate: Damping matrix of dashpots and of a matrix, with Coriolis forces, in 1/s, shape
            (J', J').
        forces: Forces of springs that are not linear.
        shapes: Displacement per modal coordinate, kg^-1/2, shape (n, J').
        residual_shapes: Displacement per contact force that the modes do not bring, m/N,
            shape (n, n_c).
        gap_motion: How gaps move, in harmonics of the speed.
        bent: Second derivatives of the displacements of excited and watched places by the masters
            of second-order kinematics, in 1/(kg m), shape (p + w, k, k).
        bent_shapes: Modal derivatives of pairs of masters in 1/(kg m), shape (n, k (k + 1) / 2).
        choice: Which kinematics it has, and why.
    """

    model: ReducedModel
    modes: int
    excited: Array
    sizes: Array
    monitored: Array
    residual: Array
    rate: Array
    forces: tuple[Force, ...]
    shapes: Array
    residual_shapes: Array
    gap_motion: GapMotion
    bent: Array
    bent_shapes: Array
    choice: KinematicsChoice = UNASKED


def driven_basis(own: BentModes, places: DrivenPlaces, operators: Operators) -> DrivenBasis:
    """Reduce a driven structure.

    Args:
        own: Free modes, and what bending far adds to them.
        places: Where forces act and displacements are watched.
        operators: Products with the matrices of the structure.

    Raises:
        ModelError: if an excited place moves no mass.
        TooManyModesError: if they bend, and contact points have no flexibility of their own.
    """
    modes = own.modes
    points = places.springs.and_also(np.hstack([places.excited, places.dampers]))
    basis = enriched(modes.omega, modes.shapes, points.rows, operators)
    attached = operators.inner(points.rows, basis.shapes)
    static = operators.static(places.contact)
    watched = np.hstack([places.excited, places.monitored])
    shapes = operators.inner(watched, basis.shapes)
    excited = places.excited.shape[1]
    model = _model(basis, static, places.gap, operators)
    model, theta = _bent(model, basis, own, operators)
    place = Pairs.of(len(model.kinematics.masters)).place
    residual = operators.inner(watched, static) - (shapes / model.omega**2) @ model.Phi.T
    lacking = static - (basis.shapes / model.omega**2) @ model.Phi.T
    return DrivenBasis(
        model=model,
        modes=basis.free,
        excited=shapes[:excited],
        sizes=places.sizes,
        monitored=shapes[excited:],
        residual=residual if model.massless else np.zeros_like(residual),
        rate=operators.inner(basis.shapes, places.damping(basis.shapes)),
        forces=points.forces(attached),
        shapes=basis.shapes,
        residual_shapes=lacking if model.massless else np.zeros_like(lacking),
        gap_motion=places.gap_motion,
        bent=operators.inner(watched, theta)[:, place],
        bent_shapes=theta,
        choice=own.choice,
    )


def _bent(
    model: ReducedModel, basis: EnrichedModes, own: BentModes, operators: Operators
) -> tuple[ReducedModel, Array]:
    """The model with the kinematics of its free modes, and theta without the shapes added."""
    theta, free = own.theta, basis.free
    if not theta.shape[1]:
        return model, theta
    if not model.massless:
        raise TooManyModesError(NEEDS_FLEXIBILITY)
    added, place = basis.shapes[:, free:], Pairs.of(len(own.kinematics.masters)).place
    shared = -operators.inner(added, operators.mass(theta))
    kinematics = own.kinematics.among_more(
        model.omega[free:], model.Phi[:, free:], shared[:, place]
    )
    return replace(model, kinematics=kinematics), theta + added @ shared


def _model(basis: EnrichedModes, static: Array, gap: Array, operators: Operators) -> ReducedModel:
    """The reduced model, with massless contact points if the modes leave them flexible."""
    Phi, count = operators.contact(basis.shapes), len(gap)
    try:
        return massless_model(basis.omega, Phi, operators.contact(static), gap)
    except TooManyModesError:
        none = np.zeros((count, count))
        return ReducedModel(basis.omega, Phi, none, gap, contact=MASSIVE)
