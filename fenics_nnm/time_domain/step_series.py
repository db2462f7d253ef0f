r"""The motion of a step between times at which it is known, as a series in the time since then.

With tau = (t - t_i) / d, x = sum_m c_m tau^m, and the remainder sum_m n_m tau^m,

    (m + 1) (m + 2) c_{m+2} = d^2 n_m - (nu d)^2 c_m.

Times t_i are no more than a radian of the fastest oscillator apart, nu d <= 1, so that few terms
are the motion to round-off; they are linear in x(t_i), x'(t_i) and in values at the nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.exponential_rule import GaussNodes
from fenics_nnm.time_domain.kept import bytes_of

#: Terms of the series: 1 / 20! is round-off.
_TERMS = 20

#: Rates of powers of the time, by the powers below them.
_RATES = np.arange(1.0, _TERMS)


@dataclass(frozen=True, slots=True)
class StepSeries:
    """Series of a step.

    Attributes:
        times: Times t_i, ascending, shape (d,).
        width: Time d in s, no two times are farther apart.
        by_x: Coefficients by x(t_i), shape (J, m).
        by_rate: Coefficients by x'(t_i), shape (J, m).
        by_power: Coefficients by n_0, n_1 .., shape (J, m, s).
        powers: From values at the nodes to n_0, n_1 .. of each time, shape (d, s, s).
    """

    times: Array
    width: float
    by_x: Array
    by_rate: Array
    by_power: Array
    powers: Array

    @classmethod
    def of(
        cls, nodes: GaussNodes, nu: Array, step: float, times: Array, width: float
    ) -> StepSeries:
        """Those of a step of some length, with oscillators of nu d <= 1, shape (J,)."""
        known = _recurrence(nu, width, len(nodes.at))
        about = _legendre_powers(2 * times / step - 1, 2 * width / step, len(nodes.at))
        return cls(
            times=times,
            width=width,
            by_x=np.ascontiguousarray(known[:, :, 0]),
            by_rate=np.ascontiguousarray(known[:, :, 1]),
            by_power=np.ascontiguousarray(known[:, :, 2:]),
            powers=nodes.to_legendre.T @ about,
        )

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return bytes_of(self.by_x, self.by_rate, self.by_power, self.powers)

    def coefficients(self, number: int, x: Array, rate: Array, remainder: Array) -> Array:
        """C of the motion from the time of a number, shape (J, m).

        Args:
            number: Which of the times, i.
            x: Coordinates then, shape (J,).
            rate: Their velocities, shape (J,).
            remainder: Remainder at the nodes, shape (J, s).
        """
        found = (self.by_power @ (remainder @ self.powers[number])[:, :, None])[:, :, 0]
        found += self.by_x * x[:, None]
        found += self.by_rate * rate[:, None]
        return np.asarray(found)

    def waves(self, number: int, time: float) -> Array:
        """Powers of tau at a time after that of a number, and their rates, shape (m, 2)."""
        tau = (time - self.times[number]) / self.width
        found = np.zeros((2, _TERMS))
        found[0, 0], found[0, 1:] = 1.0, tau
        powers = np.multiply.accumulate(found[0], out=found[0])
        np.multiply(_RATES / self.width, powers[:-1], out=found[1, 1:])
        return found.T


class WatchedMotion:
    """The motion of a step at any time after the first at which it is known."""

    def __init__(self, series: StepSeries, watched: Array, remainder: Array) -> None:
        """Nothing more than what is known yet.

        Args:
            series: Series of the step.
            watched: Coordinates at the times of the series and, beside them, their velocities, of
                shape (J, 2 d).
            remainder: Remainder at the nodes, shape (J, s).
        """
        self._series, self._watched, self._remainder = series, watched, remainder
        self._number = -1
        self._coefficients: Array = np.empty((0, _TERMS))

    def at(self, time: float) -> Array:
        """Coordinates and velocities, shape (J, 2)."""
        series, count = self._series, len(self._series.times)
        number = int(series.times.searchsorted(time, side="right")) - 1
        if number != self._number:
            x, rate = self._watched[:, number], self._watched[:, count + number]
            found = series.coefficients(number, x, rate, self._remainder)
            self._number, self._coefficients = number, found
        return np.asarray(self._coefficients @ series.waves(number, time))


def _recurrence(nu: Array, width: float, count: int) -> Array:
    """C by x, x', n_0, n_1 .. up to a number of these, shape (J, m, 2 + count)."""
    known, square = np.zeros((len(nu), _TERMS, 2 + count)), (nu * width)[:, None] ** 2
    known[:, 0, 0], known[:, 1, 1] = 1.0, width
    for m in range(_TERMS - 2):
        known[:, m + 2] = -square * known[:, m]
        if m < count:
            known[:, m + 2, 2 + m] += width**2
        known[:, m + 2] /= (m + 1) * (m + 2)
    return known


def _legendre_powers(at: Array, width: float, count: int) -> Array:
    """Legendre polynomials of at + width tau in powers of tau, shape (d, count, count).

    By their recurrence, (k + 1) P_{k+1} = (2 k + 1) x P_k - k P_{k-1}.
    """
    found = np.zeros((len(at), count, count))
    found[:, 0, 0] = 1.0
    for k in range(count - 1):
        found[:, k + 1] = (2 * k + 1) * at[:, None] * found[:, k]
        found[:, k + 1, 1:] += (2 * k + 1) * width * found[:, k, :-1]
        found[:, k + 1] = (found[:, k + 1] - k * found[:, max(k - 1, 0)]) / (k + 1)
    return found
