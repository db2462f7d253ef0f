"""One step of exponential collocation of a damped, driven motion, and the change of contact in it.

As `smooth_step`, with damped modes in place of oscillators: on a step the pushes of the remainder
are the polynomials through their values at the s Gauss points, and variation of constants gives

    z(t) = (linear, driven motion) + sum_l W_l(t) (inward) u_l,
    W_l(t) = int_0^t exp(d (t - r)) L_l(r) dr.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.bent_stage import BentStage
from fenics_nnm.time_domain.damped_stage import DampedMotion
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.exponential_rule import GaussNodes, gauss_nodes
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.margins import Margins

#: A margin is negative below this part of the size of what it is the difference of.
_ROUND_OFF = 1e-13

#: Iterations for the remainder; a step that needs more is halved.
_ITERATIONS = 30

#: Changes of the remainder below these parts of the motion: converged, if the next one would be,
#: and stalled in round-off.
_CONVERGED, _STALLED = 2e-15, 1e-12

#: Gauss points of the integrals, besides half the angle that the fastest mode turns by.
_POINTS = 16


@dataclass(frozen=True, slots=True)
class BentRule:
    """Times and weights of a step of some length in a stage.

    Attributes:
        step: Length in s.
        nodes: Gauss points, s of them.
        by_pushes: What is seen at the nodes by the pushes there, shape (s (3 k + P), s (P + k)).
        watched: Times at which margins are looked at, the last at the end, shape (d,).
        at_watched: Weights W there, shape (d, K, s).
    """

    step: float
    nodes: GaussNodes
    by_pushes: Array
    watched: Array
    at_watched: Complex

    @classmethod
    def of(cls, nodes: GaussNodes, stage: BentStage, step: float) -> BentRule:
        """Times apart by no more than a radian of the fastest mode."""
        count = max(8, int(np.ceil(step * float(np.abs(stage.exponents).max()))))
        watched = step * np.arange(1, count + 1) / count
        at_nodes = weights(nodes, stage.exponents, step, step * nodes.at)
        whole = np.einsum("rk,tks,kp->trsp", stage.sees, at_nodes, stage.inward, optimize=True)
        s, seen, _, pushes = whole.shape
        return cls(
            step=step,
            nodes=nodes,
            by_pushes=np.ascontiguousarray(whole.real).reshape(s * seen, s * pushes),
            watched=watched,
            at_watched=weights(nodes, stage.exponents, step, watched),
        )

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return bytes_of(self.by_pushes, self.at_watched)


def weights(nodes: GaussNodes, exponents: Complex, step: float, times: Array) -> Complex:
    """W at times of a step, shape (t, K, s)."""
    turn = float(times.max(initial=0.0)) * float(np.abs(exponents).max())
    inner = gauss_nodes(_POINTS + int(np.ceil(turn / 2)))
    passed = times[:, None] * inner.at
    basis = nodes.basis(passed / step) * (times[:, None] * inner.weight)[:, :, None]
    left = (times[:, None] - passed)[:, None, :]
    return np.asarray(np.exp(exponents[:, None] * left) @ basis)


@dataclass(frozen=True, slots=True)
class Start:
    """Where a step starts.

    Attributes:
        stage: Stage.
        drive: What drives the motion.
        phase: Its phase.
        linear: The motion without the remainder.
        size: Size of velocities of the motion.
    """

    stage: BentStage
    drive: Drive
    phase: float
    linear: DampedMotion
    size: float

    @classmethod
    def of(
        cls, stage: BentStage, state: tuple[Array, Array], drive: Drive, phase: float, size: float
    ) -> Start:
        """A state of the model, its coordinates and velocities of shape (J,)."""
        return cls(stage, drive, phase, stage.motion(*state, drive, phase), size)

    def seen(self, times: Array) -> Array:
        """What the remainder sees without itself at times, shape (t, 3 k + P)."""
        stage, remainder = self.stage, self.stage.smooth.remainder
        found = (self.linear.course.through(times) @ stage.sees.T).real
        found[:, : len(remainder.offset)] += remainder.offset
        return np.asarray(found + stage.given(self.drive, self.phase).at(times))


@dataclass(frozen=True, slots=True)
class BentStep:
    """A step whose equations hold at the nodes.

    Attributes:
        start: Where it starts.
        rule: Times and weights.
        seen: What the remainder sees at the nodes, shape (s, 3 k + P).
        pushes: What it pushes by there, shape (s, P + k).
    """

    start: Start
    rule: BentRule
    seen: Array
    pushes: Array

    @classmethod
    def solved(cls, start: Start, rule: BentRule, guess: Array) -> BentStep | None:
        """The step from a state, by fixed-point iteration on the pushes.

        Args:
            start: Where it starts.
            rule: Times and weights.
            guess: Pushes at the nodes to begin with, shape (s, P + k).

        Returns:
            None where it does not converge.
        """
        smooth, size = start.stage.smooth, start.size
        directions = smooth.remainder.directions
        wide = size * (1 + rule.step * float(smooth.linear.nu[-1]))
        free = start.seen(rule.step * rule.nodes.at)
        pushes, before = guess, np.inf
        for _ in range(_ITERATIONS):
            seen = free + (rule.by_pushes @ pushes.ravel()).reshape(free.shape)
            found = smooth.remainder(seen.T).T
            change = rule.step * float(np.abs((found - pushes) @ directions.T).max(initial=0.0))
            pushes = found
            following = change * (change / before if before < np.inf else 1.0)
            if following <= _CONVERGED * wide or before / 2 < change <= _STALLED * wide:
                return cls(start, rule, seen, pushes)
            if not change < 1e3 * before:
                return None
            before = change
        return None

    @property
    def contact(self) -> bool:
        """Whether any point is in contact."""
        return self.start.stage.smooth.linear.contact

    @property
    def tail(self) -> float:
        """Size of the highest coefficients of the remainder, as a velocity."""
        remainder = self.pushes @ self.start.stage.smooth.remainder.directions.T
        highest = np.linalg.norm(self.rule.nodes.to_legendre[-2:] @ remainder, axis=1)
        return self.rule.step * float(max(highest[1], highest[0] / 8))

    def state(self, time: float) -> tuple[Array, Array]:
        """Coordinates and velocities at a time, each of shape (J,)."""
        q, velocity = self.states(np.array([time]))
        return q[0], velocity[0]

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times of the step, each of shape (t, J)."""
        linear = self.start.stage.smooth.linear
        x, rate = self._moved(times, self._weights(times))
        return x @ linear.V.T + linear.rest, rate @ linear.V.T

    def carried(self, transition: Array, time: float) -> Array:
        """Derivatives of the state, shape (2 J, c), after some more time in this stage.

        With B the slopes of the pushes, and h what is seen of the changes without pushes, these
        change by u = B (h + A u).
        """
        stage, rule, damped = self.start.stage, self.rule, self.start.stage.damped
        z, columns = damped.inverse @ damped.scaled(transition), transition.shape[1]
        grown = np.exp(np.multiply.outer(rule.step * rule.nodes.at, stage.exponents))
        free = ((grown[:, None, :] * stage.sees) @ z).real
        slopes, size = stage.smooth.remainder.slopes(self.seen.T), self.pushes.size
        nodes, seen = self.seen.shape
        matrix = np.eye(size) - (slopes @ rule.by_pushes.reshape(nodes, seen, size)).reshape(
            size, size
        )
        pushes = np.linalg.solve(matrix, (slopes @ free).reshape(size, columns))
        by_node = self._weights(np.array([time]))[0]
        inward = by_node[:, :, None] * stage.inward[:, None, :]
        after = damped.propagator.carried(z, time) + inward.reshape(len(z), size) @ pushes
        return damped.unscaled((damped.basis @ after).real)

    def continued(self, step: float, following: float) -> Array:
        """Pushes at the nodes of a following step, if it goes on, shape (s, P + k).

        Args:
            step: Time from the start at which that begins.
            following: Its length.
        """
        nodes = self.rule.nodes
        return nodes.beyond((step + following * nodes.at) / self.rule.step, self.pushes.T).T

    def speed_integral(self, time: float) -> float:
        """Integral of |q'|^2 from the start to a time, in J s."""
        turn = int(np.ceil(time * float(np.abs(self.start.stage.exponents).max())))
        inner = gauss_nodes(len(self.rule.nodes.at) + turn)
        _, velocity = self.states(time * inner.at)
        return time * float(inner.weight @ np.sum(velocity**2, axis=1))

    def end(self, start: float) -> float:
        """First time after `start` at which a margin is negative, or the end of the step."""
        rule = self.rule
        if start >= rule.step:
            return rule.step
        late = rule.watched >= start
        first = np.array([start])
        times = np.append(first, rule.watched[late])
        by_time = np.concatenate([self._weights(first), rule.at_watched[late]])
        margins, rates, size = self._margins(times, by_time)
        found = Margins(times, margins, rates, -_ROUND_OFF * size)
        return found.first_negative(self._margin_at)

    def _margin_at(self, point: int, time: float) -> tuple[float, float]:
        """A margin and its rate at a time."""
        at = np.array([time])
        margins, rates, _ = self._margins(at, self._weights(at))
        return float(margins[0, point]), float(rates[0, point])

    def _margins(self, times: Array, by_time: Complex) -> tuple[Array, Array, Array]:
        """Margins and their rates, each (t, n_c), and sizes of what they are differences of."""
        smooth, drive = self.start.stage.smooth, self.start.drive
        motion = np.concatenate([each.T for each in self._moved(times, by_time)], axis=1)
        margins, rates, size = smooth.course.along(motion)
        margins, rates = margins.T, rates.T
        if drive.gap.moves:
            moved = drive.gap_turned(self.start.phase, len(size)).T
            waves = np.exp(1j * np.multiply.outer(times, drive.gap_rates))
            margins = margins - (waves @ moved).real @ smooth.margin.T
            rates = rates - ((1j * drive.gap_rates * waves) @ moved).real @ smooth.margin.T
            size = size + np.abs(moved).sum(axis=0)
        return margins, rates, size

    def _moved(self, times: Array, by_time: Complex) -> tuple[Array, Array]:
        """Coordinates of the stage, and their velocities, at times, each (t, J)."""
        stage = self.start.stage
        z = self.start.linear.course.through(times)
        z = z + np.einsum("tks,ks->tk", by_time, stage.inward @ self.pushes.T)
        scaled, speed = np.split((z @ stage.damped.basis.T).real, 2, axis=1)
        return scaled / stage.smooth.linear.nu, speed

    def _weights(self, times: Array) -> Complex:
        at_end = len(times) == 1 and times[0] == self.rule.step
        if at_end:
            return self.rule.at_watched[-1:]
        return weights(self.rule.nodes, self.start.stage.exponents, self.rule.step, times)
