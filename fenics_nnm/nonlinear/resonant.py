r"""Harmonic equations of phase resonance: driven motions whose force does not push against them.

The force of a harmonic n has a known distribution p_n and an unknown level; besides the harmonic
equations of the driven motion it is in phase with the velocity,

    (Lambda - n^2 omega^2) q_n + omega C q'_n + f_n + Phi^T lambda_n = level p_n,
    sum over the cosine and sine of harmonic n of p_n . q_n = 0,

so that it makes up for what damping takes, and nothing else. A force that turns with second-order
displacement does so at each level. With damping of one mode alone and
without contact this is the resonance at which a force lags by 90 degrees. Motions of all levels are
a family with one parameter: the backbone that a test by phase resonance follows.

S. Peter and R. I. Leine, "Excitation power quantities in phase resonance testing of nonlinear
systems with phase-locked-loop excitation", Mech. Syst. Signal Process. 96 (2017) 139-158.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.nonlinear.conditions import Quantity
from fenics_nnm.nonlinear.equations import OMEGA, Equations
from fenics_nnm.nonlinear.timed import TimedEquations
from fenics_nnm.nonlinear.unknowns import Unknowns


@dataclass(frozen=True, slots=True)
class ResonantEquations(TimedEquations):
    """The driven equations of mechanics whose excitations are those of level 1.

    The level takes the place of the drift of a free motion, and the force's being in phase with the
    velocity that of a phase which is kept: steps from a guess that obeys it obey it.
    """

    push: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        TimedEquations.__post_init__(self)
        pushes = [each.harmonics(self.series) for each in self.mechanics.excitations]
        object.__setattr__(self, "push", np.sum(pushes, axis=0))
        object.__setattr__(self, "free_phase", True)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return (OMEGA, "level")

    def residual(self, at: Unknowns, forces: ContactForces) -> Array:
        """Left-hand sides of the harmonic equations, shape (c, J)."""
        return self.sampled.residual(at, forces) - (at.parameters[1] - 1) * self._pushed(at)

    def jacobian(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivative of the residual by q, shape (c J, c J), rows and columns (n, j)."""
        matrix = TimedEquations.jacobian(self, at, forces)
        for force in self.mechanics.turned:
            matrix += (at.parameters[1] - 1) * force.tangent(self._motion(at))
        return matrix

    def slopes(self, at: Unknowns, forces: ContactForces) -> Array:
        """Derivatives of the residual by frequency and level, shape (2, c, J)."""
        return np.concatenate([self.sampled.slopes(at, forces), -self._pushed(at)[None]])

    def phase_shift(self, q: Array) -> Array:
        """The change that makes the force push against the motion: there is none of it."""
        return self.push

    def balanced_level(self, at: Unknowns) -> float:
        """The level at which the force puts in what damping takes out: that of every motion."""
        put_in = self._mean(self._pushed(at), self.series.turned(at.q))
        return self._lost(at) / put_in

    def damping_ratio(self, at: Unknowns) -> float:
        """Dissipated power over 4 omega times the mean kinetic energy: zeta of a linear mode."""
        rates = self.series.turned(at.q)
        return self._lost(at) / (2 * at.omega**2 * self._mean(rates, rates))

    def _pushed(self, at: Unknowns) -> Array:
        """What the force of level 1 does to a motion, shape (c, J)."""
        turned = sum(force.harmonics(self._motion(at)) for force in self.mechanics.turned)
        return np.asarray(self.push - turned)

    def _motion(self, at: Unknowns) -> SampledMotion:
        return SampledMotion(self.series, at.q, at.omega)

    def _lost(self, at: Unknowns) -> float:
        """Dissipated energy of a period over 2 pi."""
        linear = self.mechanics.linear.at(self.series, at.omega)
        return self._mean(linear.times(at.q), self.series.turned(at.q))

    def _mean(self, first: Array, second: Array) -> float:
        """Mean over the phase of a product, both as coefficients, shape (c, J)."""
        return float(np.sum(self.series.mean_square[:, None] * first * second))


@dataclass(frozen=True, slots=True)
class FixedLevel:
    """level / target - 1 = 0."""

    level: float

    def value(self, equations: Equations, at: Unknowns) -> float:
        """Relative distance from the wanted level."""
        return float(at.parameters[1]) / self.level - 1

    def gradient(self, equations: Equations, at: Unknowns) -> Unknowns:
        """Derivatives by coefficients and parameters."""
        return Unknowns(np.zeros_like(at.q), np.array([0.0, 1 / self.level]))


LEVEL = Quantity("level", lambda solution: float(solution.at.parameters[1]), FixedLevel)
