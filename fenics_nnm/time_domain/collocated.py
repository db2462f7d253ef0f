"""Motion in time with second-order kinematics: smooth stages, by exponential collocation.

Between changes of contact the motion is that of `smooth_stage`; steps of `smooth_step` are exact in
the linear part, so that their length follows from the remainder alone. Changes of contact are
found by root finding, as in `flow`: the vector field is continuous, so the small error of an
instant enters the state squared.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.mechanics.closed import highest_frequency
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.exponential_rule import gauss_nodes
from fenics_nnm.time_domain.integrator import Trajectory
from fenics_nnm.time_domain.kept import Kept
from fenics_nnm.time_domain.smooth_stage import SmoothStage
from fenics_nnm.time_domain.smooth_step import SmoothStep, Start
from fenics_nnm.time_domain.states import States
from fenics_nnm.time_domain.step_rule import Rule

#: As in `flow`: points in contact are those a moment later, this over the highest frequency.
_MOMENT = 1e-9

#: A step turns the fastest mode by no more than this, so that no change of contact is missed; and
#: by less where derivatives are carried along, which fast modes take part in.
_LONGEST_TURN, _TURN_ALONG = 40.0, 24.0

#: First step as a part of the period of the lowest mode; steps are that over powers of two.
_FIRST = 1 / 8

#: Steps are halved no further.
_SHORTEST = 2.0**-30

#: Steps with an error below this part of the tolerance are doubled, but not so many steps after a
#: longer one failed.
_EASY, _PATIENCE = 1e-2, 6

#: Stages, and rules of steps, that are kept, if they are not too large.
_KEPT = 500


@dataclass(frozen=True, slots=True)
class Collocated:
    """Integrates a model with second-order kinematics.

    Attributes:
        mechanics: What a motion obeys; free and without damping.
        nodes: Gauss points of a step, s: the method has order 2 s.
        tolerance: Highest coefficient of the remainder over a step, relative to the velocities of
            the motion; the error of the step is smaller by the order that the rule has beyond s:
            1e-12 of the motion over a period with the values given here.
        most_changes: A motion with more changes of contact than this is given up.

    Raises:
        ModelError: if contact points carry mass, or points are pressed at rest.
    """

    mechanics: Mechanics
    nodes: int = 16
    tolerance: float = 1e-9
    most_changes: int = 20_000
    model: ReducedModel = field(init=False, repr=False, compare=False)
    _moment: float = field(init=False, repr=False, compare=False)
    states: States = field(init=False, repr=False, compare=False)
    _stages: Kept[SmoothStage] = field(
        init=False, repr=False, compare=False, default_factory=lambda: Kept(_KEPT)
    )
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
        wanted = np.empty(0) if times is None else np.asarray(times)
        walk = _Walk(self, q, velocity, wanted, along, speeds=speeds)
        if not np.all(np.isfinite([*q, *velocity, span])):
            return walk.trajectory("the state to start from is not finite")
        return walk.trajectory(walk.run(span))

    def acceleration(self, q: Array, velocity: Array) -> Array:
        """Acceleration of a state, shape (J,)."""
        return self.stage_at(q).acceleration(q[None], velocity[None])[0]

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of the energy by q and velocity, shape (2 J,)."""
        return self.states.energy_gradient(q, velocity)

    def energy(self, q: Array, velocity: Array) -> float:
        """Total energy in J from the state of rest."""
        return self.states.energy(q, velocity)

    def stage_at(self, q: Array) -> SmoothStage:
        """The stage of coordinates of shape (J,)."""
        return self._stage(self.states.contact(q).force[0] > 0)

    def stage_after(self, q: Array, velocity: Array, before: SmoothStage | None) -> SmoothStage:
        """The stage that a state is about to be in; most often one point opens or closes."""
        soon = q + self._moment * velocity
        if before is not None:
            changed = self._stage(before.active ^ (before.margins(soon[None])[0] <= 0))
            if changed.margins(soon[None]).min() > 0:
                return changed
        return self.stage_at(soon)

    def rule(self, stage: SmoothStage, step: float, *, keep: bool) -> Rule:
        """Times and weights of a step."""

        def made() -> Rule:
            nodes = gauss_nodes(self.nodes)
            return Rule.of(nodes, stage.linear.nu, stage.remainder, step)

        return self._rules.at((stage.active.tobytes(), step), made) if keep else made()

    @property
    def after_a_change(self) -> float:
        """Time after a change of contact from which the next one is looked for."""
        return 2 * self._moment

    def _stage(self, active: Mask) -> SmoothStage:
        """The stage with given points in contact."""
        return self._stages.at(active.tobytes(), lambda: SmoothStage.of(self.mechanics, active))


