"""Motion between two changes of contact: linear, so known in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from fenics_nnm.arrays import Array
from fenics_nnm.reduction.closed import ClosedPoints
from fenics_nnm.reduction.model import ReducedModel

#: A margin is negative below this part of the size of what it is the difference of.
_ROUND_OFF = 1e-13

#: Length of the first intervals of the search, times the frequency of the margins.
_FIRST_STEP = 0.25

#: Intervals that an interval of time is searched in, and parts of one that may hold an event.
_INTERVALS = 64
_PARTS = 32


@dataclass(frozen=True, slots=True)
class LinearStage:
    r"""Equations of motion while the points in contact stay the same, in their own modes.

    With A the points in contact and K_A = diag(omega^2) + Phi_A^T R_AA^-1 Phi_A = V diag(nu^2) V^T,

        q'' = -K_A (q - rest),      rest = K_A^-1 Phi_A^T R_AA^-1 gap_A.

    The stage lasts while all margins are positive, see `reduction.closed`.

    Attributes:
        nu: Circular frequencies in rad/s, shape (J,).
        V: Orthonormal modes as columns, shape (J, J).
        rest: Position of rest, kg^1/2 m, shape (J,).
        margin_shape: Margins per modal coordinate of the stage, shape (n_c, J).
        margin_rest: Margins in m at rest, shape (n_c,).
        size: Smallest size in m that the margins are measured by, shape (n_c,).
        contact: Whether any point is in contact.
    """

    nu: Array
    V: Array
    rest: Array
    margin_shape: Array
    margin_rest: Array
    size: Array
    contact: bool

    @classmethod
    def of(cls, model: ReducedModel, active: NDArray[np.bool_]) -> LinearStage:
        """The stage with the given points in contact, shape (n_c,)."""
        if not active.any():
            return cls(
                nu=model.omega,
                V=np.eye(model.modes),
                rest=np.zeros(model.modes),
                margin_shape=-model.Phi,
                margin_rest=model.gap,
                size=np.abs(model.gap),
                contact=False,
            )
        held = ClosedPoints.of(model, active)
        squares, V = eigh(held.stiffness)
        rest = V @ ((V.T @ held.pull) / squares)
        return cls(
            nu=np.sqrt(squares),
            V=V,
            rest=rest,
            margin_shape=held.gradient @ V,
            margin_rest=held.gradient @ rest + held.offset,
            size=np.abs(model.gap),
            contact=True,
        )

    def motion(self, q: Array, velocity: Array) -> StageMotion:
        """The motion from a state."""
        return StageMotion(self, self.V.T @ (q - self.rest), (self.V.T @ velocity) / self.nu)

    def carried(self, transition: Array, time: float) -> Array:
        """State-transition matrix, shape (2 J, 2 J), after some more time in this stage."""
        cosine, sine = np.cos(self.nu * time)[:, None], np.sin(self.nu * time)[:, None]
        nu, half = self.nu[:, None], len(self.nu)
        by_q, by_velocity = self.V.T @ transition[:half], self.V.T @ transition[half:]
        return np.vstack(
            [
                self.V @ (cosine * by_q + sine / nu * by_velocity),
                self.V @ (cosine * by_velocity - nu * sine * by_q),
            ]
        )


@dataclass(frozen=True, slots=True)
class StageMotion:
    """A motion of a stage: V (cos(nu t) cosine + sin(nu t) sine) + rest.

    Attributes:
        stage: The stage.
        cosine: Amplitudes of the cosines, shape (J,).
        sine: Amplitudes of the sines, shape (J,).
    """

    stage: LinearStage
    cosine: Array
    sine: Array

    def states(self, times: Array) -> tuple[Array, Array]:
        """Coordinates and velocities at times from the start, each of shape (len(times), J)."""
        stage, angle = self.stage, np.outer(times, self.stage.nu)
        cosine, sine = np.cos(angle), np.sin(angle)
        q = (cosine * self.cosine + sine * self.sine) @ stage.V.T + stage.rest
        return q, (stage.nu * (cosine * self.sine - sine * self.cosine)) @ stage.V.T

    def margins(self, times: Array) -> Array:
        """Margins in m, shape (len(times), n_c)."""
        angle = np.outer(times, self.stage.nu)
        wave = np.cos(angle) * self.cosine + np.sin(angle) * self.sine
        return wave @ self.stage.margin_shape.T + self.stage.margin_rest

    def end(self, start: float, longest: float) -> float:
        """First time after `start` at which a margin is negative, or `longest`.

        No event is missed: the second derivative of a margin is at most the sum of its
        amplitudes times nu^2, so an interval can be ruled out by its ends. What is left is
        divided until a dip in between is below round-off.
        """
        amplitude = np.abs(self.stage.margin_shape) * np.hypot(self.cosine, self.sine)
        size = np.maximum(amplitude.sum(axis=1) + np.abs(self.stage.margin_rest), self.stage.size)
        size = np.maximum(size, np.finfo(float).tiny)
        bend = amplitude @ self.stage.nu**2
        search = _Search(self, bend / 8, _ROUND_OFF * size)
        fastest = float(np.sqrt((bend / size).max()))
        window = _INTERVALS * _FIRST_STEP / fastest if fastest > 0 else longest
        while start < longest:
            end = min(start + window, longest)
            found = search.first(start, end, _INTERVALS)
            if found is not None:
                return found
            start = end
        return longest


@dataclass(frozen=True, slots=True)
class _Search:
    """Search for the first negative margin.

    Attributes:
        motion: The motion.
        dip: Largest dip below a chord, over the square of its length, shape (n_c,).
        tolerance: Margins above minus this are not negative, shape (n_c,).
    """

    motion: StageMotion
    dip: Array
    tolerance: Array

    def first(self, start: float, end: float, parts: int) -> float | None:
        """Time of the first event between two times, or None."""
        times = np.linspace(start, end, parts + 1)
        margins = self.motion.margins(times)
        dip = self.dip * ((end - start) / parts) ** 2
        lowest = np.minimum(margins[:-1], margins[1:]) - dip
        suspect = lowest < -self.tolerance
        for interval in np.flatnonzero(suspect.any(axis=1)):
            points = suspect[interval]
            left, right = float(times[interval]), float(times[interval + 1])
            if np.all(dip[points] <= self.tolerance[points] / 4) or right - left <= 1e-15 * right:
                ends = margins[interval : interval + 2, points]
                return left + (right - left) * _crossing(ends)
            found = self.first(left, right, _PARTS)
            if found is not None:
                return found
        return None


def _crossing(ends: Array) -> float:
    """Where the first of some straight lines from ends[0] to ends[1] crosses zero, 0 to 1."""
    before, after = np.maximum(ends[0], 0.0), ends[1]
    falls = after < 0
    if not falls.any():
        return 0.0
    return float((before[falls] / (before[falls] - after[falls])).min())
