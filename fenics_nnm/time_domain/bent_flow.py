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
from fenics_nnm.time_domain.gap_energy import with_moved_gaps
from fenics_nnm.time_domain.integrator import Trajectory
from fenics_nnm.time_domain.kept import Kept
from fenics_nnm.time_domain.record import Record
from fenics_nnm.time_domain.rungs import Rungs
from fenics_nnm.time_domain.states import States

#: As in `collocated`.
_MOMENT = 1e-9
_LONGEST, _ITERATED, _TRIES = 1 / 8, 1e-5, 60
_KEPT, _LATEST = 500, 8


@dataclass(frozen=True, slots=True)
class _Walk:
    """A motion: its steps with the times at which they begin, and how much of each it goes along.

    Attributes:
        parts: Step, clock and time passed of each.
        end: Coordinates and velocities at the end, each of shape (J,).
        changes: Changes of contact.
        failure: Empty, or why it was not followed to the end.
    """

    parts: tuple[tuple[BentStep, float, float], ...]
    end: tuple[Array, Array]
    changes: int
    failure: str

    @property
    def nbytes(self) -> int:
        """Bytes of its steps."""
        return sum(step.nbytes for step, _, _ in self.parts)


@dataclass(frozen=True, slots=True)
class _Memory:
    """What flows of one model under any drive keep."""

    stages: Kept[BentStage] = field(default_factory=lambda: Kept(_KEPT))
    rules: Kept[BentRule] = field(default_factory=lambda: Kept(_KEPT))
    walks: Kept[_Walk] = field(default_factory=lambda: Kept(_LATEST))


@dataclass(frozen=True, slots=True)
class BentFlow:
    """The flow of a damped, driven model with second-order kinematics; it keeps its stages.

    Attributes:
        mechanics: What a motion obeys, with viscous damping; its excitations do not matter.
        drive: Harmonic forces, and motions of the gaps.
        nodes: Gauss points of a step.
        tolerance: Highest coefficient of the remainder over a step, relative to the velocities of
            the motion, see `Collocated`.
        longest_turn: A step turns the fastest mode by no more than this, as there.
        most_changes: A motion with more changes of contact than this is given up.

    Raises:
        ModelError: if contact points carry mass, or points are pressed at rest.
    """

    mechanics: Mechanics
    drive: Drive
    nodes: int = 16
    tolerance: float = 1e-9
    longest_turn: float = 24.0
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
        walk = self._walk(q, velocity, span, phase)
        for step, clock, passed in walk.parts:
            record.note(step, clock, passed)
        return record.trajectory(*walk.end, walk.changes, walk.failure)

    def energy(self, q: Array, velocity: Array, phase: float = 0.0) -> float:
        """Total energy in J from the state of rest, without the potential of the drive.

        Of contact points it is that of their residual flexibility, lambda^T R lambda / 2.
        """
        own = self.states.energy(q, velocity)
        return with_moved_gaps(
            own,
            self.model.R,
            self.drive,
            phase,
            lambda moved: self._law(self._excess(q, moved)).force[0],
        )

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

    def rule(self, stage: BentStage, step: float) -> BentRule:
        """Times and weights of a step."""

        def made() -> BentRule:
            return BentRule.of(gauss_nodes(self.nodes), stage, step, 2 * self._moment)

        return self._memory.rules.at((stage.active.tobytes(), step), made)

    def _walk(self, q: Array, velocity: Array, span: float, phase: float) -> _Walk:
        """The motion from a state; the latest are kept: more is asked of them one after another."""

        def made() -> _Walk:
            return _Walking(self, q, velocity, phase).through(span)

        return self._memory.walks.at(
            (q.tobytes(), velocity.tobytes(), span, phase, self.drive.key), made
        )

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


class _Walking:
    """One integration: the state, and the steps that were taken."""

    def __init__(self, flow: BentFlow, q: Array, velocity: Array, phase: float) -> None:
        self._flow, self._phase = flow, phase
        self._q, self._velocity, self._changes, self._clock = q, velocity, 0, 0.0
        self._size = flow.size(q, velocity, phase)
        self._rungs = Rungs(_LONGEST * 2 * np.pi / float(flow.model.omega[0]), flow.nodes)
        self._parts: list[tuple[BentStep, float, float]] = []

    def through(self, span: float) -> _Walk:
        """The motion for a time."""
        failure = self._run(span)
        return _Walk(tuple(self._parts), (self._q, self._velocity), self._changes, failure)

    def _run(self, span: float) -> str:
        """Go on for a time; why it ended before, or nothing."""
        flow, stage = self._flow, self._after(None)
        while (left := span - self._clock) > 0:
            step = self._solved(stage)
            if step is None:
                return f"the steps in time became too small at {self._clock:.3g} of {span:.3g} s"
            ends = min(step.end(), left)
            self._take(step, ends)
            if ends < min(left, step.rule.step):
                stage = self._after(stage)
                self._changes += 1
                if self._changes > flow.most_changes:
                    return (
                        f"more than {flow.most_changes} changes of contact in {self._clock:.3g} "
                        f"of {span:.3g} s"
                    )
        return ""

    @property
    def _turned(self) -> float:
        """Phase of the drive that is reached."""
        return self._phase + self._flow.drive.omega * self._clock

    def _after(self, before: BentStage | None) -> BentStage:
        return self._flow.stage_after(self._q, self._velocity, self._turned, before)

    def _take(self, step: BentStep, passed: float) -> None:
        """Go on by a part of a step."""
        self._parts.append((step, self._clock, passed))
        self._q, self._velocity = step.state(passed)
        self._clock += passed

    def _solved(self, stage: BentStage) -> BentStep | None:
        """The next step, as long as the remainder allows; None where none is short enough."""
        flow, rungs = self._flow, self._rungs
        rungs.reach(flow.longest_turn / float(np.abs(stage.exponents).max()))
        state = self._q, self._velocity
        start = Start.of(stage, state, flow.drive, self._turned, self._size)
        for _ in range(_TRIES):
            rule, guess = flow.rule(stage, rungs.step), self._guess(start, rungs.step)
            found = BentStep.solved(start, rule, guess, _ITERATED * flow.tolerance)
            error = found.tail / self._size / flow.tolerance if found else np.inf
            if found and error <= 1:
                rungs.accepted(error)
                return found
            rungs.refused(error)
        return None

    def _guess(self, start: Start, length: float) -> Array:
        """Pushes at the nodes of the next step: those of the last one, gone on with."""
        if self._parts:
            last, _, passed = self._parts[-1]
            return last.continued(passed, length)
        first = start.stage.smooth.remainder(start.seen(np.zeros(1)))
        return np.repeat(first, self._flow.nodes, axis=1)