class _Walk:
    """One integration: the state, and what is noted of it."""

    def __init__(
        self,
        flow: Collocated,
        q: Array,
        velocity: Array,
        times: Array,
        along: Array | None,
        *,
        speeds: bool,
    ) -> None:
        self._flow = flow
        self._q, self._velocity = q, velocity
        self._size = float(np.sqrt(2 * flow.energy(q, velocity)))
        self._step = _FIRST * 2 * np.pi / float(flow.model.omega[0])
        self._patience = 0
        self._clock, self._changes, self._contact_time = 0.0, 0, 0.0
        self._times, self._transition = times, along
        self._q_at = np.full((len(times), len(q)), np.nan)
        self._velocity_at = np.full((len(times), len(q)), np.nan)
        self._speed_integral = 0.0 if speeds else float("nan")

    def run(self, span: float) -> str:
        """Go on for a time; why it ended before, or nothing."""
        stage = self._flow.stage_after(self._q, self._velocity, None)
        before, passed = None, 0.0
        self._note_start()
        while self._clock < span:
            step = self._solved(stage, span - self._clock, before, passed)
            if step is None:
                return f"the steps in time became too small at {self._clock:.3g} of {span:.3g} s"
            passed = step.end(self._flow.after_a_change)
            self._take(step, passed)
            before = step
            if passed < step.rule.step:
                following = self._flow.stage_after(self._q, self._velocity, stage)
                self._changes += 1
                if self._changes > self._flow.most_changes:
                    return (
                        f"more than {self._flow.most_changes} changes of contact in "
                        f"{self._clock:.3g} of {span:.3g} s"
                    )
                stage = following
        return ""

    def trajectory(self, failure: str) -> Trajectory:
        """The result, with the final state."""
        return Trajectory(
            q=self._q,
            velocity=self._velocity,
            changes=self._changes,
            contact_time=self._contact_time,
            q_at=self._q_at,
            velocity_at=self._velocity_at,
            speed_integral=self._speed_integral,
            transition=self._transition,
            failure=failure,
        )

    def _solved(
        self, stage: SmoothStage, left: float, before: SmoothStep | None, passed: float
    ) -> SmoothStep | None:
        """The next step, as long as the remainder allows; None where none is short enough."""
        turn = _LONGEST_TURN if self._transition is None else _TURN_ALONG
        longest = turn / float(stage.linear.nu[-1])
        shortest = _SHORTEST * self._step
        while self._step > longest:
            self._step /= 2
        start = Start.of(stage, self._q, self._velocity, self._size)
        while self._step > shortest:
            length = min(self._step, left)
            rule = self._flow.rule(stage, length, keep=length == self._step)
            guess = self._guess(stage, before, passed, length)
            found = SmoothStep.solved(stage, rule, start, guess)
            error = found.tail / self._size if found else np.inf
            if found and error <= self._flow.tolerance:
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

    def _guess(
        self, stage: SmoothStage, before: SmoothStep | None, passed: float, length: float
    ) -> Array:
        if before is not None:
            return before.continued(passed, length)
        first = stage.remainder(stage.seen(self._q[None], self._velocity[None]))
        return np.repeat(first, self._flow.nodes, axis=0)

    def _note_start(self) -> None:
        at = self._times <= 0
        self._q_at[at], self._velocity_at[at] = self._q, self._velocity

    def _take(self, step: SmoothStep, passed: float) -> None:
        """Go on by a part of a step."""
        at = (self._times > self._clock) & (self._times <= self._clock + passed)
        if at.any():
            self._q_at[at], self._velocity_at[at] = step.states(self._times[at] - self._clock)
        if not np.isnan(self._speed_integral):
            self._speed_integral += step.speed_integral(passed)
        self._contact_time += passed * step.stage.linear.contact
        self._q, self._velocity, self._transition = step.after(passed, self._transition)
        self._clock += passed
