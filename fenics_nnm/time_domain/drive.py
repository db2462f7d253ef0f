r"""Harmonic forces as sums of rotating numbers: what drives a motion in time.

    p(t) = sum_f P_f exp(i n_f theta(t)),      theta(t) = theta_0 + omega t,

where harmonics n and -n with conjugate amplitudes make a real force; and gaps that move likewise.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array, Complex, Indices
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion


def _not_turning() -> Complex:
    return np.zeros((0, 0, 0), complex)


@dataclass(frozen=True, slots=True)
class Drive:
    """Modal forces and motions of gaps in harmonics of a frequency.

    Attributes:
        omega: Circular frequency in rad/s.
        order: Harmonics n_f, each with its negative, shape (F,).
        amplitude: P_f in N kg^-1/2, shape (J, F).
        gap: How gaps move.
        turning: What each of these adds per master of second-order kinematics, on these, in
            N/(kg m), shape (F, k, k); k = 0 where forces do not turn with the motion.
    """

    omega: float
    order: Array
    amplitude: Complex
    gap: GapMotion = STILL
    turning: Complex = field(default_factory=_not_turning)

    @classmethod
    def of(
        cls,
        omega: float,
        excitations: Sequence[Excitation],
        modes: int,
        gap: GapMotion = STILL,
    ) -> Drive:
        """The forces of excitations at a circular frequency; none is a drive, too."""
        order: list[float] = []
        columns: list[Array | Complex] = []
        turning: list[Complex] = []
        for each in excitations:
            force = (each.cosine - 1j * each.sine) / 2
            turned = (each.turning[0] - 1j * each.turning[1]) / 2
            order += [each.harmonic, -each.harmonic]
            columns += [force, force.conj()]
            turning += [turned, turned.conj()]
        amplitude = np.reshape(np.array(columns, complex), (-1, modes)).T
        parts = np.array(turning, complex) if turning else _not_turning()
        return cls(omega, np.array(order, float), amplitude, gap, parts)

    @property
    def key(self) -> Hashable:
        """What tells it from other drives."""
        gap = self.gap.harmonics, self.gap.amplitudes.tobytes()
        parts = (each.tobytes() for each in (self.order, self.amplitude, self.turning))
        return self.omega, *gap, *parts

    @property
    def rates(self) -> Array:
        """Circular frequencies of the rotating numbers in rad/s, shape (F,)."""
        return self.omega * self.order

    def turned(self, phase: float) -> Complex:
        """P_f exp(i n_f theta) at a phase theta, shape (J, F)."""
        return np.asarray(self.amplitude * np.exp(1j * phase * self.order))

    def turned_pairs(self, phase: float, first: Indices, second: Indices) -> Complex:
        """What forces that turn add, at a phase and pairs of masters, shape (P, F)."""
        if not self.turning.size:
            return np.zeros((len(first), len(self.order)), complex)
        return np.asarray((self.turning[:, first, second].T) * np.exp(1j * phase * self.order))

    def force(self, phase: Array | float) -> Array:
        """The force at phases, shape (.., J)."""
        waves = np.exp(1j * np.multiply.outer(phase, self.order))
        return np.asarray((waves @ self.amplitude.T).real)

    @property
    def gap_rates(self) -> Array:
        """Circular frequencies of the rotating numbers of gaps in rad/s, shape (2 G,)."""
        n = np.array(self.gap.harmonics, float)
        return self.omega * np.concatenate([n, -n])

    def gap_turned(self, phase: float, points: int) -> Complex:
        """Rotating numbers of some gaps at a phase, which add up to their change, (n_c, 2 G)."""
        shape = len(self.gap.harmonics), points
        half = np.broadcast_to(self.gap.amplitudes, shape).T / 2
        turned = half * np.exp(1j * phase * np.array(self.gap.harmonics, float))
        return np.hstack([turned, turned.conj()])

    def gap_at(self, phase: float, points: int) -> tuple[Array, Array]:
        """Change of some gaps in m at a phase, and its rate in m/s, each of shape (n_c,)."""
        if not self.gap.moves:
            return np.zeros(points), np.zeros(points)
        change, rate = self.gap.at(phase), self.omega * self.gap.rate(phase)
        return np.broadcast_to(change, (points,)), np.broadcast_to(rate, (points,))

    def at(self, omega: float) -> Drive:
        """The same at another circular frequency."""
        return replace(self, omega=omega)

    def slower(self, periods: int) -> Drive:
        """The same, written in harmonics of the frequency over a number of periods."""
        harmonics = tuple(periods * n for n in self.gap.harmonics)
        gap = replace(self.gap, harmonics=harmonics)
        return replace(self, omega=self.omega / periods, order=periods * self.order, gap=gap)
