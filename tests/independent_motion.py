"""Motions in time by other means than the program's: DOP853 and principal pivoting."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.model import ReducedModel

#: Violations below this, relative to the gap, are round-off.
_ROUND_OFF = 1e-12

#: Shooting: most Newton steps, largest miss of the start, largest distance from the point.
_NEWTON_STEPS, _SHOT, _FARTHEST = 8, 1e-5, 0.3


class TooLong(Exception):
    """Integration would take too many steps."""


@dataclass(frozen=True, slots=True)
class Return:
    """How a motion comes back after its period.

    Attributes:
        error: Distance from its start over its amplitude, in the energy norm.
        late: By which part of the period after its end it is nearest to its start, to first order.
    """

    error: float
    late: float


@dataclass(frozen=True, slots=True)
class Exact:
    """The exact periodic motion of its energy that Newton's iteration leads to from a point.

    Attributes:
        frequency: In Hz; nan if none was found.
        distance: Of its start from that of the point, over the amplitude, in the energy norm.
    """

    frequency: float = float("nan")
    distance: float = float("nan")


class Pivoting:
    """0 <= lambda  _|_  R lambda - excess >= 0 by Murty's least-index principal pivoting.

    It ends for every positive definite R, from any set of active points to begin with: that of
    the call before (K. G. Murty, Opsearch 11 (1974) 123-135).
    """

    def __init__(self, R: Array) -> None:
        self._R = R
        self._active = np.zeros(len(R), dtype=bool)
        self._solvers: dict[bytes, Array] = {}

    def __call__(self, excess: Array) -> Array:
        while True:
            force = self.slope @ excess
            wrong = np.where(self._active, force, self._R @ force - excess) < -_ROUND_OFF
            if not wrong.any():
                return np.maximum(force, 0.0)
            self._active[np.argmax(wrong)] ^= True

    @property
    def slope(self) -> Array:
        """R_AA^-1 at the rows and columns of the points in contact at the last call, else 0."""
        key = self._active.tobytes()
        if key not in self._solvers:
            solver, chosen = np.zeros_like(self._R), np.flatnonzero(self._active)
            solver[np.ix_(chosen, chosen)] = np.linalg.inv(self._R[np.ix_(chosen, chosen)])
            self._solvers[key] = solver
        return self._solvers[key]


@dataclass(frozen=True, slots=True)
class _Bent:
    """Terms of second-order kinematics by the formulas of `mechanics.second_order`, written anew.

    Attributes:
        modes: Number of modes J.
        masters: Their places, shape (k,).
        Theta: Second derivatives of the closing, shape (n_c, k, k).
        alpha: Quadratic stiffness, shape (J, k, k).
        beta: Cubic stiffness, shape (k, k, k, k).
        D: Inertia, shape (k, k, k, k).
    """

    modes: int
    masters: Array
    Theta: Array
    alpha: Array
    beta: Array
    D: Array

    @classmethod
    def of(cls, model: ReducedModel, amplitude: float, period: float, length: float) -> _Bent:
        """Of a model, with coordinates over an amplitude, times a period, closings a length."""
        masters, tensors = model.kinematics.masters, model.kinematics.tensors
        k, points, modes = len(masters), len(model.gap), model.modes
        if not k:
            empty = np.zeros((0,) * 4)
            return cls(
                modes, masters, np.zeros((points, 0, 0)), np.zeros((modes, 0, 0)), empty, empty
            )
        return cls(
            modes,
            masters,
            tensors["Theta"] * amplitude**2 / length,
            tensors["alpha"] * amplitude * period**2,
            tensors["beta"] * (amplitude * period) ** 2,
            tensors["D"] * amplitude**2,
        )

    def slope(self, q: Array) -> Array:
        """Theta q, shape (n_c, J)."""
        found = np.zeros((len(self.Theta), self.modes))
        found[:, self.masters] = self.Theta @ q[self.masters]
        return found

    def force(self, q: Array, velocity: Array) -> Array:
        """Polynomial stiffness, and the part of the inertia with velocities, shape (J,)."""
        x, v = q[self.masters], velocity[self.masters]
        found = np.einsum("ijk,j,k->i", self.alpha, x, x)
        others = np.setdiff1d(np.arange(self.modes), self.masters)
        found[self.masters] += 2 * np.einsum("a,ajk,k->j", q[others], self.alpha[others], x)
        found[self.masters] += np.einsum("ijkl,j,k,l->i", self.beta, x, x, x)
        found[self.masters] += np.einsum("ikjl,k,j,l->i", self.D, x, v, v)
        return found

    def mass(self, q: Array) -> Array:
        """M(q), shape (J, J)."""
        x, found = q[self.masters], np.eye(self.modes)
        found[np.ix_(self.masters, self.masters)] += np.einsum("ikjl,k,l->ij", self.D, x, x)
        return found


class Motion:
    """A model in the units of one of its motions: period, amplitude, reach of its contact points.

    States are coordinates, then velocities; the norm of a weighted state is that of the energy.
    """

    def __init__(self, model: ReducedModel, point: BranchPoint, harmonics: int) -> None:
        period, length = 1 / point.motion.frequency, np.abs(model.Phi @ point.motion.q.T).max()
        amplitude = np.sqrt(2 * point.motion.energy) / (2 * np.pi * point.motion.frequency)
        self._omega, self._Phi = model.omega * period, model.Phi * amplitude / length
        self._bent = _Bent.of(model, amplitude, period, length)
        self._R = model.R * (amplitude / period / length) ** 2
        self._law, self._gap = Pivoting(self._R), model.gap / length
        self.weight = np.concatenate([self._omega, np.ones_like(self._omega)])
        self.start = _state(point.motion.q / amplitude, harmonics)
        self._at_rest = 0.0
        self._at_rest = self.energy(self._rest())

    def rate(self, time: float, state: Array) -> Array:
        """q' and q'' = -omega^2 q - Phi^T lambda(q), with what second order adds."""
        q, velocity = np.split(state, 2)
        shapes = self._Phi + self._bent.slope(q)
        force = self._law(self._Phi @ q + self._bent.slope(q) @ q / 2 - self._gap)
        pull = -(self._omega**2) * q - force @ shapes - self._bent.force(q, velocity)
        return np.concatenate([velocity, np.linalg.solve(self._bent.mass(q), pull)])

    def rate_with_derivative(self, time: float, both: Array) -> Array:
        """The same beside the derivative by the first state."""
        state, derivative = np.split(both, [len(self.weight)])
        rate = self.rate(time, state)
        q, velocity = np.split(derivative.reshape(len(state), -1), 2)
        held = self._Phi.T @ (self._law.slope @ (self._Phi @ q))
        return np.concatenate(
            [rate, velocity.ravel(), (-(self._omega**2)[:, None] * q - held).ravel()]
        )

    def energy(self, state: Array) -> float:
        """Total energy from the state of rest, constant in time."""
        force = self._law(self._Phi @ np.split(state, 2)[0] - self._gap)
        twice = float(np.sum((self.weight * state) ** 2) + force @ self._R @ force)
        return twice / 2 - self._at_rest

    def _rest(self) -> Array:
        """The state in which the forces at the gaps keep it without motion."""
        flexible = self._Phi / self._omega
        force = Pivoting(self._R + flexible @ flexible.T)(-self._gap)
        return np.append(-(force @ self._Phi) / self._omega**2, np.zeros_like(self._omega))


