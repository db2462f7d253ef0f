r"""Motion of a damped, driven model with second-order kinematics in time.

Between changes of contact the motion is that of `bent_stage`; steps of `bent_step` are exact in the
linear part, with damping and drive, so that their length follows from the remainder alone, as in
`collocated`, whose order and tolerance these are. Changes of contact are found by root finding.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.mechanics.closed import highest_frequency
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.bent_stage import BentStage
from fenics_nnm.time_domain.bent_step import BentRule, BentStep, Start
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.exponential_rule import gauss_nodes
from fenics_nnm.time_domain.integrator import Trajectory
from fenics_nnm.time_domain.kept import Kept
from fenics_nnm.time_domain.record import Record
from fenics_nnm.time_domain.states import States

#: As in `collocated`.
_MOMENT = 1e-9
_LONGEST_TURN, _TURN_ALONG = 40.0, 24.0
_FIRST, _SHORTEST = 1 / 8, 2.0**-30
_EASY, _PATIENCE = 1e-2, 6
_KEPT = 500


@dataclass(frozen=True, slots=True)
class _Memory:
    """What flows of one model under any drive keep."""

    stages: Kept[BentStage] = field(default_factory=lambda: Kept(_KEPT))
    rules: Kept[BentRule] = field(default_factory=lambda: Kept(_KEPT))


@dataclass(frozen=True, slots=True)
class BentFlow:
    """The flow of a damped, driven model with second-order kinematics; it keeps its stages.

    Attributes:
        mechanics: What a motion obeys, with viscous damping; its excitations do not matter.
        drive: Harmonic forces, and motions of the gaps.
        nodes: Gauss points of a step.
        tolerance: Highest coefficient of the remainder over a step, relative to the velocities of
            the motion, see `Collocated`.
        most_changes: A motion with more changes of contact than this is given up.

    Raises:
        ModelError: if contact points carry mass, or points are pressed at rest.
    """

    mechanics: Mechanics
    drive: Drive
    nodes: int = 16
    tolerance: float = 1e-9
    most_changes: int = 20_000
    states: States = field(init=False, repr=False, compare=False)
    _law: Complementarity = field(init=False, repr=False, compare=False)
    _moment: float = field(init=False, repr=False, compare=False)
    _memory: _Memory = field(init=False, repr=False, compare=False, default_factory=_Memory)

    def __post_init__(self) -> None:
        model = self.mechanics.model
        object.__setattr__(self, "states", States(self.mechanics))
        object.__setattr__(self, "_law", Complementarity(model.R, np.zeros(model.points)))
        object.__setattr__(self, "_moment", _MOMENT / highest_frequency(model))

    @classmethod
    def of(cls, mechanics: Mechanics, omega: float) -> BentFlow:
        """The flow of what a motion obeys, driven at a circular frequency in rad/s."""
        modes = mechanics.model.modes
        return cls(mechanics, Drive.of(omega, mechanics.excitations, modes, mechanics.gap_motion))

    @property
    def model(self) -> ReducedModel:
        """Reduced model."""
        return self.mechanics.model

    def at(self, omega: float) -> BentFlow:
        """The same, with its stages, driven at another circular frequency in rad/s."""
        return self.driven_by(self.drive.at(omega))

    def driven_by(self, drive: Drive) -> BentFlow:
        """The same, with its stages, under other forces."""
        other = replace(self, drive=drive)
        object.__setattr__(other, "_memory", self._memory)
        return other

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
        record = Record(times, self.model.modes, along, speeds=speeds)
        if not np.all(np.isfinite([*q, *velocity, span])):
            return record.trajectory(q, velocity, 0, "the state to start from is not finite")
        walk = _Walk(
            self, q, velocity, phase, record, turn=_LONGEST_TURN if along is None else _TURN_ALONG
        )
        failure = walk.run(span)
        return record.trajectory(walk.q, walk.velocity, walk.changes, failure)

    def energy(self, q: Array, velocity: Array, phase: float = 0.0) -> float:
        """Total energy in J from the state of rest, without the potential of the drive.

        Of contact points it is that of their residual flexibility, lambda^T R lambda / 2.
        """
        own = self.states.energy(q, velocity)
        if not self.drive.gap.moves:
            return own
        still, moved = (
            float(force @ self.model.R @ force) / 2
            for force in (self.states.contact(q).force[0], self._forces(q, phase))
        )
        return own + moved - still

    def size(self, q: Array, velocity: Array, phase: float) -> float:
        """Size of velocities of a motion, from its state and what drives it."""
        model, drive = self.model, self.drive
        pushed = np.abs(drive.amplitude).sum(axis=1) / model.omega
        moved = np.abs(drive.gap.amplitudes).sum(axis=0) / np.sqrt(float(np.trace(model.R)))
        state = np.sqrt(2 * self.energy(q, velocity, phase))
        return float(np.linalg.norm([state, *pushed, *np.broadcast_to(moved, model.points)]))

    def stage_after(
        self, q: Array, velocity: Array, phase: float, before: BentStage | None
    ) -> BentStage:
        """The stage that a state is about to be in; most often one point opens or closes."""
        gap, rate = self.drive.gap_at(phase, self.model.points)
        soon, moved = q + self._moment * velocity, gap + self._moment * rate
        if before is not None:
            changed = self._stage(before.active ^ (before.margins(soon, moved) <= 0))
            if changed.margins(soon, moved).min() > 0:
                return changed
        return self._stage(self._law(self._excess(soon, moved)).force[0] > 0)

    def rule(self, stage: BentStage, step: float, *, keep: bool) -> BentRule:
        """Times and weights of a step."""

        def made() -> BentRule:
            return BentRule.of(gauss_nodes(self.nodes), stage, step)

        key = stage.active.tobytes(), step
        return self._memory.rules.at(key, made) if keep else made()

    @property
    def after_a_change(self) -> float:
        """Time after a change of contact from which the next one is looked for."""
        return 2 * self._moment

    def _forces(self, q: Array, phase: float) -> Array:
        """Contact forces in N at coordinates and a phase, shape (n_c,)."""
        moved, _ = self.drive.gap_at(phase, self.model.points)
        return self._law(self._excess(q, moved)).force[0]

    def _excess(self, q: Array, moved: Array) -> Array:
        """P - gap at coordinates (J,) and changes of the gaps (n_c,), shape (1, n_c)."""
        model, one = self.model, np.ones((1, 1))
        linear = (model.Phi @ q)[None]
        return model.kinematics.closing.displaced(linear, one, q[None]) - model.gap - moved

    def _stage(self, active: Mask) -> BentStage:
        """The stage with given points in contact."""
        return self._memory.stages.at(
            active.tobytes(), lambda: BentStage.of(self.mechanics, active)
        )


class _Walk:
    """One integration: the state, and how long steps are."""

    def __init__(
        self,
        flow: BentFlow,
        q: Array,
        velocity: Array,
        phase: float,
        record: Record,
        *,
        turn: float,
    ) -> None:
        self._flow, self._phase, self._record, self._turn = flow, phase, record, turn
        self.q, self.velocity, self.changes = q, velocity, 0
        self._size = flow.size(q, velocity, phase)
        self._step = _FIRST * 2 * np.pi / float(flow.model.omega[0])
        self._patience, self._clock = 0, 0.0

    def run(self, span: float) -> str:
        """Go on for a time; why it ended before, or nothing."""
        flow, stage = self._flow, self._after(None)
        before, passed = None, 0.0
        while self._clock < span:
            step = self._solved(stage, span - self._clock, before, passed)
            if step is None:
                return f"the steps in time became too small at {self._clock:.3g} of {span:.3g} s"
            passed = step.end(flow.after_a_change)
            self._record.note(step, self._clock, passed)
            self.q, self.velocity = step.state(passed)
            self._clock += passed
            before = step
            if passed < step.rule.step:
                self.changes += 1
                if self.changes > flow.most_changes:
                    return (
                        f"more than {flow.most_changes} changes of contact in {self._clock:.3g} "
                        f"of {span:.3g} s"
                    )
                stage = self._after(stage)
        return ""

    @property
    def _turned(self) -> float:
        """Phase of the drive that is reached."""
        return self._phase + self._flow.drive.omega * self._clock

    def _after(self, before: BentStage | None) -> BentStage:
        return self._flow.stage_after(self.q, self.velocity, self._turned, before)

    def _solved(
        self, stage: BentStage, left: float, before: BentStep | None, passed: float
    ) -> BentStep | None:
        """The next step, as long as the remainder allows; None where none is short enough."""
        flow, shortest = self._flow, _SHORTEST * self._step
        while self._step > self._turn / float(np.abs(stage.exponents).max()):
            self._step /= 2
        state = self.q, self.velocity
        start = Start.of(stage, state, flow.drive, self._turned, self._size)
        while self._step > shortest:
            length = min(self._step, left)
            rule = flow.rule(stage, length, keep=length == self._step)
            found = BentStep.solved(start, rule, self._guess(start, before, passed, length))
            error = found.tail / self._size if found else np.inf
            if found and error <= flow.tolerance:
                if length == self._step:
                    self._lengthen(error)
                return found
            self._step, self._patience = self._step / 2, _PATIENCE
        return None

    def _lengthen(self, error: float) -> None:
        """Try a longer step next, if the last one was easy, and no longer one failed just now."""
        self._patience -= 1
        if self._patience < 0 and error <= _EASY * self._flow.tolerance:
            self._step *= 2

    def _guess(self, start: Start, before: BentStep | None, passed: float, length: float) -> Array:
        """Pushes at the nodes of the next step to begin with."""
        if before is not None:
            return before.continued(passed, length)
        first = start.stage.smooth.remainder(start.seen(np.zeros(1)).T).T
        return np.repeat(first, self._flow.nodes, axis=0)
