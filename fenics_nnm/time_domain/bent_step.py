"""One step of exponential collocation of a damped, driven motion, and the change of contact in it.

As `smooth_step`, with damped modes in place of oscillators: on a step the pushes of the remainder
are the polynomials through their values at the s Gauss points, and variation of constants gives

    z(t) = (linear, driven motion) + sum_l W_l(t) (inward) u_l,
    W_l(t) = int_0^t exp(d (t - r)) L_l(r) dr.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.bent_stage import BentStage, Given
from fenics_nnm.time_domain.damped_stage import DampedMotion
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.exponential_rule import GaussNodes, gauss_points
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.margins import Margins

#: A margin is negative below this part of the size of what it is the difference of.
_ROUND_OFF = 1e-13

#: Iterations for the remainder; a step that needs more is halved.
_ITERATIONS = 30

#: Changes of the remainder below this part of the motion that do not shrink are round-off.
_STALLED = 1e-12

#: Gauss points of the integrals, besides half the angle that the fastest mode turns by.
_POINTS = 16


@dataclass(frozen=True, slots=True)
class BentRule:
    """Times and weights of a step of some length in a stage.

    What the remainder sees at the nodes has a row for each number and a column for each node, as
    in `step_rule`.

    Attributes:
        step: Length in s.
        nodes: Gauss points, s of them.
        by_pushes: What is seen at the nodes by the pushes there, shape ((3 k + P) s, (P + k) s).
        watched: Times at which margins are looked at, the last at the end, shape (d,).
        at_watched: Weights W there, shape (K, d, s).
        onwards: From pushes to a guess at those of a following step of this length, shape (s, s).
    """

    step: float
    nodes: GaussNodes
    by_pushes: Array
    watched: Array
    at_watched: Complex
    onwards: Array

    @classmethod
    def of(cls, nodes: GaussNodes, stage: BentStage, step: float, first: float) -> BentRule:
        """A step in which margins are looked at a radian of the fastest mode apart, or less.

        Args:
            nodes: Gauss points.
            stage: Stage.
            step: Length in s.
            first: First time at which margins are looked at.
        """
        count = max(8, int(np.ceil(step * float(np.abs(stage.exponents).max()))))
        watched = step * np.arange(1, count + 1) / count
        watched = np.append(first, watched[watched > first])
        return cls(
            step=step,
            nodes=nodes,
            by_pushes=_by_pushes(weights(nodes, stage.exponents, step, step * nodes.at), stage),
            watched=watched,
            at_watched=weights(nodes, stage.exponents, step, watched),
            onwards=nodes.beyond(1 + nodes.at, np.eye(len(nodes.at))),
        )

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return bytes_of(self.by_pushes, self.at_watched)


def weights(nodes: GaussNodes, exponents: Complex, step: float, times: Array) -> Complex:
    """W at times of a step, shape (K, t, s)."""
    turn = float(times.max(initial=0.0)) * float(np.abs(exponents).max())
    inner = gauss_points(_POINTS + int(np.ceil(turn / 2)))
    passed = times[:, None] * inner.at
    basis = nodes.basis(passed / step) * (times[:, None] * inner.weight)[:, :, None]
    left = (times[:, None] - passed)[:, None, :]
    found = np.exp(exponents[:, None] * left) @ basis
    return np.ascontiguousarray(found.swapaxes(0, 1))


def _by_pushes(at_nodes: Complex, stage: BentStage) -> Array:
    """Shape ((3 k + P) s, (P + k) s)."""
    (seen, size), pushes, nodes = stage.sees.shape, stage.inward.shape[1], at_nodes.shape[1]
    along = (stage.sees[:, None, :] * stage.inward.T).reshape(seen * pushes, size)
    # (row, push, node, node of the push)
    whole = (along @ at_nodes.reshape(size, nodes**2)).real.reshape(seen, pushes, nodes, nodes)
    return np.ascontiguousarray(whole.swapaxes(1, 2)).reshape(seen * nodes, pushes * nodes)


@dataclass(frozen=True, slots=True)
class Start:
    """Where a step starts.

    Attributes:
        stage: Stage.
        drive: What drives the motion.
        phase: Its phase.
        linear: The motion without the remainder.
        given: What the remainder sees of the drive.
        size: Size of velocities of the motion.
    """

    stage: BentStage
    drive: Drive
    phase: float
    linear: DampedMotion
    given: Given
    size: float

    @classmethod
    def of(
        cls, stage: BentStage, state: tuple[Array, Array], drive: Drive, phase: float, size: float
    ) -> Start:
        """A state of the model, its coordinates and velocities of shape (J,)."""
        linear, given = stage.motion(*state, drive, phase), stage.given(drive, phase)
        return cls(stage, drive, phase, linear, given, size)

    def seen(self, times: Array) -> Array:
        """What the remainder sees without itself at times, shape (3 k + P, t)."""
        stage, offset = self.stage, self.stage.smooth.remainder.offset
        found = (stage.sees @ self.linear.course.through(times).T).real
        found[: len(offset)] += offset[:, None]
        return np.asarray(found + self.given.at(times))


@dataclass(frozen=True, slots=True)
class BentStep:
    """A step whose equations hold at the nodes.

    Attributes:
        start: Where it starts.
        rule: Times and weights.
        seen: What the remainder sees at the nodes, shape (3 k + P, s).
        pushes: What it pushes by there, shape (P + k, s).
        inward: What that does to z', shape (K, s).
    """

    start: Start
    rule: BentRule
    seen: Array
    pushes: Array
    inward: Complex

    @classmethod
    def solved(
        cls, start: Start, rule: BentRule, guess: Array, converged: float
    ) -> BentStep | None:
        """The step from a state, by fixed-point iteration on the pushes.

        Args:
            start: Where it starts.
            rule: Times and weights.
            guess: Pushes at the nodes to begin with, shape (P + k, s).
            converged: Change of the remainder, as a part of the motion, that the next iteration is
                to be below.

        Returns:
            None where it does not converge.
        """
        smooth = start.stage.smooth
        wide = start.size * (1 + rule.step * float(smooth.linear.nu[-1]))
        free, reach = start.seen(rule.step * rule.nodes.at), rule.step * smooth.remainder.reach
        pushes, before = guess, np.inf
        for _ in range(_ITERATIONS):
            seen = free + (rule.by_pushes @ pushes.ravel()).reshape(free.shape)
            found = smooth.remainder(seen)
            moved = reach[:, None] * (found - pushes)
            change = math.sqrt(np.vdot(moved, moved))
            pushes = found
            following = change * (change / before if before < np.inf else 1.0)
            if following <= converged * wide or before / 2 < change <= _STALLED * wide:
                return cls(start, rule, seen, pushes, start.stage.inward @ pushes)
            if not change < 1e3 * before:
                return None
            before = change
        return None

    @property
    def nbytes(self) -> int:
        """Bytes of its own arrays."""
        return bytes_of(self.seen, self.pushes, self.inward)

    @property
    def contact(self) -> bool:
        """Whether any point is in contact."""
        return self.start.stage.smooth.linear.contact

    @property
    def tail(self) -> float:
        """Size of the highest coefficients of the remainder, as a velocity."""
        coefficients = self.pushes @ self.rule.nodes.to_legendre[-2:].T
        directions = self.start.stage.smooth.remainder.directions
        before, last = np.linalg.norm(directions @ coefficients, axis=0)
        return self.rule.step * float(max(last, before / 8))

    def state(self, time: float) -> tuple[Array, Array]:
        """Coordinates and velocities at a time, each of shape (J,)."""
        q, velocity = self.states(np.array([time]))
        return q[0], velocity[0]

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times of the step, each of shape (t, J)."""
        linear, count = self.start.stage.smooth.linear, len(times)
        motion = self._motion(times, self._weights(times))
        return linear.rest + motion[:, :count].T @ linear.V.T, motion[:, count:].T @ linear.V.T

    def carried(self, transition: Array, time: float) -> Array:
        """Derivatives of the state, shape (2 J, c), after some more time in this stage.

        With B the slopes of the pushes, and h what is seen of the changes without pushes, these
        change by u = B (h + A u).
        """
        stage, rule, damped = self.start.stage, self.rule, self.start.stage.damped
        z, columns = damped.inverse @ damped.scaled(transition), transition.shape[1]
        grown = np.exp(np.multiply.outer(stage.exponents, rule.step * rule.nodes.at))
        rows, size = len(self.seen), self.pushes.size
        by_start = (stage.sees[:, None, :] * grown.T).reshape(-1, len(z))
        free = (by_start.real @ z.real - by_start.imag @ z.imag).reshape(rows, -1, columns)
        slopes = stage.smooth.remainder.slopes(self.seen)
        by_pushes = rule.by_pushes.reshape(rows, -1, size)
        matrix = np.eye(size) - _pushed(slopes, by_pushes)
        pushes = np.linalg.solve(matrix, _pushed(slopes, free))
        by_node = self._weights(np.array([time]))[:, 0]
        inward = (stage.inward[:, :, None] * by_node[:, None, :]).reshape(len(z), size)
        after = damped.propagator.carried(z, time) + inward @ pushes
        return damped.unscaled((damped.basis @ after).real)

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
        turn = int(np.ceil(time * float(np.abs(self.start.stage.exponents).max())))
        inner = gauss_points(len(self.rule.nodes.at) + turn)
        _, velocity = self.states(time * inner.at)
        return time * float(inner.weight @ np.sum(velocity**2, axis=1))

    def end(self) -> float:
        """First time at which a margin is negative, from the first that is watched, or the end."""
        rule = self.rule
        if rule.watched[0] >= rule.step:
            return rule.step
        margins, rates, size = self._margins(rule.watched, rule.at_watched)
        found = Margins(rule.watched, margins.T, rates.T, -_ROUND_OFF * size)
        return found.first_negative(self._margin_at)

    def _margin_at(self, point: int, time: float) -> tuple[float, float]:
        """A margin and its rate at a time."""
        at = np.array([time])
        margins, rates, _ = self._margins(at, self._weights(at))
        return float(margins[point, 0]), float(rates[point, 0])

    def _margins(self, times: Array, by_time: Complex) -> tuple[Array, Array, Array]:
        """Margins and their rates, each (n_c, t), and sizes of what they are differences of."""
        smooth, drive = self.start.stage.smooth, self.start.drive
        margins, rates, size = smooth.course.along(self._motion(times, by_time))
        if drive.gap.moves:
            moved = drive.gap_turned(self.start.phase, len(size))
            waves = np.exp(1j * np.multiply.outer(drive.gap_rates, times))
            margins = margins - smooth.margin @ (moved @ waves).real
            turning = 1j * drive.gap_rates[:, None] * waves
            rates = rates - smooth.margin @ (moved @ turning).real
            size = size + np.abs(moved).sum(axis=1)
        return margins, rates, size

    def _motion(self, times: Array, by_time: Complex) -> Array:
        """Coordinates of the stage and, beside them, their velocities, at times, (J, 2 t)."""
        stage = self.start.stage
        z = self.start.linear.course.through(times).T + (by_time @ self.inward[:, :, None])[:, :, 0]
        scaled, speed = np.split((stage.damped.basis @ z).real, 2)
        return np.hstack([scaled / stage.smooth.linear.nu[:, None], speed])

    def _weights(self, times: Array) -> Complex:
        at_end = len(times) == 1 and times[0] == self.rule.step
        if at_end:
            return self.rule.at_watched[:, -1:]
        return weights(self.rule.nodes, self.start.stage.exponents, self.rule.step, times)


def _pushed(slopes: Array, seen: Array) -> Array:
    """Changes of pushes, ((P + k) s, c), by those of what is seen, (3 k + P, s, c)."""
    found = (slopes @ seen.swapaxes(0, 1)).swapaxes(0, 1)
    return np.asarray(found).reshape(-1, seen.shape[2])