def after_a_period(
    model: ReducedModel, point: BranchPoint, harmonics: int, *, most_steps: int = 20_000
) -> Return:
    """How a motion returns when its model is integrated in time.

    Raises:
        TooLong: if that takes more than `most_steps` steps.
    """
    motion = Motion(model, point, harmonics)
    end = _integrated(motion.rate, motion.start, 1.0, 1e-9, most_steps)
    missed = motion.weight * (end - motion.start)
    drift = motion.weight * motion.rate(0.0, motion.start)
    return Return(
        error=float(np.linalg.norm(missed)) / (2 * np.pi),
        late=-float(missed @ drift / (drift @ drift)),
    )


def exact_motion(
    model: ReducedModel, point: BranchPoint, harmonics: int, *, most_steps: int = 20_000
) -> Exact:
    """The periodic motion of the same energy near a point, by shooting.

    Newton's iteration on x(T) - x(0) = 0, the energy and the phase, for x(0) and T. Near a fold
    there is another motion of the same energy, which it may lead to.

    Raises:
        TooLong: if an integration takes more than `most_steps` steps.
    """
    motion = Motion(model, point, harmonics)
    state, period, size = motion.start, 1.0, len(motion.start)
    for _ in range(_NEWTON_STEPS):
        both = np.concatenate([state, np.eye(size).ravel()])
        both = _integrated(motion.rate_with_derivative, both, period, 1e-7, most_steps)
        end, derivative = both[:size], both[size:].reshape(size, size)
        here, there = motion.rate(0.0, state), motion.rate(0.0, end)
        velocity, acceleration = np.split(here, 2)
        gradient = np.concatenate([-acceleration, velocity])
        matrix = np.zeros((size + 2, size + 1))
        matrix[:size, :size] = motion.weight[:, None] * (derivative - np.eye(size))
        matrix[:size, size] = motion.weight * there
        matrix[size, :size] = gradient / (2 * np.pi)
        matrix[size + 1, :size] = motion.weight**2 * here / np.linalg.norm(motion.weight * here)
        wrong = np.append(motion.weight * (end - state), [0.0, 0.0])
        wrong[size] = motion.energy(state) / (2 * np.pi) - np.pi
        matrix[:, :size] /= motion.weight
        step = -np.linalg.lstsq(matrix, wrong, rcond=1e-12)[0]
        if np.linalg.norm(wrong) < _SHOT * 2 * np.pi:
            distance = np.linalg.norm(motion.weight * (state - motion.start)) / (2 * np.pi)
            return Exact(point.motion.frequency / period, float(distance))
        state, period = state + step[:size] / motion.weight, period + float(step[size])
        if np.linalg.norm(motion.weight * (state - motion.start)) > _FARTHEST * 2 * np.pi:
            break
        if abs(period - 1) > _FARTHEST:
            break
    return Exact()


def _integrated(
    rate: Callable[[float, Array], Array], start: Array, span: float, rtol: float, most_steps: int
) -> Array:
    steps = DOP853(rate, 0.0, start, span, rtol=rtol, atol=rtol / 100)
    for _ in range(most_steps):
        steps.step()
        if steps.status != "running":
            assert steps.status == "finished", steps.status
            return np.asarray(steps.y)
    raise TooLong


def _state(q: Array, harmonics: int) -> Array:
    """Coordinates and velocities at the start: of cosines, then sines, in periods."""
    order, sines = np.arange(1, harmonics + 1), q[harmonics + 1 :]
    velocity = 2 * np.pi * order @ sines if len(sines) else np.zeros(q.shape[1])
    return np.concatenate([q[: harmonics + 1].sum(axis=0), velocity])
