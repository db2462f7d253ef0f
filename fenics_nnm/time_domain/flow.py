"""Motion of a reduced model in time, exact but for round-off.

Between changes of contact the motion is linear; the instants of change are found by root finding.
The vector field is continuous, so nothing jumps at a change: the derivative of the flow is the
product of those of the linear stages, and the small error of an instant enters the state squared.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.rest import RestState
from fenics_nnm.time_domain.integrator import Trajectory
from fenics_nnm.time_domain.linear_stage import LinearStage
from fenics_nnm.time_domain.record import Record
from fenics_nnm.time_domain.stage_book import StageBook


@dataclass(frozen=True, slots=True)
class Flow:
    """The flow of a model with massless contact points; it keeps the linear stages that it met.

    Attributes:
        model: Reduced model, R > 0.
        most_changes: A motion with more changes of contact than this is given up.

    Raises:
        ModelError: if contact points carry mass: what follows an impact is then not defined.
    """

    model: ReducedModel
    most_changes: int = 20_000
    _book: StageBook[LinearStage] = field(init=False, repr=False, compare=False)
    _rest: RestState = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        model = self.model
        book = StageBook(model, model.Phi, lambda active: LinearStage.of(model, active))
        object.__setattr__(self, "_book", book)
        object.__setattr__(self, "_rest", self.model.at_rest())

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
        """Follow the motion from a state for a time; see `Integrator.run`."""
        record = Record(times, self.model.modes, along, speeds=speeds)
        if not np.all(np.isfinite([*q, *velocity, span])):
            return record.trajectory(q, velocity, 0, "the state to start from is not finite")
        clock, stage = 0.0, None
        for changes in range(self.most_changes + 1):
            stage = self._book.after(q, velocity, stage)
            motion = stage.motion(q, velocity)
            duration = motion.end(2 * self._book.moment, span - clock)
            record.note(motion, clock, duration)
            q, velocity = motion.state(duration)
            clock += duration
            if clock >= span:
                return record.trajectory(q, velocity, changes, "")
        return record.trajectory(
            q,
            velocity,
            self.most_changes,
            f"more than {self.most_changes} changes of contact in {clock:.3g} of {span:.3g} s",
        )

    def forces(self, q: Array) -> Array:
        """Contact forces in N at states of shape (s, J), shape (s, n_c)."""
        return self._book.forces(q)

    @property
    def error(self) -> float:
        """Round-off."""
        return 1e-13

    @property
    def cheap(self) -> bool:
        """All motions are followed for ten periods."""
        return True

    @property
    def rough(self) -> Flow:
        """Itself: it is as cheap as it can be."""
        return self

    def acceleration(self, q: Array, velocity: Array) -> Array:
        """Acceleration -omega^2 q - Phi^T lambda(q), shape (J,)."""
        return -self._book.at(q).pull(q)

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of the energy: omega^2 q + Phi^T lambda(q) by q, then q', shape (2 J,)."""
        return np.concatenate([self._book.at(q).pull(q), velocity])

    def energy(self, q: Array, velocity: Array) -> float:
        """Total energy in J, constant in time, from the state of rest (q_s, lambda_s).

        With x = q - q_s, mu = lambda - lambda_s and c the clearances it is
        (x'^2 + (omega x)^2 + mu^T R mu) / 2 + lambda_s . c.
        """
        force, rest = self._book.at(q).forces(q), self._rest
        modal = velocity @ velocity + np.sum((self.model.omega * (q - rest.q)) ** 2)
        change = force - rest.force
        energy = float(modal + change @ self.model.R @ change) / 2
        if not rest.closed.any():
            return energy
        clearance = self.model.gap - self.model.Phi @ q + self.model.R @ force
        return energy + float(np.where(force == 0, clearance, 0.0) @ rest.force)
