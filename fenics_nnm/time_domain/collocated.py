"""Motion in time with second-order kinematics: smooth stages, by exponential collocation.

Between changes of contact the motion is that of `smooth_stage`; steps of `smooth_step` are exact in
the linear part, so that their length follows from the remainder alone. Changes of contact are
found by root finding, as in `flow`: the vector field is continuous, so the small error of an
instant enters the state squared.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.mechanics.closed import highest_frequency
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.course import Course, Part, parts_until
from fenics_nnm.time_domain.exponential_rule import gauss_nodes
from fenics_nnm.time_domain.integrator import Trajectory
from fenics_nnm.time_domain.kept import Kept, bytes_of
from fenics_nnm.time_domain.rungs import Rungs
from fenics_nnm.time_domain.smooth_stage import SmoothStage
from fenics_nnm.time_domain.smooth_step import SmoothStep, Start
from fenics_nnm.time_domain.states import States
from fenics_nnm.time_domain.step_rule import Rule

#: As in `flow`: points in contact are those a moment later, this over the highest frequency.
_MOMENT = 1e-9

#: Bound of the error over a period as a part of the tolerance of a step; see there.
_PERIOD = 1e-2

#: Longest step as a part of the period of the lowest mode; steps are rungs from there.
_LONGEST = 1 / 8

#: A step is iterated to this part of the tolerance.
_ITERATED = 1e-5

#: A step is tried with no more lengths than this.
_TRIES = 60

#: How much larger the tolerance is where a rough motion will do, and how far steps turn there.
_ROUGH, _ROUGH_TURN = 100.0, 40.0

#: Stages, and rules of steps, that are kept, if they are not too large.
_KEPT = 500

#: Courses that are kept: derivatives, multipliers and bifurcations are asked for after the motion.
_LATEST = 100

#: Stages that are tried for a state before its forces are found from scratch.
_RECENT = 4

#: Walks that are kept: a motion is often followed for half a period, then for all of it.
_WALKS = 8


@dataclass(frozen=True, slots=True)
class Collocated:
    """Integrates a model with second-order kinematics.

    Attributes:
        mechanics: What a motion obeys; free and without damping.
        nodes: Gauss points of a step, s: the method has order 2 s.
        tolerance: Highest coefficient of the remainder over a step, relative to the velocities of
            the motion; the error of the step is smaller by the order that the rule has beyond s:
            1e-12 of the motion over a period with the values given here.
        longest_turn: A step turns the fastest mode by no more than this, as fast modes take part in
            derivatives of the motion.
        most_changes: A motion with more changes of contact than this is given up.

    Raises:
        ModelError: if contact points carry mass, or points are pressed at rest.
    """

    mechanics: Mechanics
    nodes: int = 16
    tolerance: float = 1e-9
    longest_turn: float = 24.0
    most_changes: int = 20_000
    model: ReducedModel = field(init=False, repr=False, compare=False)
    _moment: float = field(init=False, repr=False, compare=False)
    states: States = field(init=False, repr=False, compare=False)
    _stages: Kept[SmoothStage] = field(
        init=False, repr=False, compare=False, default_factory=lambda: Kept(_KEPT)
    )
    _courses: Kept[Course] = field(
        init=False, repr=False, compare=False, default_factory=lambda: Kept(_LATEST)
    )
    _walks: Kept[_Walk] = field(
        init=False, repr=False, compare=False, default_factory=lambda: Kept(_WALKS)
    )
    _latest: list[SmoothStage] = field(init=False, repr=False, compare=False, default_factory=list)
    _rules: Kept[Rule] = field(
        init=False, repr=False, compare=False, default_factory=lambda: Kept(_KEPT)
    )

    def __post_init__(self) -> None:
        model = self.mechanics.model
        object.__setattr__(self, "states", States(self.mechanics))
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "_moment", _MOMENT / highest_frequency(model))

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
        course = self.course(q, velocity, span)
        states = course.states(np.empty(0) if times is None else np.asarray(times))
        return Trajectory(
            *course.end,
            changes=course.changes,
            contact_time=course.contact_time,
            q_at=states[0],
            velocity_at=states[1],
            speed_integral=course.speed_integral if speeds else float("nan"),
            derivative=None if along is None else partial(course.carried, along),
            failure=course.failure,
        )

    def course(self, q: Array, velocity: Array, span: float) -> Course:
        """The course of the motion from a state for a time; the latest ones are kept.

        Steps do not depend on the time: a longer course goes on where a shorter one was left.
        """
        if not np.all(np.isfinite([*q, *velocity, span])):
            failure = "the state to start from is not finite"
            return Course(q, velocity, (q, velocity), (), failure)
        state = (q + 0.0).tobytes(), (velocity + 0.0).tobytes()

        def made() -> Course:
            return self._walks.at(state, lambda: _Walk(self, q, velocity)).course(span)

        return self._courses.at((*state, span), made)

    @property
    def iterated(self) -> float:
        """Change of the remainder, as a part of the motion, at which a step is converged."""
        return _ITERATED * self.tolerance

    @property
    def error(self) -> float:
        """What is left by the tolerance of its steps, and more."""
        return _PERIOD * self.tolerance

    @property
    def cheap(self) -> bool:
        """Ten periods cost as much as the exact motion, which tells more."""
        return False

    @property
    def rough(self) -> Collocated:
        """The same with longer steps: an error below 1e-8 of the motion in ten periods."""
        return replace(self, tolerance=_ROUGH * self.tolerance, longest_turn=_ROUGH_TURN)

    def acceleration(self, q: Array, velocity: Array) -> Array:
        """Acceleration of a state, shape (J,)."""
        return self.stage_at(q).accelerated(q, velocity)

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of the energy by q and velocity, shape (2 J,)."""
        return self.states.energy_gradient(q, velocity)

    def energy(self, q: Array, velocity: Array) -> float:
        """Total energy in J from the state of rest."""
        return self.states.energy_of(q, velocity, self.stage_at(q).forces(q))

    def stage_at(self, q: Array) -> SmoothStage:
        """The stage of coordinates of shape (J,); most often it is one of the latest asked for."""
        stage = next((known for known in self._latest if known.margins(q).min() > 0), None)
        if stage is None:
            stage = self._stage(self.states.contact(q).force[0] > 0)
        others = [known for known in self._latest if known is not stage]
        self._latest[:] = [stage, *others[: _RECENT - 1]]
        return stage

    def stage_after(self, q: Array, velocity: Array, before: SmoothStage | None) -> SmoothStage:
        """The stage that a state is about to be in; most often one point opens or closes."""
        soon = q + self._moment * velocity
        if before is not None:
            changed = self._stage(before.active ^ (before.margins(soon) <= 0))
            if changed.margins(soon).min() > 0:
                return changed
        return self.stage_at(soon)

    def rule(self, stage: SmoothStage, step: float) -> Rule:
        """Times and weights of a step."""

        def made() -> Rule:
            nodes = gauss_nodes(self.nodes)
            return Rule.of(nodes, stage.linear.nu, stage.remainder, step, 2 * self._moment)

        return self._rules.at((stage.active.tobytes(), step), made)

    def _stage(self, active: Mask) -> SmoothStage:
        """The stage with given points in contact."""
        return self._stages.at(active.tobytes(), lambda: SmoothStage.of(self.mechanics, active))


