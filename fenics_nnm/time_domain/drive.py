r"""Harmonic forces as sums of rotating numbers: what drives a motion in time.

    p(t) = sum_f P_f exp(i n_f theta(t)),      theta(t) = theta_0 + omega t,

where harmonics n and -n with conjugate amplitudes make a real force.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.mechanics.excitation import Excitation


@dataclass(frozen=True, slots=True)
class Drive:
    """Modal forces in harmonics of a frequency.

    Attributes:
        omega: Circular frequency in rad/s.
        order: Harmonics n_f, each with its negative, shape (F,).
        amplitude: P_f in N kg^-1/2, shape (J, F).
    """

    omega: float
    order: Array
    amplitude: Complex

    @classmethod
    def of(cls, omega: float, excitations: Sequence[Excitation], modes: int) -> Drive:
        """The forces of excitations at a circular frequency; none is a drive, too."""
        order: list[float] = []
        columns: list[Array | Complex] = []
        for each in excitations:
            force = (each.cosine - 1j * each.sine) / 2
            order += [each.harmonic, -each.harmonic]
            columns += [force, force.conj()]
        amplitude = np.reshape(np.array(columns, complex), (-1, modes)).T
        return cls(omega, np.array(order, float), amplitude)

    @property
    def rates(self) -> Array:
        """Circular frequencies of the rotating numbers in rad/s, shape (F,)."""
        return self.omega * self.order

    def turned(self, phase: float) -> Complex:
        """P_f exp(i n_f theta) at a phase theta, shape (J, F)."""
        return np.asarray(self.amplitude * np.exp(1j * phase * self.order))

    def force(self, phase: Array | float) -> Array:
        """The force at phases, shape (.., J)."""
        waves = np.exp(1j * np.multiply.outer(phase, self.order))
        return np.asarray((waves @ self.amplitude.T).real)

    def at(self, omega: float) -> Drive:
        """The same at another circular frequency."""
        return replace(self, omega=omega)
