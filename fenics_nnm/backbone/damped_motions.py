r"""Damped nonlinear modes: motions in phase resonance, gamma ratio by gamma ratio, exact in time.

Without damping a hard contact has many motions at one energy, and which of them is found depends on
the numbers of modes and harmonics. With all other modes heavily damped the motion changes smoothly
with the energy; it is followed from the linear mode up, and from there, at each gamma ratio that is
wanted, down to the real damping (homotopy). With the real ratio zeta_j of a mode and the heavy one
Z that of the way is

    zeta_j(s) = max(zeta_j^(1 - s) Z^s, zeta_j),      s = 1 .. 0,

that of the followed mode is as it is throughout. Where the way ends before s = 0, the
motion is looked for from that at the gamma ratio before, with the real damping. The force is that
of `time_domain.resonant_map`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.damped_path import Step, Walk, walk
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.resonant_motion import (
    ResonantMotion,
    driven_by_push,
    resonant_motion,
)

#: Z, and the least ratio that a way begins to reckon with: dashpots may leave modes without any.
HEAVY, _LEAST = 0.3, 1e-3

#: Up in energy the way begins at this gamma ratio, or at the first one that is wanted.
_OPEN = 0.95

#: Steps of the gamma ratio, where the frequency has a kink at first contact, and of s.
_UP, _DOWN = Step(0.05, 1e-3), Step(0.06, 1e-3, jump=3e-3, leap=0.1)


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

    def rate_at(self, s: float) -> Array:
        """C on the way from the real damping, s = 0, to heavily damped other modes, s = 1."""
        omega = self.model.omega
        own = np.maximum(np.diagonal(self.rate) / (2 * omega), _LEAST)
        more = 2 * omega * np.maximum(own ** (1 - s) * HEAVY**s - own, 0.0)
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


@dataclass(frozen=True, slots=True)
class Found:
    """What was found at a gamma ratio.

    Attributes:
        gamma_ratio: Gamma ratio.
        motion: The motion; one with a failure if there is none.
    """

    gamma_ratio: float
    motion: ResonantMotion


def damped_motions(damped: DampedModel, ratios: Sequence[float]) -> Iterator[Found]:
    """Damped motions at gamma ratios, ascending.

    Args:
        damped: Model with its damping.
        ratios: Gamma ratios, ascending.
    """
    climbed = _climbed(damped, ratios)
    before: Found | None = None
    for ratio in ratios:
        found = _found(damped, ratio, climbed, before)
        before = before if found.motion.failure else found
        yield found


def _climbed(damped: DampedModel, ratios: Sequence[float]) -> Walk:
    """Up in energy with heavily damped other modes."""
    first = min(_OPEN, ratios[0])
    flow = driven_by_push(damped.model, damped.rate_at(1.0), damped.push)

    def at(ratio: float, guess: ResonantMotion) -> ResonantMotion:
        return resonant_motion(flow, damped.push, ratio * damped.grazing_gamma, guess)

    begun = at(first, damped.linear(first * damped.grazing_gamma))
    if begun.failure:
        return Walk((), (), begun.failure)
    return walk(at, damped.model.omega, (first, begun), ratios[-1], _UP, ratios)


def _found(damped: DampedModel, ratio: float, climbed: Walk, before: Found | None) -> Found:
    """The motion at a gamma ratio: down in damping, or else up in energy."""
    heavy = climbed.at(ratio)
    if heavy is None:
        failure = f"with heavily damped other modes: {climbed.failure}"
    else:
        lowered = _lowered(damped, ratio, heavy)
        if not lowered.failure:
            return Found(ratio, lowered.motions[-1])
        failure = f"{lowered.failure}, on the way down from heavy damping"
    if before is not None:
        risen = _risen(damped, ratio, before)
        if not risen.failure:
            return Found(ratio, risen.motions[-1])
        failure = f"{failure}; {risen.failure}, on the way from gamma ratio {before.gamma_ratio:g}"
    return Found(ratio, replace(damped.linear(damped.grazing_gamma), failure=failure))


def _lowered(damped: DampedModel, ratio: float, heavy: ResonantMotion) -> Walk:
    """From heavily damped other modes down to the real damping."""

    def at(s: float, guess: ResonantMotion) -> ResonantMotion:
        flow = driven_by_push(damped.model, damped.rate_at(s), damped.push)
        return resonant_motion(flow, damped.push, ratio * damped.grazing_gamma, guess)

    return walk(at, damped.model.omega, (1.0, heavy), 0.0, _DOWN)


def _risen(damped: DampedModel, ratio: float, before: Found) -> Walk:
    """From the motion at another gamma ratio, with the real damping."""
    flow = driven_by_push(damped.model, damped.rate, damped.push)

    def at(other: float, guess: ResonantMotion) -> ResonantMotion:
        return resonant_motion(flow, damped.push, other * damped.grazing_gamma, guess)

    return walk(at, damped.model.omega, (before.gamma_ratio, before.motion), ratio, _UP)
