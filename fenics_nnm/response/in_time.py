"""What integration in time says of a driven motion that harmonic balance found.

The motion is followed from its state at phase 0 for a period, and the exact motion near it is shot
at the same frequency, unless it misses its start by more than 10 %. Where there is none, as just
beyond a fold, the nearest one of the branch is taken, whose frequency differs a little.

* verified: the motion comes back within 5 %, and the exact one has its frequency within 1e-3 and
  its coefficients within 1 % of their size;
* failed: it does not come back by more than a third, or is not followed to the end;
* converged: all else.

Stability follows from the Floquet multipliers of the exact motion, with the user's damping.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import CONVERGED, FAILED, VERIFIED
from fenics_nnm.backbone.verdict import VERIFIED_CHANGE, VERIFIED_RETURN_ERROR
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.time_domain.driven_flow import DrivenFlow
from fenics_nnm.time_domain.driven_motion import DrivenOrbit, DrivenSteps, driven_orbit

#: A motion that misses its start by more than this part of its size is no motion.
_LARGEST_RETURN_ERROR = 1 / 3

#: An exact motion near one that misses its start by more is not looked for.
_LARGEST_SHOT = 0.1

#: Verified: what the coefficients of the exact motion may differ by, relative.
_VERIFIED_DISTANCE = 0.01

#: Steps to the exact motion: it is near, or not worth a long search.
_STEPS = DrivenSteps(iterations=15, shortest_fraction=2.0**-3)

#: An exact motion that is farther from the point is another motion.
_ANOTHER = 0.3


@dataclass(frozen=True, slots=True)
class InTime:
    """What is known of a driven motion from integration in time.

    Attributes:
        status: Whether it is verified, converged or failed.
        reason: Why it is not verified, or nothing.
        return_error: By how much it misses its start after a period, relative in the energy norm;
            nan if it was not followed.
        orbit: The exact motion near it; None if none was found.
        distance: Difference of its coefficients from those of the exact motion, relative in the
            energy norm; nan without.
    """

    status: str
    reason: str
    return_error: float
    orbit: DrivenOrbit | None = None
    distance: float = float("nan")

    @property
    def largest_multiplier(self) -> float:
        """Largest modulus of the Floquet multipliers; nan if unknown."""
        return self.orbit.largest_multiplier if self.orbit else float("nan")

    @property
    def stability(self) -> str:
        """Stable, or the kind of instability; nothing if unknown."""
        if self.orbit is None:
            return ""
        return self.orbit.instability or "stable"


def in_time(flow: DrivenFlow, series: Series, q: Array, omega: float) -> InTime:
    """Follow a motion of harmonic balance in time, and judge it.

    Args:
        flow: Flow of the driven model, at any frequency: its stages are kept for further motions.
        series: General series that the motion is written in.
        q: Coefficients, shape (c, J).
        omega: Circular frequency in rad/s.
    """
    driven, start = flow.at(omega), state_at(series, q, omega, 0.0)
    after = driven.run(*start, 2 * np.pi / omega)
    if after.failure:
        return InTime(FAILED, f"integration in time gave up: {after.failure}", float("nan"))
    missed = _distance(flow, (after.q - start[0], after.velocity - start[1]), start)
    if missed > _LARGEST_RETURN_ERROR:
        return InTime(FAILED, _missing(missed), missed)
    if missed > _LARGEST_SHOT:
        return InTime(CONVERGED, _missing(missed), missed)
    orbit, distance = _exact(driven, series, q, start)
    if orbit is None:
        doubt = "no exact motion was found near it"
        if missed > VERIFIED_RETURN_ERROR:
            doubt = f"{_missing(missed)}, and {doubt}"
        return InTime(CONVERGED, doubt, missed)
    doubt = _doubt(missed, orbit.omega / omega - 1, distance)
    status = CONVERGED if doubt else VERIFIED
    return InTime(status, doubt, missed, orbit, distance)


def state_at(series: Series, q: Array, omega: float, phase: float) -> tuple[Array, Array]:
    """Coordinates and velocities of a motion at a phase, each of shape (J,)."""
    at = np.array([phase])
    return series.basis_at(at)[0] @ q, omega * series.rate_at(at)[0] @ q


def coefficients_of(flow: DrivenFlow, orbit: DrivenOrbit, series: Series) -> Array:
    """Coefficients of an exact motion in a series, shape (c, J)."""
    times, period = series.phase / orbit.omega, 2 * np.pi / orbit.omega
    found = flow.at(orbit.omega).run(orbit.q, orbit.velocity, period, times=times)
    return np.asarray(series.analysis @ found.q_at)


def _exact(
    driven: DrivenFlow, series: Series, q: Array, start: tuple[Array, Array]
) -> tuple[DrivenOrbit | None, float]:
    """The exact motion near a point and its distance, at its frequency or else nearby."""
    for keep_frequency in (True, False):
        orbit = driven_orbit(driven, *start, keep_frequency=keep_frequency, steps=_STEPS)
        if not orbit.failure:
            size = driven.model.omega * q
            exact = driven.model.omega * coefficients_of(driven, orbit, series)
            distance = float(np.linalg.norm(exact - size) / np.linalg.norm(exact))
            if distance < _ANOTHER:
                return orbit, distance
    return None, float("nan")


def _distance(flow: DrivenFlow, change: tuple[Array, Array], start: tuple[Array, Array]) -> float:
    """Size of a change of state relative to a state, in the energy norm."""
    omega = flow.model.omega
    sizes = [float(np.linalg.norm([omega * q, velocity])) for q, velocity in (change, start)]
    return sizes[0] / sizes[1] if sizes[1] else float("inf")


def _missing(missed: float) -> str:
    return f"after one period the motion misses its start by {missed:.1%}"


def _doubt(missed: float, change: float, distance: float) -> str:
    """Why the exact motion does not confirm the point, or nothing."""
    if missed > VERIFIED_RETURN_ERROR:
        return _missing(missed)
    if abs(change) > VERIFIED_CHANGE:
        return f"the exact motion near it is {change:+.2%} away in frequency"
    if distance > _VERIFIED_DISTANCE:
        return f"the exact motion differs by {distance:.1%} of its size"
    return ""
