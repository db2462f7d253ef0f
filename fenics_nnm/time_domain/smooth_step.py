"""One step of exponential collocation in a smooth stage, and the first change of contact in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.exponential_rule import GaussNodes, Weights, gauss_nodes
from fenics_nnm.time_domain.margins import Margins
from fenics_nnm.time_domain.smooth_stage import SmoothStage
from fenics_nnm.time_domain.variation import varied

#: A margin is negative below this part of the size of what it is the difference of.
_ROUND_OFF = 1e-13

#: Iterations for the remainder; a step that needs more is halved.
_ITERATIONS = 30

#: Changes of the remainder below these parts of the motion: converged, and stalled in round-off.
_CONVERGED, _STALLED = 2e-15, 1e-12


@dataclass(frozen=True, slots=True)
class Rule:
    """Times and weights of a step of some length in a stage.

    Attributes:
        step: Length in s.
        nodes: Gauss points.
        at_nodes: Weights at these.
        watched: Times at which margins are looked at, the last at the end, shape (d,).
        at_watched: Weights at these.
        at_end: Weights at the end.
    """

    step: float
    nodes: GaussNodes
    at_nodes: Weights
    watched: Array
    at_watched: Weights
    at_end: Weights

    @classmethod
    def of(cls, nodes: GaussNodes, nu: Array, step: float) -> Rule:
        """Times apart by no more than a radian of the fastest mode."""
        count = max(8, int(np.ceil(step * nu[-1])))
        watched = step * np.arange(1, count + 1) / count
        return cls(
            step,
            nodes,
            Weights.of(nodes, nu, step, step * nodes.at),
            watched,
            Weights.of(nodes, nu, step, watched),
            Weights.of(nodes, nu, step, watched[-1:]),
        )


@dataclass(frozen=True, slots=True)
class SmoothStep:
    """A step whose equations hold at the nodes.

    Attributes:
        stage: Stage.
        rule: Times and weights.
        x: Coordinates of the stage at the start, shape (J, 1).
        rate: Their velocities, shape (J, 1).
        remainder: Remainder at the nodes in coordinates of the stage, shape (J, s, 1).
    """

    stage: SmoothStage
    rule: Rule
    x: Array
    rate: Array
    remainder: Array

    @classmethod
    def solved(
        cls, stage: SmoothStage, rule: Rule, q: Array, velocity: Array, *, guess: Array, size: float
    ) -> SmoothStep | None:
        """The step from a state, by fixed-point iteration on the remainder.

        Args:
            stage: Stage.
            rule: Times and weights.
            q: Coordinates at the start, shape (J,).
            velocity: Their velocities.
            guess: Remainder at the nodes to begin with, shape (s, J).
            size: Size of velocities of the motion.

        Returns:
            None where it does not converge.
        """
        linear = stage.linear
        x, rate = ((q - linear.rest) @ linear.V)[:, None], (velocity @ linear.V)[:, None]
        wide = size * (1 + rule.step * float(linear.nu[-1]))
        remainder, before = (linear.V.T @ guess.T)[:, :, None], np.inf
        for _ in range(_ITERATIONS):
            states = _of_stage(stage, rule.at_nodes.motion(x, rate, remainder))
            found = (linear.V.T @ stage.remainder(*states).T)[:, :, None]
            change = rule.step * float(np.abs(found - remainder).max())
            remainder = found
            if change <= _CONVERGED * wide or before / 2 < change <= _STALLED * wide:
                return cls(stage, rule, x, rate, remainder)
            if not change < 1e3 * before:
                return None
            before = change
        return None

    @property
    def tail(self) -> float:
        """Size of the highest coefficients of the remainder, as a velocity."""
        highest = np.linalg.norm(
            self.rule.nodes.to_legendre[-2:] @ self.remainder[:, :, 0].T, axis=1
        )
        return self.rule.step * float(max(highest[1], highest[0] / 8))

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times of the step, each of shape (t, J)."""
        return self._states(self._weights(times))

    def state(self, time: float) -> tuple[Array, Array]:
        """Coordinates and velocities at a time, each of shape (J,)."""
        q, velocity = self._states(self._weights_at(time))
        return q[0], velocity[0]

    def continued(self, step: float, following: float) -> Array:
        """Remainder at the nodes of a following step, if it goes on, shape (s, J).

        Args:
            step: Time from the start at which that begins.
            following: Its length.
        """
        nodes = self.rule.nodes
        at = (step + following * nodes.at) / self.rule.step
        return np.asarray(nodes.beyond(at, self.remainder[:, :, 0].T) @ self.stage.linear.V.T)

    def speed_integral(self, time: float) -> float:
        """Integral of |q'|^2 from the start to a time, in J s."""
        turn = int(np.ceil(time * self.stage.linear.nu[-1]))
        inner = gauss_nodes(len(self.rule.nodes.at) + turn)
        _, velocity = self.states(time * inner.at)
        return time * float(inner.weight @ np.sum(velocity**2, axis=1))

    def end(self, start: float) -> float:
        """First time after `start` at which a margin is negative, or the end of the step."""
        rule = self.rule
        if start >= rule.step:
            return rule.step
        states = zip(self.states(np.array([start])), self._states(rule.at_watched), strict=True)
        q, velocity = (np.concatenate(parts) for parts in states)
        late = np.append(True, rule.watched > start)
        margins, rates = self.stage.margins_and_rates(q[late], velocity[late])
        size = np.abs(self.stage.excess(q)).max(axis=0) + self.stage.mechanics.model.gap
        times = np.append(start, rule.watched)[late]
        found = Margins(times, margins, rates, -_ROUND_OFF * size)
        return found.first_negative(self._margin_at)

    def carried(self, changes: Array, time: float) -> Array:
        """Changes (2 J, c) of the state at the start, after a time in this step."""
        stage, rule = self.stage, self.rule
        V, masters = stage.linear.V, stage.mechanics.model.kinematics.masters
        tangents = stage.tangents(*self._states(rule.at_nodes))
        dx, rate = (V.T @ each for each in np.split(changes, 2))
        remainder = varied(masters, V, rule.at_nodes, tangents, np.concatenate([dx, rate]))
        ends = self._weights_at(time).motion(dx, rate, remainder)
        return np.concatenate([V @ each[:, 0] for each in ends])

    def _weights_at(self, time: float) -> Weights:
        """Weights at one time; those at the end are kept."""
        return self.rule.at_end if time == self.rule.step else self._weights(np.array([time]))

    def _weights(self, times: Array) -> Weights:
        return Weights.of(self.rule.nodes, self.stage.linear.nu, self.rule.step, times)

    def _states(self, weights: Weights) -> tuple[Array, Array]:
        return _of_stage(self.stage, weights.motion(self.x, self.rate, self.remainder))

    def _margin_at(self, point: int, time: float) -> tuple[float, float]:
        """A margin and its rate at a time."""
        margins, rates = self.stage.margins_and_rates(*self.states(np.array([time])))
        return float(margins[0, point]), float(rates[0, point])


def _of_stage(stage: SmoothStage, moved: tuple[Array, Array]) -> tuple[Array, Array]:
    """Coordinates and velocities of the model, (t, J), from those of the stage, (J, t, 1)."""
    V = stage.linear.V
    return stage.linear.rest + moved[0][:, :, 0].T @ V.T, moved[1][:, :, 0].T @ V.T
