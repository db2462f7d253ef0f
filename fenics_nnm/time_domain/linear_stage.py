"""Motion between two changes of contact: linear, so known in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.closed import ClosedPoints
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.kept import bytes_of

Complex = NDArray[np.complexfloating[Any, Any]]

#: A margin is negative below this part of the size of what it is the difference of.
_ROUND_OFF = 1e-13
_TINY = np.finfo(float).tiny

#: Margins whose second derivative is bounded by less, in m/s^2, do not move.
_STILL = 1e-200

#: A step of the search below this part of the time has arrived.
_ARRIVED = 1e-14


@dataclass(frozen=True, slots=True)
class LinearStage:
    r"""Equations of motion while the points in contact stay the same, in their own modes.

    With A the points in contact and K_A = diag(omega^2) + Phi_A^T R_AA^-1 Phi_A = V diag(nu^2) V^T,

        q'' = -K_A (q - rest),      rest = K_A^-1 Phi_A^T R_AA^-1 gap_A.

    The stage lasts while all margins are positive, see `mechanics.closed`.

    Attributes:
        nu: Circular frequencies in rad/s, shape (J,).
        V: Orthonormal modes as columns, shape (J, J).
        rest: Position of rest, kg^1/2 m, shape (J,).
        margin_shape: Margins per modal coordinate of the stage, shape (n_c, J).
        by_wave: Margins, but for those at rest, and below them their rates, per real and imaginary
            part of the modal coordinates in turn, shape (2 n_c, 2 J).
        margin_rest: Margins in m at rest, shape (n_c,).
        bounds: Sizes of the margins and of their second derivatives per amplitude of the modal
            coordinates, one below the other, shape (2 n_c, J).
        size: Smallest size in m that the margins are measured by, shape (n_c,).
        stiffness: Contact force per margin in N/m, 0 for open points, shape (n_c,).
        active: Which points are in contact, shape (n_c,).
        contact: Whether any point is.
    """

    nu: Array
    V: Array
    rest: Array
    margin_shape: Array
    by_wave: Array
    margin_rest: Array
    bounds: Array
    size: Array
    stiffness: Array
    active: NDArray[np.bool_]
    contact: bool

    @classmethod
    def of(cls, model: ReducedModel, active: NDArray[np.bool_]) -> LinearStage:
        """The stage with the given points in contact, shape (n_c,)."""
        nu, V = model.omega, np.eye(model.modes)
        rest: Array = np.zeros(model.modes)
        shape, margin_rest = -model.Phi, model.gap
        stiffness: Array = np.zeros(model.points)
        if active.any():
            held = ClosedPoints.of(model, active)
            squares, V = eigh(held.stiffness)
            nu, rest = np.sqrt(squares), V @ ((V.T @ held.pull) / squares)
            shape, margin_rest = held.gradient @ V, held.gradient @ rest + held.offset
            stiffness = held.force_per_margin
        size = np.abs(shape)
        return cls(
            nu=nu,
            V=V,
            rest=rest,
            margin_shape=shape,
            by_wave=_by_wave(shape, nu),
            margin_rest=margin_rest,
            bounds=np.vstack([size, size * nu**2]),
            size=np.abs(model.gap),
            stiffness=stiffness,
            active=active,
            contact=bool(active.any()),
        )

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return bytes_of(self.V, self.margin_shape, self.by_wave, self.bounds, self.stiffness)

    def margins(self, q: Array) -> Array:
        """Margins in m at coordinates of shape (J,), shape (n_c,)."""
        return np.asarray(self.margin_shape @ (self.V.T @ (q - self.rest)) + self.margin_rest)

    def holds(self, q: Array) -> bool:
        """Whether all margins are positive at coordinates of shape (J,)."""
        return bool(self.margins(q).min() > 0)

    def forces(self, q: Array) -> Array:
        """Contact forces in N at coordinates of shape (J,), shape (n_c,)."""
        return self.stiffness * self.margins(q)

    def pull(self, q: Array) -> Array:
        """Derivative K_A (q - rest) of the energy by the coordinates, shape (J,)."""
        return np.asarray(self.V @ (self.nu**2 * (self.V.T @ (q - self.rest))))

    def toggled(self, q: Array) -> NDArray[np.bool_]:
        """Points in contact, with the change where a margin is not positive, shape (n_c,)."""
        return np.asarray(self.active ^ (self.margins(q) <= 0))

    def motion(self, q: Array, velocity: Array) -> StageMotion:
        """The motion from a state."""
        sine = (velocity @ self.V) / self.nu
        return StageMotion(self, (q - self.rest) @ self.V - 1j * sine)

    def carried(self, transition: Array, time: float) -> Array:
        """State-transition matrix, shape (2 J, c), after some more time in this stage.

        Args:
            transition: Derivatives of the state by c numbers before, shape (2 J, c).
            time: Time in s.
        """
        modes = len(self.nu)
        by_q, by_velocity = self.V.T @ transition.reshape(2, modes, -1)
        cosine, sine = np.cos(self.nu * time)[:, None], np.sin(self.nu * time)[:, None]
        nu = self.nu[:, None]
        after = np.stack(
            [cosine * by_q + sine / nu * by_velocity, cosine * by_velocity - nu * sine * by_q]
        )
        return np.asarray(self.V @ after).reshape(transition.shape)


def _by_wave(shape: Array, nu: Array) -> Array:
    """See `LinearStage.by_wave`: with z' = i nu z the rate of Re(z) is -nu Im(z)."""
    points, modes = shape.shape
    by_part = np.zeros((2, points, modes, 2))
    by_part[0, :, :, 0] = shape
    by_part[1, :, :, 1] = -shape * nu
    return by_part.reshape(2 * points, 2 * modes)


