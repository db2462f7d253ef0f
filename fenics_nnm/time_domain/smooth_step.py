"""One step of exponential collocation in a smooth stage, and the first change of contact in it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.exponential_rule import Weights, gauss_points
from fenics_nnm.time_domain.margins import Margins
from fenics_nnm.time_domain.smooth_stage import SmoothStage
from fenics_nnm.time_domain.step_rule import Rule
from fenics_nnm.time_domain.step_series import WatchedMotion

#: A margin is negative below this part of the size of what it is the difference of.
_ROUND_OFF = 1e-13

#: Iterations for the remainder; a step that needs more is halved.
_ITERATIONS = 30

#: Changes of the remainder below this part of the motion that do not shrink are round-off.
_STALLED = 1e-12


@dataclass(frozen=True, slots=True)
class Start:
    """The state at which a step starts, in coordinates of the stage.

    Attributes:
        x: Coordinates, shape (J,).
        rate: Their velocities, shape (J,).
        size: Size of velocities of the motion.
    """

    x: Array
    rate: Array
    size: float

    @classmethod
    def of(cls, stage: SmoothStage, q: Array, velocity: Array, size: float) -> Start:
        """A state of the model, its coordinates and velocities of shape (J,)."""
        linear = stage.linear
        return cls((q - linear.rest) @ linear.V, velocity @ linear.V, size)

    def state(self, stage: SmoothStage) -> tuple[Array, Array]:
        """Coordinates and velocities of the model, each of shape (J,)."""
        linear = stage.linear
        return linear.rest + linear.V @ self.x, linear.V @ self.rate


@dataclass(frozen=True, slots=True)
class SmoothStep:
    """A step whose equations hold at the nodes.

    Attributes:
        stage: Stage.
        rule: Times and weights.
        start: State at the start.
        seen: What the remainder sees at the nodes, shape (3 k + P, s).
        pushes: What it pushes by there, shape (P + k, s).
        remainder: Remainder at the nodes in coordinates of the stage, shape (J, s).
        _known: Weights at times that were asked for.
    """

    stage: SmoothStage
    rule: Rule
    start: Start
    seen: Array
    pushes: Array
    remainder: Array
    _known: dict[float, Weights] = field(
        init=False, repr=False, compare=False, default_factory=dict
    )

    @classmethod
    def solved(
        cls, stage: SmoothStage, rule: Rule, start: Start, guess: Array, converged: float
    ) -> SmoothStep | None:
        """The step from a state, by fixed-point iteration on the pushes.

        Args:
            stage: Stage.
            rule: Times and weights.
            start: State at the start.
            guess: Pushes at the nodes to begin with, shape (P + k, s).
            converged: Change of the remainder, as a part of the motion, that the next iteration is
                to be below.

        Returns:
            None where it does not converge.
        """
        wide = start.size * (1 + rule.step * float(stage.linear.nu[-1]))
        free, reach = rule.free(start.x, start.rate), rule.step * stage.remainder.reach[:, None]
        pushes, before = guess, np.inf
        for _ in range(_ITERATIONS):
            seen = (free + rule.by_pushes.dot(pushes.ravel())).reshape(-1, pushes.shape[1])
            found = stage.remainder(seen)
            moved = reach * (found - pushes)
            change = math.sqrt(np.vdot(moved, moved))
            pushes = found
            following = change * (change / before if before < np.inf else 1.0)
            if following <= converged * wide or before / 2 < change <= _STALLED * wide:
                return cls(stage, rule, start, seen, pushes, stage.remainder.directions @ pushes)
            if not change < 1e3 * before:
                return None
            before = change
        return None

    @property
    def tail(self) -> float:
        """Size of the highest coefficients of the remainder, as a velocity."""
        coefficients = self.pushes @ self.rule.nodes.to_legendre[-2:].T
        squares = (self.stage.remainder.directions @ coefficients) ** 2
        before, last = np.sqrt(squares.sum(axis=0))
        return self.rule.step * float(max(last, before / 8))

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times of the step, each of shape (t, J)."""
        linear, motion, count = self.stage.linear, self._motion(self._weights(times)), len(times)
        return linear.rest + motion[:, :count].T @ linear.V.T, motion[:, count:].T @ linear.V.T

    def after(self, time: float) -> Array:
        """Coordinates of the stage and their velocities at a time, shape (J, 2)."""
        return self._motion(self._weights_at(time))

    def carried(self, time: float, start: Array, slopes: Array) -> Array:
        """Changes (2 J, c) at a time of this step, in coordinates of the stage and velocities.

        With B the slopes of the pushes, and h what is seen of the changes without pushes, these
        change by u = B (h + A u): (P + k) s equations for all changes at once.

        Args:
            time: Time from the start.
            start: Changes at the start, shape (2 J, c).
            slopes: Of the remainder at the nodes, shape (s, P + k, 3 k + P).
        """
        rule = self.rule
        matrix = self._pushed(-slopes, rule.by_pushes)
        matrix.ravel()[rule.diagonal] += 1.0
        pushes = np.linalg.solve(matrix, self._pushed(slopes, rule.by_start @ start))
        if time == rule.step:
            return np.asarray(rule.end_by_start @ start + rule.end_by_pushes @ pushes)
        return self._weights_at(time).carried(start, self.stage.remainder.directions, pushes)

    def continued(self, step: float, following: float) -> Array:
        """Pushes at the nodes of a following step, if it goes on, shape (P + k, s).

        Args:
            step: Time from the start at which that begins.
            following: Its length.
        """
        rule, nodes = self.rule, self.rule.nodes
        if step == following == rule.step:
            return np.asarray(self.pushes @ rule.onwards)
        return nodes.beyond((step + following * nodes.at) / rule.step, self.pushes)

    def speed_integral(self, time: float) -> float:
        """Integral of |q'|^2 from the start to a time, in J s."""
        turn = int(np.ceil(time * self.stage.linear.nu[-1]))
        inner = gauss_points(len(self.rule.nodes.at) + turn)
        _, velocity = self.states(time * inner.at)
        return time * float(inner.weight @ np.sum(velocity**2, axis=1))

    def end(self) -> tuple[float, Array]:
        """First time at which a margin is negative, from the first that is watched, or the end.

        Returns:
            The time, and coordinates of the stage and their velocities there, shape (J, 2).
        """
        rule = self.rule
        if rule.watched[0] >= rule.step:
            return rule.step, self.after(rule.step)
        watched, count = self._motion(rule.at_watched), len(rule.watched)
        between = WatchedMotion(rule.series, watched, self.remainder)
        margins, rates, size = self.stage.course.along(watched)
        found = Margins(rule.watched, margins.T, rates.T, -_ROUND_OFF * size)

        def exact(point: int, time: float) -> tuple[float, float]:
            return self.stage.course.of_point(point, between.at(time))

        time = found.first_negative(exact)
        if time == rule.watched[-1]:
            return time, watched[:, [count - 1, 2 * count - 1]]
        return time, between.at(time)

    def _pushed(self, slopes: Array, seen: Array) -> Array:
        """Changes of pushes, node by node, by what is seen there, ((3 k + P) s, c)."""
        by_node = seen.reshape(*self.seen.shape, seen.shape[1]).swapaxes(0, 1)
        return (slopes @ by_node).reshape(self.pushes.size, seen.shape[1])

    def _weights_at(self, time: float) -> Weights:
        if time == self.rule.step:
            return self.rule.at_end
        if time not in self._known:
            self._known[time] = self._weights(np.array([time]))
        return self._known[time]

    def _weights(self, times: Array) -> Weights:
        return Weights.of(self.rule.nodes, self.stage.linear.nu, self.rule.step, times)

    def _motion(self, weights: Weights) -> Array:
        """Coordinates of the stage and, beside them, their velocities, (J, 2 t)."""
        return weights.motion(self.start.x, self.start.rate, self.remainder)
