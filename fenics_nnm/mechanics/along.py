r"""Which modes move along with a mode that bends far, and what they would change as masters.

The followed mode f alone, all others following statically, bounces at the amplitude a off its first
contact point c, which it reaches at q_0, as off a spring: with

    S = R_cc + sum_{j != f} Phi_cj^2 / omega_j^2,   K = omega_f^2 + Phi_cf^2 / S,
    q_1 = (1 - omega_f^2 / K) q_0,                  v = omega_f sqrt(a^2 - q_0^2)

half a period is (pi / 2 + arcsin(q_0 / a)) / omega_f + arctan(v / (sqrt(K) (q_0 - q_1))) / sqrt(K),
and it comes as far as q_m = q_1 + sqrt((q_0 - q_1)^2 + v^2 / K), pressed by

    lambda = |Phi_cf| (q_m - q_0) / S,      x_i = |Phi_ci| lambda / omega_i^2,

where x_i is how far this moves another mode, or farther where omega_i is near one of the first
three harmonics of omega_f, as in a cluster of modes. Where it is near the second one, the square of
the followed mode, alpha_iff a^2, moves it, too. As a master mode i closes the contact point by
Theta_fi q_m x_i + 1/2 Theta_ii x_i^2, which is as if the gap were smaller, or larger, by that. What
follows the square of the followed mode statically is of third order there, and left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel

#: Harmonics that a mode near them follows dynamically, their part of the largest force (that of a
#: contact of a quarter of the period), and how much farther than statically it moves at most.
_HARMONICS, _PART, _MOST = (1, 2, 3), 1 / 3, 10.0

#: Modes are near the second harmonic if their squares differ by this part at most.
_NEAR = 0.2

#: A gap is changed by this part of it at most.
_MOST_CHANGE = 0.9


@dataclass(frozen=True, slots=True)
class Bounce:
    """The followed mode alone against the spring that its first contact point is.

    Attributes:
        omega: Its circular frequency, rad/s.
        spring: Phi_cf^2 / S, what contact adds to the square of that.
        reach: Amplitude q_0 at which it touches, kg^1/2 m.
        amplitude: Amplitude a of the same energy without contact.
    """

    omega: float
    spring: float
    reach: float
    amplitude: float

    @classmethod
    def of(cls, model: ReducedModel, mode: int, largest_ratio: float) -> Bounce:
        """A mode of a model at an energy.

        Args:
            model: Model; gaps are positive.
            mode: Index of the mode.
            largest_ratio: Its energy over that of grazing.
        """
        rest = model.at_rest()
        reach = rest.amplitude(mode)
        touches = rest.at_one(mode) != "nearest approach"
        return cls(
            omega=float(model.omega[mode]),
            spring=float(model.Phi[rest.first(mode), mode]) ** 2 / _give(model, mode),
            reach=reach if touches else np.inf,
            amplitude=reach * float(np.sqrt(largest_ratio)),
        )

    @property
    def frequency_ratio(self) -> float:
        """Its frequency over that without contact."""
        return np.pi / (self.omega * self._turn(self.reach)[1])

    def at(self, ratio: float) -> Bounce:
        """The same at an energy over that of grazing, of a mode that touches."""
        return replace(self, amplitude=self.reach * float(np.sqrt(ratio)))

    @property
    def largest(self) -> float:
        """How far it comes towards its obstacle, q_m."""
        return self._turn(self.reach)[0]

    def frequency_change(self, change: float) -> float:
        """Relative change of the frequency if the gap changes by a part of it, either way."""
        part = min(change, _MOST_CHANGE)
        short, own, long = (self._turn(self.reach * each)[1] for each in (1 - part, 1.0, 1 + part))
        return abs(1 / short - 1 / long) * own / 2

    def _turn(self, reach: float) -> tuple[float, float]:
        """Largest amplitude and half the period if it touches at an amplitude."""
        if self.amplitude <= reach:
            return self.amplitude, np.pi / self.omega
        stiff = self.omega**2 + self.spring
        apart = self.omega**2 / stiff * reach
        speed = self.omega * np.sqrt(self.amplitude**2 - reach**2)
        root = np.sqrt(stiff)
        inside = np.arctan2(speed, root * apart) / root
        half = (np.pi / 2 + np.arcsin(reach / self.amplitude)) / self.omega + inside
        return float(reach - apart + np.hypot(apart, speed / root)), float(half)


@dataclass(frozen=True, slots=True)
class Along:
    """A mode at its largest amplitude, and how far the others move then.

    Attributes:
        mode: Index of the followed mode f.
        point: Contact point that it brings to its obstacle first.
        bounce: Its motion alone.
        amplitudes: Amplitudes x of the other modes in kg^1/2 m, shape (J,).
    """

    mode: int
    point: int
    bounce: Bounce
    amplitudes: Array

    @classmethod
    def of(cls, model: ReducedModel, mode: int, largest_ratio: float) -> Along:
        """The modes that move along.

        Args:
            model: Model with the followed mode as a master; gaps are positive.
            mode: Index of the followed mode.
            largest_ratio: Largest energy asked for, over that of grazing.
        """
        rest, bounce = model.at_rest(), Bounce.of(model, mode, largest_ratio)
        point, reach, amplitude = rest.first(mode), rest.amplitude(mode), bounce.amplitude
        beyond = bounce.largest - reach if reach < amplitude and np.isfinite(bounce.reach) else 0.0
        force = abs(float(model.Phi[point, mode])) * beyond / _give(model, mode)
        pushed = np.abs(model.Phi[point]) / model.omega**2 * force
        moved = pushed * _amplified(model.omega / bounce.omega) + _driven(model, mode, amplitude)
        moved[mode] = 0.0
        return cls(mode, point, bounce, moved)

    def closing_change(self, model: ReducedModel) -> float:
        """What another master changes of the closing of the contact point, over its gap.

        Args:
            model: Model with two masters, the followed mode and the other one.
        """
        masters = model.kinematics.masters
        own, other = (0, 1) if masters[0] == self.mode else (1, 0)
        x = float(self.amplitudes[masters[other]])
        alone = model.with_modes(masters)  # so that all others follow statically
        Theta = alone.kinematics.tensors["Theta"][self.point]
        closing = (
            abs(Theta[own, other]) * self.bounce.largest * x + abs(Theta[other, other]) * x**2 / 2
        )
        return float(closing / model.gap[self.point])


def _give(model: ReducedModel, mode: int) -> float:
    """S of the first contact point of a mode, in m/N."""
    point = model.at_rest().first(mode)
    give = (model.Phi[point] / model.omega) ** 2
    return float(model.R[point, point] + give.sum() - give[mode])


def _driven(model: ReducedModel, mode: int, a: float) -> Array:
    """Amplitudes that the square of the followed mode drives near its second harmonic, (J,)."""
    own = int(np.searchsorted(model.kinematics.masters, mode))
    alpha, square = model.kinematics.tensors["alpha"][:, own, own], model.omega**2
    apart = np.abs(1 - 4 * square[mode] / square)
    second = np.abs(alpha) * a**2 / (2 * square * np.maximum(apart, 1 / _MOST))
    return np.where(apart < _NEAR, second, 0.0)


def _amplified(ratio: Array) -> Array:
    """How much farther than statically modes move, by their frequency over the followed one."""
    apart = np.min([np.abs(1 - (n / ratio) ** 2) for n in _HARMONICS], axis=0)
    return np.asarray(np.clip(_PART / np.maximum(apart, 1e-300), 1.0, _MOST))
