"""One step of exponential collocation in a smooth stage, and the first change of contact in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.exponential_rule import Weights, gauss_nodes
from fenics_nnm.time_domain.margins import Margins
from fenics_nnm.time_domain.smooth_stage import SmoothStage
from fenics_nnm.time_domain.step_rule import Rule

#: A margin is negative below this part of the size of what it is the difference of.
_ROUND_OFF = 1e-13

#: Iterations for the remainder; a step that needs more is halved.
_ITERATIONS = 30

#: Changes of the remainder below these parts of the motion: converged, if the next one would be,
#: and stalled in round-off.
_CONVERGED, _STALLED = 2e-15, 1e-12


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


@dataclass(frozen=True, slots=True)
class SmoothStep:
    """A step whose equations hold at the nodes.

    Attributes:
        stage: Stage.
        rule: Times and weights.
        start: State at the start.
        seen: What the remainder sees at the nodes, shape (s, 3 k + P).
        pushes: What it pushes by there, shape (s, P + k).
        remainder: Remainder at the nodes in coordinates of the stage, shape (J, s).
    """

    stage: SmoothStage
    rule: Rule
    start: Start
    seen: Array
    pushes: Array
    remainder: Array

    @classmethod
    def solved(
        cls, stage: SmoothStage, rule: Rule, start: Start, guess: Array
    ) -> SmoothStep | None:
        """The step from a state, by fixed-point iteration on the pushes.

        Args:
            stage: Stage.
            rule: Times and weights.
            start: State at the start.
            guess: Pushes at the nodes to begin with, shape (s, P + k).

        Returns:
            None where it does not converge.
        """
        directions = stage.remainder.directions
        wide = start.size * (1 + rule.step * float(stage.linear.nu[-1]))
        free = rule.free(start.x, start.rate)
        pushes, before = guess, np.inf
        for _ in range(_ITERATIONS):
            seen = free + rule.seen_of(pushes)
            found = stage.remainder(seen)
            moved = (found - pushes) @ directions.T
            change = rule.step * float(np.abs(moved).max(initial=0.0))
            pushes = found
            following = change * (change / before if before < np.inf else 1.0)
            if following <= _CONVERGED * wide or before / 2 < change <= _STALLED * wide:
                return cls(stage, rule, start, seen, pushes, directions @ pushes.T)
            if not change < 1e3 * before:
                return None
            before = change
        return None

    @property
    def tail(self) -> float:
        """Size of the highest coefficients of the remainder, as a velocity."""
        coefficients = self.rule.nodes.to_legendre[-2:] @ self.remainder.T
        highest = np.linalg.norm(coefficients, axis=1)
        return self.rule.step * float(max(highest[1], highest[0] / 8))

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times of the step, each of shape (t, J)."""
        return self._states(self._weights(times))

    def after(self, time: float, changes: Array | None) -> tuple[Array, Array, Array | None]:
        """Coordinates and velocities at a time, and changes of them.

        Args:
            time: Time from the start.
            changes: Changes (2 J, c) of the state at the start, or None.
        """
        at_end = time == self.rule.step
        weights = self.rule.at_end if at_end else self._weights(np.array([time]))
        q, velocity = self._states(weights)
        carried = None if changes is None else self._carried(weights, changes)
        return q[0], velocity[0], carried

    def continued(self, step: float, following: float) -> Array:
        """Pushes at the nodes of a following step, if it goes on, shape (s, P + k).

        Args:
            step: Time from the start at which that begins.
            following: Its length.
        """
        nodes = self.rule.nodes
        return nodes.beyond((step + following * nodes.at) / self.rule.step, self.pushes)

    def speed_integral(self, time: float) -> float:
        """Integral of |q'|^2 from the start to a time, in J s."""
        turn = int(np.ceil(time * self.stage.linear.nu[-1]))
        inner = gauss_nodes(len(self.rule.nodes.at) + turn)
        _, velocity = self.states(time * inner.at)
        return time * float(inner.weight @ np.sum(velocity**2, axis=1))

    def end(self, start: float) -> float:
        """First time after `start` at which a margin is negative, or the end of the step."""
        rule, own = self.rule, self.start
        if start >= rule.step:
            return rule.step
        x, rate = rule.at_watched.motion(own.x, own.rate, self.remainder)
        # so early that what the motion bends by is round-off
        x, rate = np.vstack([own.x + start * own.rate, x.T]), np.vstack([own.rate, rate.T])
        times = np.append(start, rule.watched)
        margins, rates, size = self.stage.course.at(x, rate)
        late = times >= start
        found = Margins(times[late], margins[late], rates[late], -_ROUND_OFF * size)
        return found.first_negative(self._margin_at)

    def _carried(self, weights: Weights, changes: Array) -> Array:
        """Changes (2 J, c) of the state at the start, at a time of this step.

        With B the slopes of the pushes, and h what is seen of the changes without pushes, these
        change by u = B (h + A u): (P + k) s equations for all changes at once.
        """
        V, rule, directions = self.stage.linear.V, self.rule, self.stage.remainder.directions
        start = np.concatenate([V.T @ each for each in np.split(changes, 2)])
        slopes, size, columns = (
            self.stage.remainder.slopes(self.seen),
            self.pushes.size,
            changes.shape[1],
        )
        nodes, seen = self.seen.shape
        free = (rule.by_start @ start).reshape(nodes, seen, columns)
        matrix = np.eye(size) - (slopes @ rule.by_pushes.reshape(nodes, seen, size)).reshape(
            size, size
        )
        pushes = np.linalg.solve(matrix, (slopes @ free).reshape(size, columns))
        ends = weights.carried(start, directions, pushes.reshape(*self.pushes.shape, columns))
        return np.concatenate([V @ each for each in ends])

    def _weights(self, times: Array) -> Weights:
        return Weights.of(self.rule.nodes, self.stage.linear.nu, self.rule.step, times)

    def _states(self, weights: Weights) -> tuple[Array, Array]:
        """Coordinates and velocities of the model, (t, J)."""
        linear, start = self.stage.linear, self.start
        x, rate = weights.motion(start.x, start.rate, self.remainder)
        return linear.rest + x.T @ linear.V.T, rate.T @ linear.V.T

    def _margin_at(self, point: int, time: float) -> tuple[float, float]:
        """A margin and its rate at a time."""
        x, rate = self._weights(np.array([time])).motion(
            self.start.x, self.start.rate, self.remainder
        )
        margins, rates, _ = self.stage.course.at(x.T, rate.T)
        return float(margins[0, point]), float(rates[0, point])
