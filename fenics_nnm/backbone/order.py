"""What the reduced model of a branch stands for: itself, or the whole model at full order."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.estimates import ReductionEstimate, no_error, reduction_estimate
from fenics_nnm.backbone.full_order_solver import FullOrderSolver
from fenics_nnm.backbone.level_solver import ComplementarySolver, MultiplierSolver
from fenics_nnm.backbone.levels import HarmonicBalance, Level, levels
from fenics_nnm.errors import Code, ModelError
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.force import AddedForce
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel, Scales
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.reduction.flexibility import FlexibilitySource, ResidualFlexibility
from fenics_nnm.reduction.truncation import Truncation
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.stepped import integrator_of


class Order(Protocol):
    """Reduced or full order."""

    @property
    def has_flow(self) -> bool:
        """Whether motions can be followed in time: the flow is that of a reduced model."""

    @property
    def doubt(self) -> str:
        """Why no motion can be verified, whatever integration in time says; or nothing."""

    def assert_fits(self, model: ReducedModel) -> None:
        """Refuse a model that the equations of this order do not hold for.

        Raises:
            ModelError: if there is a reason.
        """

    def flow(self, model: ReducedModel) -> Integrator | None:
        """What follows motions of the obeyed model in time; None where contact points have mass."""

    def obeyed(self, model: ReducedModel, balance: HarmonicBalance) -> ReducedModel:
        """The model that contact obeys."""

    def levels(
        self, model: ReducedModel, scales: Scales, balance: HarmonicBalance, *, mode: int
    ) -> tuple[Level, ...]:
        """Levels of a dimensionless model, coarse to fine."""

    def estimate(self, equations: HarmonicEquations, scales: Scales) -> ReductionEstimate:
        """From a solution of the finest level to the error of the reduction."""


@dataclass(frozen=True, slots=True)
class ReducedOrder:
    """The equations of the reduced model.

    Attributes:
        truncation: What the model leaves out, in SI units, for an error estimate of each point;
            None where it is not known.
        forces: Forces besides contact that the motion determines, in SI units.
        doubt: Why no motion can be verified, whatever integration in time says; or nothing.
    """

    truncation: Truncation | None = None
    forces: tuple[AddedForce, ...] = ()
    doubt: str = ""

    @property
    def has_flow(self) -> bool:
        """It has one where contact points carry no mass."""
        return True

    def assert_fits(self, model: ReducedModel) -> None:
        """Gaps must be positive with forces besides contact: the state of rest is without them."""
        if self.forces and model.gap.min() <= 0:
            raise ModelError(
                f"gap = {model.gap.min():g}: must be positive with springs that are not linear",
                code=Code.GAP_WITH_FORCES,
            )

    def flow(self, model: ReducedModel) -> Integrator | None:
        """The exact flow, or steps in time with forces besides contact; None with mass."""
        return integrator_of(Mechanics.of(model, self.forces))

    def obeyed(self, model: ReducedModel, balance: HarmonicBalance) -> ReducedModel:
        """The model itself."""
        return model

    def levels(
        self, model: ReducedModel, scales: Scales, balance: HarmonicBalance, *, mode: int
    ) -> tuple[Level, ...]:
        """Levels up to the model itself."""
        scaled = [force.scaled(scales.amplitude, scales.energy) for force in self.forces]
        return levels(model, balance, mode=mode, forces=scaled)

    def estimate(self, equations: HarmonicEquations, scales: Scales) -> ReductionEstimate:
        """What the truncation puts the frequency off by."""
        return reduction_estimate(self.truncation, equations, scales)


@dataclass(frozen=True, slots=True)
class FullOrder:
    """The equations of the whole model, massless boundary or, with multipliers, mass-carrying.

    Attributes:
        flexibility: Residual flexibility of the whole model, in SI units.
        doubt: Why no motion can be verified; or nothing.
    """

    flexibility: FlexibilitySource
    doubt: str = ""

    @property
    def has_flow(self) -> bool:
        """The flow would be that of the reduced model."""
        return False

    def assert_fits(self, model: ReducedModel) -> None:
        """Gaps must be positive, and kinematics linear."""
        if model.kinematics.forces:
            raise ModelError(
                "second-order kinematics need the massless reduction: full order is linear but for "
                "contact",
                code=Code.KINEMATICS_AT_FULL_ORDER,
            )
        if model.gap.min() <= 0:
            raise ModelError(
                f"gap = {model.gap.min():g}: must be positive at full order; gaps of any sign need "
                "the massless reduction",
                code=Code.FULL_ORDER_GAP,
            )

    def flow(self, model: ReducedModel) -> Integrator | None:
        """The flow of the reduced model: a bound on what the modes leave out."""
        return integrator_of(Mechanics.of(model))

    def obeyed(self, model: ReducedModel, balance: HarmonicBalance) -> ReducedModel:
        """With multipliers R is part of R(s)."""
        return contact_model(model, balance, full_order=True)

    def levels(
        self, model: ReducedModel, scales: Scales, balance: HarmonicBalance, *, mode: int
    ) -> tuple[Level, ...]:
        """Levels of the reduced model, and one of full order on the modes of the finest."""
        reduced = levels(model, balance, mode=mode)
        source = partial(_dimensionless, self.flexibility, scales)
        return (*reduced, _full_order(reduced[-1], source, balance))

    def estimate(self, equations: HarmonicEquations, scales: Scales) -> ReductionEstimate:
        """Nothing is left out."""
        return no_error


#: A reduced model of which it is not known what it leaves out.
REDUCED = ReducedOrder()


def contact_model(
    model: ReducedModel, balance: HarmonicBalance, *, full_order: bool
) -> ReducedModel:
    """The model that contact obeys: at full order with multipliers, R is part of R(s)."""
    if full_order and balance.multipliers is not None:
        return replace(model, R=np.zeros_like(model.R), contact=MASSIVE)
    return model


def _full_order(finest: Level, source: FlexibilitySource, balance: HarmonicBalance) -> Level:
    """Full order on the modes of the finest reduced level."""
    if balance.multipliers is None:
        return replace(finest, solver=FullOrderSolver(ComplementarySolver(), source))
    model = finest.equations.model
    obeyed = contact_model(model, balance, full_order=True)
    whole = partial(_with_static, source, model.R)
    return replace(
        finest,
        equations=replace(finest.equations, mechanics=Mechanics.of(obeyed)),
        solver=FullOrderSolver(MultiplierSolver(balance.multipliers), whole),
    )


def _dimensionless(source: FlexibilitySource, scales: Scales, omega: float) -> ResidualFlexibility:
    return source(omega * scales.omega).dimensionless(scales)


def _with_static(source: FlexibilitySource, R: Array, omega: float) -> ResidualFlexibility:
    return source(omega).with_static(R)
