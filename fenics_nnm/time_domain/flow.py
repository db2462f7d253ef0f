"""Motion of a reduced model in time, exact but for round-off.

Between changes of contact the motion is linear; the instants of change are found by root finding.
The vector field is continuous, so nothing jumps at a change: the derivative of the flow is the
product of those of the linear stages, and the small error of an instant enters the state squared.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.closed import highest_frequency
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.rest import RestState
from fenics_nnm.time_domain.integrator import Trajectory
from fenics_nnm.time_domain.linear_stage import LinearStage, StageMotion

#: The points in contact after a change are those a moment later: this over the highest frequency.
#: Changes that lie closer together count as one; the state is in error by the square of it.
_MOMENT = 1e-9

#: Stages that are kept; they are all forgotten when there are more.
_STAGES_KEPT = 2000

#: Stages that are tried for a state before its forces are found from scratch.
_RECENT = 4


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
    _law: Complementarity = field(init=False, repr=False, compare=False)
    _rest: RestState = field(init=False, repr=False, compare=False)
    _moment: float = field(init=False, repr=False, compare=False)
    _stages: dict[bytes, LinearStage] = field(
        init=False, repr=False, compare=False, default_factory=dict
    )

    _recent: list[LinearStage] = field(init=False, repr=False, compare=False, default_factory=list)

    def __post_init__(self) -> None:
        if not self.model.massless:
            raise ModelError("the motion in time needs contact points without mass: R is singular")
        object.__setattr__(self, "_law", Complementarity(self.model.R, self.model.gap))
        object.__setattr__(self, "_rest", self.model.at_rest())
        object.__setattr__(self, "_moment", _MOMENT / highest_frequency(self.model))

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
        wanted = np.empty(0) if times is None else np.asarray(times)
        record = _Record(wanted, self.model.modes, along, speeds=speeds)
        if not np.all(np.isfinite([*q, *velocity, span])):
            return record.trajectory(q, velocity, 0, "the state to start from is not finite")
        clock, stage = 0.0, None
        for changes in range(self.most_changes + 1):
            stage = self._stage_after(q, velocity, stage)
            motion = stage.motion(q, velocity)
            duration = motion.end(2 * self._moment, span - clock)
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
        return self._law(q @ self.model.Phi.T).force

    def acceleration(self, q: Array, velocity: Array) -> Array:
        """Acceleration -omega^2 q - Phi^T lambda(q), shape (J,)."""
        return -self._stage_at(q).pull(q)

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of the energy: omega^2 q + Phi^T lambda(q) by q, then q', shape (2 J,)."""
        return np.concatenate([self._stage_at(q).pull(q), velocity])

    def energy(self, q: Array, velocity: Array) -> float:
        """Total energy in J, constant in time, from the state of rest (q_s, lambda_s).

        With x = q - q_s, mu = lambda - lambda_s and c the clearances it is
        (x'^2 + (omega x)^2 + mu^T R mu) / 2 + lambda_s . c.
        """
        force, rest = self._stage_at(q).forces(q), self._rest
        modal = velocity @ velocity + np.sum((self.model.omega * (q - rest.q)) ** 2)
        change = force - rest.force
        energy = float(modal + change @ self.model.R @ change) / 2
        if not rest.closed.any():
            return energy
        clearance = self.model.gap - self.model.Phi @ q + self.model.R @ force
        return energy + float(np.where(force == 0, clearance, 0.0) @ rest.force)

    def _stage_after(self, q: Array, velocity: Array, before: LinearStage | None) -> LinearStage:
        """The stage that a state is about to be in; most often one point opens or closes."""
        soon = q + self._moment * velocity
        if before is not None:
            changed = self._stage(before.toggled(soon))
            if changed.holds(soon):
                return changed
        return self._stage_at(soon)

    def _stage_at(self, q: Array) -> LinearStage:
        """The stage of coordinates of shape (J,).

        The forces at a state are unique: a stage with positive margins is the right one. Most
        often it is one of the last states asked for.
        """
        stage = next((known for known in self._recent if known.holds(q)), None)
        if stage is None:
            stage = self._stage(self._law((self.model.Phi @ q)[None]).force[0] > 0)
        others = [known for known in self._recent if known is not stage]
        self._recent[:] = [stage, *others[: _RECENT - 1]]
        return stage

    def _stage(self, active: NDArray[np.bool_]) -> LinearStage:
        """The stage with given points in contact."""
        key = active.tobytes()
        if key not in self._stages:
            if len(self._stages) >= _STAGES_KEPT:
                self._stages.clear()
            self._stages[key] = LinearStage.of(self.model, active)
        return self._stages[key]


class _Record:
    """What is wanted of a motion, collected stage by stage."""

    def __init__(self, times: Array, modes: int, along: Array | None, *, speeds: bool) -> None:
        self._times = times
        self._q = np.full((len(times), modes), np.nan)
        self._velocity = np.full((len(times), modes), np.nan)
        self._transition = along
        self._contact_time = 0.0
        self._speed_integral = 0.0 if speeds else float("nan")

    def note(self, motion: StageMotion, clock: float, duration: float) -> None:
        """Take what lies between `clock` and `duration` later."""
        if len(self._times):
            first = np.searchsorted(self._times, clock)
            last = np.searchsorted(self._times, clock + duration, side="right")
            chosen = slice(first, last)
            states = motion.states(self._times[chosen] - clock)
            self._q[chosen], self._velocity[chosen] = states
        if self._transition is not None:
            self._transition = motion.stage.carried(self._transition, duration)
        self._contact_time += duration * motion.stage.contact
        if not np.isnan(self._speed_integral):
            self._speed_integral += motion.speed_integral(duration)

    def trajectory(self, q: Array, velocity: Array, changes: int, failure: str) -> Trajectory:
        """The result, with the final state."""
        return Trajectory(
            q=q,
            velocity=velocity,
            changes=changes,
            contact_time=self._contact_time,
            q_at=self._q,
            velocity_at=self._velocity,
            speed_integral=self._speed_integral,
            transition=self._transition,
            failure=failure,
        )
