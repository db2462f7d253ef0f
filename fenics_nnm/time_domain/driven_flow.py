"""What follows damped, driven motions in time: exactly, or by steps where a body bends far."""

from __future__ import annotations

from typing import Protocol, Self

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.bent_flow import BentFlow
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.integrator import Trajectory


class DrivenFlow(Protocol):
    """The flow of a damped, driven model whose contact points carry no mass."""

    @property
    def model(self) -> ReducedModel:
        """Reduced model."""

    @property
    def drive(self) -> Drive:
        """Harmonic forces, and motions of the gaps."""

    def at(self, omega: float) -> Self:
        """The same driven at another circular frequency in rad/s."""

    def driven_by(self, drive: Drive) -> Self:
        """The same under other forces."""

    def run(
        self,
        q: Array,
        velocity: Array,
        span: float,
        *,
        times: Array | None = None,
        along: Array | None = None,
        speeds: bool = False,
        phase: float = 0.0,
    ) -> Trajectory:
        """Follow the motion from a state for a time; see `DampedFlow.run`."""

    def energy(self, q: Array, velocity: Array, phase: float = 0.0) -> float:
        """Total energy in J from the state of rest, without the potential of the drive."""


def has_equations_in_time(mechanics: Mechanics) -> bool:
    """Whether its motion in time can be followed: points without mass, and no further springs."""
    model = mechanics.model
    bent = len(model.kinematics.masters) > 0
    open_at_rest = not (bent and mechanics.rest.pressed)
    return (
        _without_springs(mechanics) and mechanics.linear.in_time and model.massless and open_at_rest
    )


def driven_flow(mechanics: Mechanics, omega: float) -> DrivenFlow:
    """The flow of what a motion obeys, driven at a circular frequency in rad/s.

    Raises:
        ModelError: if contact points carry mass, or forces besides contact and second-order
            kinematics depend on the motion; with these also if points are pressed at rest.
    """
    if not _without_springs(mechanics):
        raise ModelError(
            "springs that are not linear: a driven motion in time needs contact and large "
            "deflection alone"
        )
    if len(mechanics.model.kinematics.masters):
        return BentFlow.of(mechanics, omega)
    return DampedFlow.of(mechanics, omega)


def _without_springs(mechanics: Mechanics) -> bool:
    return len(mechanics.forces) == len(mechanics.model.kinematics.forces)
