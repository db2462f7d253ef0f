"""What follows a motion in time: what shooting, multipliers and the check in time ask for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel


@dataclass(frozen=True, slots=True)
class Trajectory:
    """What a motion came to.

    Attributes:
        q: Modal coordinates at the end in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        changes: How often the set of points in contact changed.
        contact_time: Time with contact at some point in s.
        q_at: Coordinates at the wanted times, shape (len(times), J); nan after a failure.
        velocity_at: Velocities there.
        speed_integral: Integral of |velocity|^2 in J s; nan if not wanted.
        derivative: Gives the derivatives of the final (q, velocity) along changes of the first,
            shape (2 J, c); None if they are not wanted.
        failure: Empty, or why the motion was not followed to the end.
    """

    q: Array
    velocity: Array
    changes: int
    contact_time: float
    q_at: Array
    velocity_at: Array
    speed_integral: float
    derivative: Callable[[], Array] | None = None
    failure: str = ""

    @property
    def transition(self) -> Array | None:
        """Those derivatives, if wanted."""
        return self.derivative() if self.derivative else None


class Integrator(Protocol):
    """Follows motions of a model whose contact points carry no mass."""

    @property
    def model(self) -> ReducedModel:
        """Reduced model."""

    def run(
        self,
        q: Array,
        velocity: Array,
        span: float,
        *,
        times: Array | None = None,
        along: Array | None = None,
        speeds: bool = False,
    ) -> Trajectory:
        """Follow the motion from a state for a time.

        Args:
            q: Modal coordinates, shape (J,).
            velocity: Their velocities, shape (J,).
            span: Time in s, not negative.
            times: Ascending times from 0 to `span` at which the state is wanted.
            along: Changes of the first state as columns, shape (2 J, c), along which the
                derivative of the final state is wanted.
            speeds: Whether the integral of |velocity|^2 is wanted.
        """

    @property
    def error(self) -> float:
        """Bound of the error of a motion over a period, relative in the energy norm."""

    @property
    def cheap(self) -> bool:
        """Whether motions are followed for ten periods even if an exact one is found nearby."""

    @property
    def rough(self) -> Integrator:
        """The same for what is compared with parts of the motion, far above 1e-8, alone."""

    def acceleration(self, q: Array, velocity: Array) -> Array:
        """Acceleration of a state, shape (J,)."""

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of the energy by q and velocity, shape (2 J,)."""

    def energy(self, q: Array, velocity: Array) -> float:
        """Total energy in J from the state of rest, constant in time without damping."""
