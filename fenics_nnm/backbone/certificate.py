"""What shooting finds near a point of a branch: the true motion, and its stability."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import BranchPoint, FloquetStability, Orbit, Return
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.time_domain.bifurcations import Witness
from fenics_nnm.time_domain.family import Steps
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.shooting import OrbitGuess, Shooting, ShotMotion, shoot
from fenics_nnm.time_domain.stability import STABLE, Stability, stability

#: No walk along a family: a point that is not near a true motion of its energy stays without one.
_DIRECT = Shooting(steps=Steps(walk=0))

#: A point that comes back within this after a period is near one: there a short walk is worth it.
_NEAR = 0.05
_SHORT_WALK = Shooting(steps=Steps(walk=20))


@dataclass(frozen=True, slots=True)
class Certificate:
    """What shooting found near a point.

    Attributes:
        orbit: The exact motion of its energy, if one was found.
        stability: Stability of that, if it is known.
        witness: The same motion with its multipliers, to find bifurcations with.
        failure: Why no exact motion was found; empty if one was, or none was looked for.
    """

    orbit: Orbit | None = None
    stability: FloquetStability | None = None
    witness: Witness | None = None
    failure: str = ""


#: Where no exact motion was looked for.
NO_CERTIFICATE = Certificate()


def certified(
    flow: Integrator, series: Series, point: BranchPoint, returned: Return
) -> Certificate:
    """The shot motion of the energy of a point, and its stability.

    Args:
        flow: Integrator of the model that the point belongs to, in SI units.
        series: Series that the point is written in.
        point: Point.
        returned: How it comes back in time.
    """
    shot = shot_motion(flow, series, point, returned)
    if not shot.converged:
        return Certificate(failure=f"no exact motion of its energy nearby: {shot.failure}")
    found = stability(flow, shot, reversible=not series.free_phase)
    orbit = Orbit(shot.frequency, shot.distance, shot.return_error)
    if found.failure:
        return Certificate(orbit)
    return Certificate(orbit, _summary(found), Witness(point.gamma_ratio, shot, found))


def shot_motion(
    flow: Integrator, series: Series, point: BranchPoint, returned: Return
) -> ShotMotion:
    """The motion of the energy of a point, by Newton's iteration, or also by a short walk."""
    guess = OrbitGuess.of(series, point.motion)
    near = returned.after_one <= _NEAR
    return shoot(flow, guess, options=_SHORT_WALK if near else _DIRECT)


def of_linear_mode(frequency: float, others: Array) -> tuple[Orbit, FloquetStability]:
    """The exact motion of a point without contact, which is the linear mode itself, and stable.

    Args:
        frequency: Frequency of the point in Hz.
        others: Circular frequencies in rad/s of the other linear modes, shape (J - 1,): over the
            period T their phases turn by omega_j T, so exp(+-i omega_j T) are the multipliers.
    """
    turns = np.exp(1j * others / frequency)
    multipliers = np.concatenate([turns, turns.conj()])
    return Orbit(frequency, 0.0, 0.0), FloquetStability(STABLE, 1.0, multipliers)


def _summary(found: Stability) -> FloquetStability:
    return FloquetStability(found.kind or STABLE, found.largest, found.multipliers)
