r"""A damped model, and its damping on the way from heavily damped other modes to the real one.

With the real ratio zeta_j of a mode and the heavy one Z the ratio on the way is

    zeta_j(s) = max(zeta_j^(1 - s) Z^s, zeta_j),      s = 1 .. 0,

that of the followed mode is as it is throughout.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.resonant_motion import ResonantMotion

#: Z, and the least ratio that a way begins to reckon with: dashpots may leave modes without any.
HEAVY, _LEAST = 0.3, 1e-3


@dataclass(frozen=True, slots=True)
class DampedModel:
    """A damped model, and what keeps its motions up.

    Attributes:
        model: Reduced model, contact points without mass, positive gaps, linear kinematics.
        rate: C in 1/s, shape (J, J).
        push: p of the force, per unit of its level, kg^-1/2 N, shape (J,).
        mode: Index of the followed mode.
    """

    model: ReducedModel
    rate: Array
    push: Array
    mode: int

    @property
    def grazing_gamma(self) -> float:
        """Gamma of the linear mode at first contact, in kg m^2."""
        return self.model.grazing_amplitude(self.mode) ** 2 / 4

    def ratios_at(self, s: float) -> Array:
        """Ratios of all modes on the way, as if the followed one had more as well, shape (J,)."""
        own = self._own
        return np.asarray(np.maximum(own ** (1 - s) * HEAVY**s, own))

    def least_other_at(self, s: float) -> float:
        """The smallest ratio of the other modes on the way; nan where there are none."""
        others = np.delete(self.ratios_at(s), self.mode)
        return float(others.min()) if len(others) else float("nan")

    def rate_at(self, s: float) -> Array:
        """C on the way from the real damping, s = 0, to heavily damped other modes, s = 1."""
        more = 2 * self.model.omega * (self.ratios_at(s) - self._own)
        more[self.mode] = 0.0
        return self.rate + np.diag(more)

    def linear(self, gamma: float) -> ResonantMotion:
        """The linear mode, as a guess: as if the force moved nothing else."""
        size, omega, push = self.model.modes, float(self.model.omega[self.mode]), self.push
        turn = 1.0 if push[self.mode] >= 0 else -1.0
        q = np.zeros(size)
        q[self.mode] = turn * 2 * np.sqrt(gamma)
        lost = float(self.rate[self.mode, self.mode]) * omega * float(abs(q[self.mode]))
        least = 1e-6 * omega**2 * float(abs(q[self.mode]))
        level = max(lost, least) / max(abs(float(push[self.mode])), 1e-300)
        return ResonantMotion(q, np.zeros(size), omega, level)

    @property
    def _own(self) -> Array:
        """Ratios of the study, none below the least one, shape (J,)."""
        return np.maximum(np.diagonal(self.rate) / (2 * self.model.omega), _LEAST)
