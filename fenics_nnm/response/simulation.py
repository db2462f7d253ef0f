"""Motions of a driven structure in time: what it does from a state, at one frequency or in a sweep.

The frequency is constant within each period of the force and changes between periods, so that the
force is continuous. Each period is followed exactly; of it are kept the extremes of the places that
are watched, and their state at its start (Poincare points).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.response.watched import Watched
from fenics_nnm.time_domain.driven_flow import DrivenFlow
from fenics_nnm.time_domain.driven_motion import DrivenOrbit, driven_orbit
from fenics_nnm.time_domain.integrator import Trajectory

_TINY = np.finfo(float).tiny

#: Instants of a period at which extremes are looked for: a cosine's is found to 5e-5.
_INSTANTS = 256

#: Periods of the force after which a motion may repeat itself and count as periodic.
_LONGEST_REPEAT = 8

#: A motion that moves less than this, relative in the energy norm, from its exact periodic motion
#: has settled.
_SETTLED = 0.02

#: A state that comes back to less than this part of itself may be near a periodic motion.
_NEAR = 0.1


@dataclass(frozen=True, slots=True)
class Period:
    """What a structure did in one period of the force.

    Attributes:
        frequency: Frequency in Hz.
        time: Time at its start in s.
        largest: Largest displacements of the places in m, shape (w,).
        least: Least ones.
        section: Displacements at its start in m, shape (w,).
        section_speed: Speeds there in m/s, shape (w,).
        contact_fraction: Share of it with contact somewhere.
        energy: Total energy at its start in J.
    """

    frequency: float
    time: float
    largest: Array
    least: Array
    section: Array
    section_speed: Array
    contact_fraction: float
    energy: float

    @property
    def amplitude(self) -> Array:
        """Half the distance of the extremes in m, shape (w,)."""
        return np.asarray((self.largest - self.least) / 2)


@dataclass(frozen=True, slots=True)
class Simulation:
    """What a structure did.

    Attributes:
        periods: Periods in order.
        q: Modal coordinates at the end in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        failure: Empty, or why it was given up.
    """

    periods: tuple[Period, ...]
    q: Array
    velocity: Array
    failure: str = ""

    def of(self, name: str) -> Array:
        """A quantity of all periods by its name, shape (P,) or (P, w)."""
        return np.array([getattr(period, name) for period in self.periods])


@dataclass(frozen=True, slots=True)
class Settled:
    """Where a motion at constant frequency has come to.

    Attributes:
        periods: Periods of the force after which it repeats itself; 0 if it does not.
        orbit: The exact periodic motion; None without. Its frequency is that of the force over
            the number of periods.
        distance: How far the state is from it, relative in the energy norm.
    """

    periods: int
    orbit: DrivenOrbit | None
    distance: float

    def __str__(self) -> str:
        if self.orbit is None:
            return f"has not settled on a motion of up to {_LONGEST_REPEAT} periods of the force"
        repeats = "a period" if self.periods == 1 else f"{self.periods} periods"
        return (
            f"has settled on a stable motion that repeats after {repeats} of the force "
            f"(largest multiplier {self.orbit.largest_multiplier:.4f})"
        )


def simulation(
    flow: DrivenFlow,
    watched: Watched,
    frequencies: Array,
    start: tuple[Array, Array],
    *,
    on_progress: Callable[[float], None] = lambda part: None,
) -> Simulation:
    """Follow a structure for a period of each of some frequencies.

    Args:
        flow: Flow of the driven structure, at any frequency.
        watched: What is watched.
        frequencies: Frequency of each period in Hz, shape (P,).
        start: Coordinates and velocities at the start, each of shape (J,).
        on_progress: Called with the part of the periods that is done.
    """
    (q, velocity), clock = start, 0.0
    periods: list[Period] = []
    for number, frequency in enumerate(map(float, frequencies), start=1):
        times = np.arange(_INSTANTS + 1) / _INSTANTS / frequency
        driven = flow.at(2 * np.pi * frequency)
        whole = driven.run(q, velocity, times[-1], times=times)
        if whole.failure:
            failure = f"given up in period {number}: {whole.failure}"
            return Simulation(tuple(periods), q, velocity, failure)
        periods.append(_period(driven, watched, whole, clock))
        q, velocity, clock = whole.q, whole.velocity, clock + times[-1]
        on_progress(number / len(frequencies))
    return Simulation(tuple(periods), q, velocity)


def _period(flow: DrivenFlow, watched: Watched, whole: Trajectory, clock: float) -> Period:
    """What is kept of the motion in a period."""
    phases = 2 * np.pi * np.arange(_INSTANTS + 1) / _INSTANTS
    moved, speed = moved_places(flow, watched, (whole.q_at, whole.velocity_at), phases)
    frequency = flow.drive.omega / (2 * np.pi)
    return Period(
        frequency=frequency,
        time=clock,
        largest=moved.max(axis=0),
        least=moved.min(axis=0),
        section=moved[0],
        section_speed=speed[0],
        contact_fraction=whole.contact_time * frequency,
        energy=flow.energy(whole.q_at[0], whole.velocity_at[0]),
    )


def moved_places(
    flow: DrivenFlow, watched: Watched, states: tuple[Array, Array], phases: Array
) -> tuple[Array, Array]:
    """Displacements and speeds of places, each of shape (s, w).

    Args:
        flow: Flow.
        watched: What is watched.
        states: Coordinates and velocities, each of shape (s, J).
        phases: Phases of the force at these states, shape (s,).
    """
    model, drive, at = flow.model, flow.drive, watched.before_contact
    moved, speed = watched.at_states(*states)
    forces = Complementarity(model.R, model.gap)(moved[:, at:] - drive.gap.at(phases))
    rates = forces.change(speed[:, at:] - drive.omega * drive.gap.rate(phases))
    return moved - forces.force @ watched.residual.T, speed - rates @ watched.residual.T


def settled(flow: DrivenFlow, q: Array, velocity: Array, frequency: float) -> Settled:
    """The stable periodic motion that a state at phase 0 of the force is on, if it is on one.

    Args:
        flow: Flow of the driven structure, at any frequency.
        q: Modal coordinates, shape (J,).
        velocity: Their velocities, shape (J,).
        frequency: Frequency of the force in Hz.
    """
    omega, start = 2 * np.pi * frequency, np.concatenate([q, velocity])
    scale = np.concatenate([flow.model.omega, np.ones_like(q)])
    for periods in _near_repeats(flow.at(omega), scale, (q, velocity)):
        slower = flow.at(omega).drive.slower(periods)
        orbit = driven_orbit(flow.driven_by(slower), q, velocity)
        exact = np.concatenate([orbit.q, orbit.velocity])
        distance = _apart(scale, start, exact)
        if orbit.stable and distance < _SETTLED:
            return Settled(periods, orbit, distance)
    return Settled(0, None, float("nan"))


def _near_repeats(flow: DrivenFlow, scale: Array, start: tuple[Array, Array]) -> list[int]:
    """Numbers of periods after which a state nearly comes back."""
    (q, velocity), near = start, []
    for periods in range(1, _LONGEST_REPEAT + 1):
        after = flow.run(q, velocity, 2 * np.pi / flow.drive.omega)
        q, velocity = after.q, after.velocity
        if _apart(scale, np.concatenate([q, velocity]), np.concatenate(start)) < _NEAR:
            near.append(periods)
    return near


def _apart(scale: Array, state: Array, other: Array) -> float:
    """Distance of two states relative to the second, in the energy norm."""
    size = float(np.linalg.norm(scale * other))
    return float(np.linalg.norm(scale * (state - other))) / max(size, _TINY)
