"""Motions in time by other means than the program's: DOP853 and principal pivoting."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.reduction.model import ReducedModel

#: Violations below this, relative to the gap, are round-off.
_ROUND_OFF = 1e-12


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
            force = self._solver() @ excess
            wrong = np.where(self._active, force, self._R @ force - excess) < -_ROUND_OFF
            if not wrong.any():
                return np.maximum(force, 0.0)
            self._active[np.argmax(wrong)] ^= True

    def _solver(self) -> Array:
        """R_AA^-1 at the rows and columns of the active points, else 0."""
        key = self._active.tobytes()
        if key not in self._solvers:
            solver, chosen = np.zeros_like(self._R), np.flatnonzero(self._active)
            solver[np.ix_(chosen, chosen)] = np.linalg.inv(self._R[np.ix_(chosen, chosen)])
            self._solvers[key] = solver
        return self._solvers[key]


def after_a_period(
    model: ReducedModel, point: BranchPoint, harmonics: int, *, most_steps: int = 20_000
) -> Return:
    """Integrate q'' = -omega^2 q - Phi^T lambda(q) over a period, without dimensions.

    Raises:
        TooLong: if that takes more than `most_steps` steps.
    """
    period, length = 1 / point.frequency, model.gap.min()
    amplitude = np.sqrt(2 * point.energy) / (2 * np.pi * point.frequency)
    force_unit = (amplitude / period) ** 2 / length
    omega, Phi = model.omega * period, model.Phi * amplitude / length
    law, gap = Pivoting(model.R * force_unit / length), model.gap / length

    def rate(time: float, state: Array) -> Array:
        q, velocity = np.split(state, 2)
        return np.concatenate([velocity, -(omega**2) * q - law(Phi @ q - gap) @ Phi])

    start = _state(point.q / amplitude, harmonics)
    steps = DOP853(rate, 0.0, start, 1.0, rtol=1e-9, atol=1e-11)
    for _ in range(most_steps):
        steps.step()
        if steps.status != "running":
            break
    else:
        raise TooLong
    assert steps.status == "finished", steps.status
    weight = np.concatenate([omega, np.ones_like(omega)])
    missed, drift = weight * (steps.y - start), weight * rate(0.0, start)
    return Return(
        error=float(np.linalg.norm(missed)) / (2 * np.pi),
        late=-float(missed @ drift / (drift @ drift)),
    )


def _state(q: Array, harmonics: int) -> Array:
    """Coordinates and velocities at the start: of cosines, then sines, in periods."""
    order = np.arange(1, harmonics + 1)
    sines = q[harmonics + 1 :]
    velocity = 2 * np.pi * order[: len(sines)] @ sines if len(sines) else np.zeros(q.shape[1])
    return np.concatenate([q[: harmonics + 1].sum(axis=0), velocity])
