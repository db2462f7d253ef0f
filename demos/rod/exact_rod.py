"""Exact nonlinear modes of the rod: one contact of finite duration a period.

The rod of unit length, wave speed, E A and gap moves as

    u(x, t) = F(t + x) - F(t - x),     F' = -a on a length d, +a on a length T - d,

a square wave that runs along the rod, with T the period. Clamped at x = 0; at the tip u' =
F'(t + 1) - F'(t - 1), and the force is -(F'(t + 1) + F'(t - 1)). Their arguments differ by 2, that
is by d = 2 - (k - 1) T after whole periods. So the force is 0, or 2 a while both are in the low
part, for 4 - (2 k - 1) T; the tip rests then, and at the gap if a = 1 / (2 k^2 T - 4 k - 2).
This is mode k for T from (2 k + 1) / k^2, where a is infinite, to 4 / (2 k - 1), the period of the
linear mode. k = 1: T in (3, 4), a = 1 / (2 (T - 3)), the energy is 2 a^2. All of it in units of the
linear rod, so ratios hold for any rod and gap.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: gamma of the linear mode that grazes: m^ / 2 with u = sin(pi x / 2) cos(omega t).
GRAZING_GAMMA = 1 / 8


def gamma(period: float, mode: int = 1, intervals: int = 2000) -> float:
    """Modal energy coordinate <v^2> / (2 omega^2), integrated over the rod.

    The mean of v^2 at x is 2 a^2 - 2 R(2 x) with R the autocorrelation of F'.
    """
    a = 1 / (2 * mode**2 * period - 4 * mode - 2)
    low = 2 - (mode - 1) * period
    x = np.linspace(0, 1, intervals + 1)
    mean_square = 2 * a**2 - 2 * _autocorrelation(2 * x, period, low, a)
    omega = 2 * np.pi / period
    return float(np.trapezoid(mean_square, x) / 2 / omega**2)


def _autocorrelation(shift: Array, period: float, low: float, a: float) -> Array:
    shift = np.mod(shift, period)
    both_low = np.maximum(0, low - shift) + np.maximum(0, low - (period - shift))
    one_low = 2 * (low - both_low)
    both_high = period - both_low - one_low
    return a**2 * (both_low - one_low + both_high) / period


def frequency_ratio(gamma_ratio: Array | float, mode: int = 1) -> Array:
    """omega / omega_k of the exact mode k at given gamma over gamma at grazing."""
    linear, shortest = 4 / (2 * mode - 1), (2 * mode + 1) / mode**2
    periods = shortest + (linear - shortest) * np.linspace(0.02, 0.9999, 4000)
    ratios = np.array([gamma(period, mode) for period in periods]) / GRAZING_GAMMA
    return np.interp(gamma_ratio, ratios[::-1], linear / periods[::-1])


def energy(ratio: Array, mode: int = 1) -> Array:
    """Energy 2 a^2 of the exact mode k at given omega / omega_k, in units of E A g^2 / L.

    It is the integral of F'(t + x)^2 + F'(t - x)^2 over the rod.
    """
    period = 4 / ((2 * mode - 1) * ratio)
    return 2 * (1 / (2 * mode**2 * period - 4 * mode - 2)) ** 2


def period_at(gamma_ratio: float) -> float:
    """Period T of the exact mode at given gamma over gamma at grazing."""
    return 4 / float(frequency_ratio(gamma_ratio))


def motion(period: float, time: Array, place: Array) -> tuple[Array, Array]:
    """Displacement and velocity at times over the period (0: middle of the contact) and places.

    In units of the gap, and of the gap times wave speed over length; shape (times, places).
    """
    a = 1 / (2 * (period - 3))
    t = (time * period + period / 2 + 1)[:, None]
    ahead, behind = t + place, t - place
    displacement = _wave(ahead, period, a) - _wave(behind, period, a)
    return displacement, _slope(ahead, period, a) - _slope(behind, period, a)


def _wave(s: Array, period: float, a: float) -> Array:
    """F, the integral of the square wave."""
    whole, rest = np.divmod(s, period)
    return whole * a * (period - 4) + np.interp(rest, [0, 2, period], [0, -2 * a, a * (period - 4)])


def _slope(s: Array, period: float, a: float) -> Array:
    """F', the square wave."""
    return np.where(np.mod(s, period) < 2, -a, a)


def pressed_period(energy: Array | float) -> Array:
    """Period of the first mode of a rod that is pressed against its obstacle.

    The tip of the free rod would reach 1 past the obstacle. At rest the rod is compressed, u = -x,
    with the force 1 and the energy 1/2. The square wave above with k = 1 is a motion for T in
    (2, 3), too: the tip lifts off for 2 T - 4 and rests for 4 - T with the force 2 a; now
    a = 1 / (2 (3 - T)), so that it rests 1 before its free place. As T goes to 2, the period of the
    rod clamped at both ends, the motion dies away; as T goes to 3, that without a gap, a grows.

    Args:
        energy: 2 a^2 - 1/2, from the state of rest.
    """
    return 3 - 1 / np.sqrt(2 * np.asarray(energy) + 1)


def pressed_motion(period: float, time: Array, place: Array) -> Array:
    """Displacement of the pressed rod, as `motion` has it for the rod with a gap.

    It is counted from where the rod is without stress; the obstacle is at -1.
    """
    a = 1 / (2 * (3 - period))
    t = (time * period + period / 2 + 1)[:, None]
    return _wave(t + place, period, a) - _wave(t - place, period, a)