@dataclass(frozen=True, slots=True)
class StageMotion:
    """A motion of a stage: V Re(amplitude exp(i nu t)) + rest.

    Attributes:
        stage: The stage.
        amplitude: Complex amplitudes, shape (J,).
    """

    stage: LinearStage
    amplitude: Complex

    def state(self, time: float) -> tuple[Array, Array]:
        """Coordinates and velocities at a time from the start, each of shape (J,)."""
        stage, wave = self.stage, self.amplitude * np.exp(1j * time * self.stage.nu)
        return stage.V @ wave.real + stage.rest, -(stage.V @ (stage.nu * wave.imag))

    @property
    def contact(self) -> bool:
        """Whether any point is in contact."""
        return self.stage.contact

    def carried(self, transition: Array, time: float) -> Array:
        """Derivatives of the state, shape (2 J, c), after some more time in this stage."""
        return self.stage.carried(transition, time)

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times from the start, each of shape (len(times), J)."""
        stage = self.stage
        wave = self.amplitude * np.exp(1j * np.outer(times, stage.nu))
        return wave.real @ stage.V.T + stage.rest, -(stage.nu * wave.imag) @ stage.V.T

    def speed_integral(self, time: float) -> float:
        """Integral of |q'|^2 from the start to a time, in J s.

        With z = amplitude exp(i nu t) it is that of sum_j nu_j^2 Im(z_j)^2, as V is orthonormal,
        and 2 Im(z)^2 = |z|^2 - Re(z^2).
        """
        nu, squares = self.stage.nu, self.amplitude**2
        turned = squares * np.expm1(2j * time * nu)
        return float(nu @ (nu * np.abs(squares) * time / 2 - turned.imag / 4))

    def end(self, start: float, longest: float) -> float:
        """First time after `start` at which a margin is negative, or `longest`.

        No event is missed: the second derivative of a margin is at most the sum b of its
        amplitudes times nu^2, so a margin m of rate m' stays above m + m' s - b s^2 / 2. Each step
        leads to where the first of these parabolas ends, s = m' / b + sqrt((m' / b)^2 + 2 m / b);
        near an event they are Newton's, taken from the safe side.
        """
        stage, points = self.stage, len(self.stage.size)
        bounds = stage.bounds @ np.abs(self.amplitude)
        size = bounds[:points] + np.abs(stage.margin_rest)
        tolerance = _ROUND_OFF * np.maximum(np.maximum(size, stage.size), _TINY)
        per_bend = 1 / np.maximum(bounds[points:], _STILL)
        scale = np.concatenate([2 * per_bend, per_bend])
        level, frequency = (stage.margin_rest + tolerance) * scale[:points], 1j * stage.nu
        time = start
        while time < longest:
            wave = self.amplitude * np.exp(time * frequency)
            scaled = (stage.by_wave @ wave.view(np.float64)) * scale
            left, rates = scaled[:points] + level, scaled[points:]
            if time == start and left.min() <= 0:
                return start
            steps = np.sqrt(np.maximum(rates * rates + left, 0.0)) + rates
            step = float(steps[steps.argmin()])
            if step <= _ARRIVED * time:
                return time
            time += step
        return longest
