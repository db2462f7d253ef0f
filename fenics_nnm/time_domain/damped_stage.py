r"""Motion between two changes of contact with terms of the velocity and a harmonic force.

With V diag(nu^2) V^T the stiffness with the points A in contact, as in `linear_stage`, and
y = (nu V^T (q - rest), V^T q') it obeys

    y' = [[0, diag(nu)], [-diag(nu), -V^T C V]] y + (0, V^T (p(t) + Phi_A^T R_AA^-1 g1_A(t))),

g1 the change of the gaps, in which margins are linear, too.

Without C the matrix is skew, so that its eigenvectors are as good as they can be. C may be any
matrix: damping, gyroscopic, negative.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig

from fenics_nnm.arrays import Array, Complex, Mask
from fenics_nnm.mechanics.closed import effects_of_gaps
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.linear_stage import LinearStage
from fenics_nnm.time_domain.propagators import Course, Dense, Diagonal, Propagator, Push
from fenics_nnm.time_domain.quadrature import Panels

#: Eigenvectors with a larger condition number lose too many digits: critical damping, most often.
_WORST_CONDITION = 1e5

#: A margin is negative below this part of the size of what it is the difference of.
_ROUND_OFF = 1e-13
_TINY = np.finfo(float).tiny

#: Margins whose second derivative is bounded by less, in m/s^2, do not move.
_STILL = 1e-200

#: A step of the search below this part of the time has arrived.
_ARRIVED = 1e-14


@dataclass(frozen=True, slots=True)
class DampedStage:
    """Equations of motion while the points in contact stay the same.

    Numbers z that the propagator moves give y = Re(basis z), and y gives z = inverse y.

    Attributes:
        linear: The conservative stage with the same points in contact.
        propagator: Solutions for z.
        basis: Shape (2 J, K).
        inverse: Shape (K, 2 J).
        inward: B per modal force, shape (K, J).
        by_wave: Margins, but for those at rest, and below them their rates, by z, (2 n_c, K).
        fastest: Largest rate in 1/s of the free motion.
        pull_by_gap: Modal force per change of the gaps, shape (J, n_c).
        margin_by_gap: Margins per change of the gaps, shape (n_c, n_c).
    """

    linear: LinearStage
    propagator: Propagator
    basis: Complex
    inverse: Complex
    inward: Complex
    by_wave: Complex
    fastest: float
    pull_by_gap: Array
    margin_by_gap: Array

    @classmethod
    def of(cls, model: ReducedModel, rate: Array, active: Mask) -> DampedStage:
        """The stage with the given points in contact.

        Args:
            model: Reduced model.
            rate: C in 1/s, shape (J, J).
            active: Points in contact, shape (n_c,).
        """
        linear = LinearStage.of(model, active)
        propagator, basis, inverse = _solved(_state_matrix(linear, rate))
        modes, shape = model.modes, linear.margin_shape
        by_state = np.concatenate([shape / linear.nu @ basis[:modes], shape @ basis[modes:]])
        inward = inverse[:, modes:] @ linear.V.T
        fastest = float(np.linalg.norm(_state_matrix(linear, rate), 2))
        by_gap = effects_of_gaps(model, active)
        return cls(linear, propagator, basis, inverse, inward, by_state, fastest, *by_gap)

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        own = self.basis, self.inverse, self.inward, self.by_wave
        return self.linear.nbytes + bytes_of(*own, self.pull_by_gap, self.margin_by_gap)

    def holds(self, q: Array) -> bool:
        """Whether all margins are positive at coordinates and changes of gaps, shape (J + n_c,)."""
        return bool(self._margins(q).min() > 0)

    def toggled(self, q: Array) -> Mask:
        """Points in contact, with the change where a margin is not positive, shape (n_c,)."""
        return np.asarray(self.linear.active ^ (self._margins(q) <= 0))

    def _margins(self, q: Array) -> Array:
        coordinates, moved = np.split(q, [len(self.linear.nu)])
        return self.linear.margins(coordinates) + self.margin_by_gap @ moved

    def motion(self, q: Array, velocity: Array, drive: Drive, phase: float) -> DampedMotion:
        """The motion from a state, at a phase of the force."""
        linear = self.linear
        state = np.concatenate([linear.nu * ((q - linear.rest) @ linear.V), velocity @ linear.V])
        push, sway = self._driven(drive, phase)
        course = self.propagator.course(self.inverse @ state, push)
        return DampedMotion(self, course, push.fastest, sway)

    def _driven(self, drive: Drive, phase: float) -> tuple[Push, Sway]:
        """What forces and moving gaps do to the motion, and gaps to the margins."""
        force, points = self.inward @ drive.turned(phase), len(self.linear.size)
        if not drive.gap.moves:
            return Push(force, drive.rates), Sway(np.zeros((points, 0), complex), np.zeros(0))
        moved, rates = drive.gap_turned(phase, points), drive.gap_rates
        by_gap = self.inward @ (self.pull_by_gap @ moved)
        push = Push(np.hstack([force, by_gap]), np.concatenate([drive.rates, rates]))
        return push, Sway(self.margin_by_gap @ moved, rates)

    def scaled(self, change: Array) -> Array:
        """Changes of (q, q') as changes of y, shape (2 J, c)."""
        by_q, by_velocity = np.split(change, 2)
        turn = self.linear.V.T
        return np.concatenate([self.linear.nu[:, None] * (turn @ by_q), turn @ by_velocity])

    def unscaled(self, change: Array) -> Array:
        """Changes of y as changes of (q, q'), shape (2 J, c)."""
        by_q, by_velocity = np.split(change, 2)
        V = self.linear.V
        return np.concatenate([V @ (by_q / self.linear.nu[:, None]), V @ by_velocity])


def _state_matrix(linear: LinearStage, rate: Array) -> Array:
    nu, nothing = np.diag(linear.nu), np.zeros((len(linear.nu), len(linear.nu)))
    return np.block([[nothing, nu], [-nu, -(linear.V.T @ rate @ linear.V)]])


def _solved(A: Array) -> tuple[Propagator, Complex, Complex]:
    """A propagator of A, with what leads to its numbers and back.

    Of conjugate pairs of eigenvalues one is kept, twice.
    """
    d, X = eig(A)
    condition = np.linalg.cond(X)
    if not condition < _WORST_CONDITION:
        unit = np.eye(len(A), dtype=complex)
        return Dense(A), unit, unit
    inverse = np.linalg.inv(X)
    kept = d.imag >= 0
    twice = np.where(d.imag[kept] > 0, 2.0, 1.0)
    return Diagonal(d[kept]), X[:, kept] * twice, inverse[kept]


@dataclass(frozen=True, slots=True)
class Sway:
    """What moving gaps add to margins, Re(sum_f m_f exp(i nu_f t)).

    Attributes:
        margin: m in m, shape (n_c, F).
        rates: nu in rad/s, shape (F,).
    """

    margin: Complex
    rates: Array

    @property
    def size(self) -> Array:
        """Bounds of it in m, shape (n_c,)."""
        return np.abs(self.margin).sum(axis=1)

    @property
    def bend(self) -> Array:
        """Bounds of its second derivative in m/s^2, shape (n_c,)."""
        return np.abs(self.margin) @ self.rates**2

    def at(self, time: float) -> Array:
        """It, and below it its rate, at a time from the start, shape (2 n_c,)."""
        waves = self.margin * np.exp(1j * time * self.rates)
        return np.concatenate([waves.sum(axis=1).real, (waves @ (1j * self.rates)).real])


@dataclass(frozen=True, slots=True)
class DampedMotion:
    """A motion of a stage.

    Attributes:
        stage: The stage.
        course: The numbers z over time.
        driven: Largest rate in 1/s of the force.
        sway: What moving gaps add to the margins.
    """

    stage: DampedStage
    course: Course
    driven: float
    sway: Sway

    @property
    def contact(self) -> bool:
        """Whether any point is in contact."""
        return self.stage.linear.contact

    def state(self, time: float) -> tuple[Array, Array]:
        """Coordinates and velocities at a time from the start, each of shape (J,)."""
        linear = self.stage.linear
        scaled, speed = np.split((self.stage.basis @ self.course.at(time)).real, 2)
        return linear.V @ (scaled / linear.nu) + linear.rest, linear.V @ speed

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times from the start, each of shape (len(times), J)."""
        stage, linear = self.stage, self.stage.linear
        z = self.course.through(times)
        scaled, speed = np.split((z @ stage.basis.T).real, 2, axis=1)
        return scaled / linear.nu @ linear.V.T + linear.rest, speed @ linear.V.T

    def carried(self, transition: Array, time: float) -> Array:
        """Derivatives of the state, shape (2 J, c), after some more time in this stage."""
        stage = self.stage
        z = stage.propagator.carried(stage.inverse @ stage.scaled(transition), time)
        return stage.unscaled((stage.basis @ z).real)

    def gathered(self, by_q: Array, by_velocity: Array, times: Array) -> Array:
        """Derivative by the first state of sums over states at times from the start, (2 J,).

        Args:
            by_q: Derivatives of the sum by the coordinates at each time, shape (g, J).
            by_velocity: Those by the velocities, shape (g, J).
            times: Times, shape (g,).
        """
        stage, linear = self.stage, self.stage.linear
        scaled = np.hstack([by_q @ linear.V / linear.nu, by_velocity @ linear.V])
        return self.by_start(stage.propagator.gathered(scaled @ stage.basis, times))

    def by_start(self, rows: Complex) -> Array:
        """Derivatives by the first state (q, q') from those by z, shape (.., K) to (.., 2 J)."""
        stage, linear = self.stage, self.stage.linear
        by_q, by_speed = np.split((rows @ stage.inverse).real, 2, axis=-1)
        return np.concatenate([linear.nu * by_q @ linear.V.T, by_speed @ linear.V.T], axis=-1)

    def speed_integral(self, time: float) -> float:
        """Integral of |q'|^2 from the start to a time, in J s."""
        panels = self.panels(time)
        _, velocity = self.states(panels.times)
        return float(panels.weights @ np.sum(velocity**2, axis=1))

    def panels(self, time: float) -> Panels:
        """Times and weights that integrate squares of the motion to round-off."""
        return Panels.over(time, 2 * max(self.stage.fastest, self.driven))

    def end(self, start: float, longest: float) -> float:
        """First time after `start` at which a margin is negative, or `longest`.

        No event is missed: for a window of time the second derivative of a margin is at most b, so
        that a margin m of rate m' stays above m + m' s - b s^2 / 2. Each step leads to where the
        first of these parabolas, or the window, ends; near an event they are Newton's.
        """
        stage, linear, points = self.stage, self.stage.linear, len(self.stage.linear.size)
        rows, course, time = stage.by_wave[:points], self.course, start
        by_size, pushed = course.bends(rows)
        sway, moves = self.sway, self.sway.rates.size > 0
        reach, offset = np.abs(rows), np.abs(linear.margin_rest)
        if moves:
            offset, pushed = offset + sway.size, pushed + sway.bend
        while time < longest:
            z = course.at(time)
            found, sizes = (stage.by_wave @ z).real, course.sizes(z)
            found = found + sway.at(time) if moves else found
            least = np.maximum(reach @ sizes + offset, np.maximum(linear.size, _TINY))
            left = found[:points] + linear.margin_rest + _ROUND_OFF * least
            if time == start and left.min() <= 0:
                return start
            bend = np.maximum(by_size @ sizes + pushed, _STILL)
            rates = found[points:] / bend
            steps = np.sqrt(np.maximum(rates * rates + 2 * left / bend, 0.0)) + rates
            step = min(float(steps.min()), course.window)
            if step <= _ARRIVED * time:
                return time
            time += step
        return longest