class _Walk:
    """One integration: the state, and the steps that were taken."""

    def __init__(self, flow: Collocated, q: Array, velocity: Array) -> None:
        self._flow = flow
        self._first = q, velocity
        self._size = float(np.sqrt(2 * flow.energy(q, velocity)))
        self._rungs = Rungs(_LONGEST * 2 * np.pi / float(flow.model.omega[0]), flow.nodes)
        self._clock, self._changes, self._changed = 0.0, 0, False
        self._stage = flow.stage_after(q, velocity, None)
        self._start = Start.of(self._stage, q, velocity, self._size)
        self._parts: list[Part] = []

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays; those of its steps belong to the courses."""
        return bytes_of(*self._first, self._start.x, self._start.rate)

    def course(self, span: float) -> Course:
        """The course for a time; the last step of it is left before its end."""
        failure = self._run(span)
        parts = tuple(parts_until(self._parts, span))
        end = parts[-1].end if parts else self._first
        return Course(*self._first, end, parts, failure)

    def _run(self, span: float) -> str:
        """Go on, by whole steps, for a time or longer; why it ended before, or nothing."""
        while self._clock < span:
            if self._changed:
                self._change()
            if self._changes > self._flow.most_changes:
                return (
                    f"more than {self._flow.most_changes} changes of contact in "
                    f"{self._clock:.3g} of {span:.3g} s"
                )
            step = self._solved()
            if step is None:
                return f"the steps in time became too small at {self._clock:.3g} of {span:.3g} s"
            ends, motion = step.end()
            self._changed = ends < step.rule.step
            self._take(step, ends, motion)
        return ""

    def _change(self) -> None:
        """Go on in the stage that follows."""
        q, velocity = self._start.state(self._stage)
        self._stage = self._flow.stage_after(q, velocity, self._stage)
        self._start = Start.of(self._stage, q, velocity, self._size)
        self._changes, self._changed = self._changes + 1, False

    def _solved(self) -> SmoothStep | None:
        """The next step, as long as the remainder allows; None where none is short enough."""
        flow, stage, rungs = self._flow, self._stage, self._rungs
        rungs.reach(flow.longest_turn / float(stage.linear.nu[-1]))
        for _ in range(_TRIES):
            rule = flow.rule(stage, rungs.step)
            guess = self._guess(stage, rungs.step)
            found = SmoothStep.solved(stage, rule, self._start, guess, flow.iterated)
            error = found.tail / self._size / flow.tolerance if found else np.inf
            if found and error <= 1:
                rungs.accepted(error)
                return found
            rungs.refused(error)
        return None

    def _guess(self, stage: SmoothStage, length: float) -> Array:
        """Pushes at the nodes of the next step: those of the last one, gone on with."""
        if self._parts:
            last = self._parts[-1]
            return last.step.continued(last.passed, length)
        q, velocity = self._first
        first = stage.remainder(stage.seen(q[None], velocity[None]))
        return np.repeat(first, self._flow.nodes, axis=1)

    def _take(self, step: SmoothStep, passed: float, motion: Array) -> None:
        """Go on by a part of a step, to coordinates of its stage and their velocities, (J, 2)."""
        self._start = Start(motion[:, 0], motion[:, 1], self._size)
        self._parts.append(Part(step, passed))
        self._clock += passed
