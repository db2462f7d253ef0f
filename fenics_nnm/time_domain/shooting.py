"""Shooting: periodic motions of a reduced model to round-off, without a truncated series.

Newton's iteration on the exact flow of `time_domain.flow`, from a point of harmonic balance. One
motion of the family is picked by its total energy E, which, unlike gamma, is a property of a state:
it needs no mean over the period and its derivative is known at once. With
y = (omega q, q') / sqrt(2 E) the state in the energy norm, phi_T the flow over the period T, y0 the
state of the guess and f its rate there, the equations are

    phi_T(y) - y = 0,      f . (y - y0) = 0,      H(y) / E - 1 = 0                      (general)
    q'(T / 2) = 0 from q' (0) = 0,      H(q) / E - 1 = 0                                (reversible)

Energy is conserved, so one of the general equations follows from the others and is left out. A
time-reversible motion is even about both instants of rest, so half a period and half the unknowns
are enough. Where there is no motion of this energy near the guess, `time_domain.family` goes by the
nearest of another energy.

M. Peeters, R. Viguie, G. Serandour, G. Kerschen, J.-C. Golinval, Mech. Syst. Signal Process. 23
(2009) 195-216, shoot for nonlinear modes of smooth structures.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.time_domain.family import Found, Steps, motion_of_energy, periodic_motion
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.period_map import PeriodMap, Target, period_map


@dataclass(frozen=True, slots=True)
class Shooting:
    """Configuration.

    Attributes:
        steps: Bounds on the iteration.
        keep_energy: Look for the motion of the energy of the guess; else for the nearest one.
        farthest_period: A motion with a larger |T / T0 - 1| is not that of the guess.
    """

    steps: Steps = field(default_factory=Steps)
    keep_energy: bool = True
    farthest_period: float = 0.05


@dataclass(frozen=True, slots=True)
class OrbitGuess:
    """A guess at a periodic motion: a state that nearly comes back after a period.

    Attributes:
        q: Modal coordinates at the start in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        period: Period in s.
        energy: Total energy in J, which the motion is to have.
        touches: Whether the motion comes into contact.
        reversible: Whether the motion is time-reversible and starts at rest: it is shot as one.
    """

    q: Array
    velocity: Array
    period: float
    energy: float
    touches: bool
    reversible: bool

    @classmethod
    def of(cls, series: Series, motion: Motion) -> OrbitGuess:
        """The guess that a motion of harmonic balance makes.

        Args:
            series: Series that the motion is written in; without sines it is time-reversible.
            motion: Motion.
        """
        phase = np.zeros(1)
        rate = 2 * np.pi * motion.frequency * series.rate_at(phase)[0]
        return cls(
            q=series.basis_at(phase)[0] @ motion.q,
            velocity=rate @ motion.q,
            period=1 / motion.frequency,
            energy=motion.energy,
            touches=motion.contact_fraction > 0,
            reversible=not series.free_phase,
        )


@dataclass(frozen=True, slots=True)
class ShotMotion:
    """What shooting ended with.

    Attributes:
        q: Modal coordinates at the start in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        period: Period in s.
        energy: Total energy of the state in J.
        energy_change: Energy over that of the guess, less 1.
        return_error: Distance of the state after a period from its start, relative in the energy
            norm.
        distance: Distance of the state from that of the guess, relative in the energy norm.
        frequency_change: Frequency over that of the guess, less 1.
        iterations: Newton steps taken.
        changes: Changes of contact in a period.
        contact_fraction: Share of the period with contact somewhere.
        failure: Empty where the motion is periodic and that of the guess, else why not.
    """

    q: Array
    velocity: Array
    period: float
    energy: float
    energy_change: float
    return_error: float
    distance: float
    frequency_change: float
    iterations: int
    changes: int
    contact_fraction: float
    failure: str = ""

    @property
    def converged(self) -> bool:
        """Whether the motion is periodic, and the one that was looked for."""
        return not self.failure

    @property
    def frequency(self) -> float:
        """Frequency in Hz."""
        return 1 / self.period


def shoot(flow: Integrator, guess: OrbitGuess, *, options: Shooting | None = None) -> ShotMotion:
    """The periodic motion of the same energy near a guess; never raises for non-convergence.

    The equations are solved to the error that the integrator makes, not below it.

    Args:
        flow: Integrator of the model that the guess belongs to, in SI units.
        guess: Guess.
        options: Configuration of the iteration.
    """
    options = options or Shooting()
    steps = replace(options.steps, tolerance=max(options.steps.tolerance, flow.error))
    target = Target(guess.q, guess.velocity, guess.period, guess.energy)
    equations = period_map(flow, target, reversible=guess.reversible)
    if options.keep_energy:
        found = motion_of_energy(equations, steps)
    else:
        found = periodic_motion(equations, equations.start, steps, keep_energy=False)
    return _motion(flow, equations, found, options, touches=guess.touches)


def mean_gamma(flow: Integrator, shot: ShotMotion, *, periods: float = 1.0) -> float:
    """Modal energy coordinate gamma = m^ / 2 of a shot motion, with all its harmonics.

    m^ = <q' . q'> / omega^2 is a mean over the period (Parseval), in closed form, or over half of
    it where the motion is time-reversible and starts at rest.
    """
    return mean_gamma_of(flow, shot.q, shot.velocity, shot.period, periods=periods)


def mean_gamma_of(
    flow: Integrator, q: Array, velocity: Array, period: float, *, periods: float = 1.0
) -> float:
    """`mean_gamma` of a motion given by its initial state and its period."""
    omega, span = 2 * np.pi / period, periods * period
    return flow.run(q, velocity, span, speeds=True).speed_integral / (2 * span * omega**2)


def harmonics_of(flow: Integrator, shot: ShotMotion, series: Series) -> Array:
    """Coefficients of a shot motion in a series, shape (c, J), from the samples of the series."""
    times = shot.period * series.phase / (2 * np.pi)
    return series.analysis @ flow.run(shot.q, shot.velocity, shot.period, times=times).q_at


def _motion(
    flow: Integrator, equations: PeriodMap, found: Found, options: Shooting, *, touches: bool
) -> ShotMotion:
    """The result, with the return error of one whole period."""
    q, velocity, period = equations.state(found.unknowns)
    target = equations.target
    whole = flow.run(q, velocity, period)
    omega, energy = flow.model.omega, flow.energy(q, velocity)

    def distance(dq: Array, dv: Array) -> float:
        return float(np.linalg.norm(np.hypot(omega * dq, dv)) / target.amplitude)

    shot = ShotMotion(
        q=q,
        velocity=velocity,
        period=period,
        energy=energy,
        energy_change=energy / target.energy - 1,
        return_error=distance(whole.q - q, whole.velocity - velocity),
        distance=distance(q - target.q, velocity - target.velocity),
        frequency_change=target.period / period - 1,
        iterations=found.iterations,
        changes=whole.changes,
        contact_fraction=whole.contact_time / period,
        failure=found.failure or whole.failure,
    )
    return shot if shot.failure else replace(shot, failure=_refusal(shot, options, touches))


def _refusal(shot: ShotMotion, options: Shooting, touches: bool) -> str:
    """Why a periodic motion is not the one of the guess, or nothing."""
    if shot.return_error > options.steps.accepted:
        return f"after a whole period the state misses its start by {shot.return_error:.1e}"
    if touches and not shot.contact_fraction:
        return "another motion: it does not touch the obstacle, and the guess does"
    if shot.distance > options.steps.farthest:
        return (
            f"another motion: its state is {shot.distance:.2g} of the amplitude away from the guess"
        )
    if abs(shot.frequency_change) > options.farthest_period:
        return f"another motion: its frequency is {shot.frequency_change:+.1%} off the guess"
    return ""
