"""Damped nonlinear modes: motions in phase resonance, gamma ratio by gamma ratio, exact in time.

Without damping a hard contact has many motions at one energy, and which of them is found depends on
the numbers of modes and harmonics. With all other modes heavily damped the motion changes smoothly
with the energy; it is followed from the linear mode up, and from there, at each gamma ratio that is
wanted, down to the real damping (homotopy, see `damped_model` and `damped_descent`). Where the way
ends before, the motion is looked for from that at the gamma ratio before, with the real damping.
The force is that of `time_domain.resonant_map`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.backbone.damped_descent import lowered
from fenics_nnm.backbone.damped_model import DampedModel
from fenics_nnm.backbone.damped_path import Step, Walk, walk
from fenics_nnm.time_domain.resonant_motion import (
    ResonantMotion,
    driven_by_push,
    resonant_motion,
)

#: Up in energy the way begins at this gamma ratio, or at the first one that is wanted.
_OPEN = 0.95

#: Steps of the gamma ratio: the frequency has a kink at first contact.
_UP = Step(0.05, 1e-3)


@dataclass(frozen=True, slots=True)
class Found:
    """What was found at a gamma ratio.

    Attributes:
        gamma_ratio: Gamma ratio.
        motion: The motion; one with a failure if there is none.
    """

    gamma_ratio: float
    motion: ResonantMotion

    @property
    def told(self) -> str:
        """Its frequency, or that there is none."""
        found = f"{self.motion.omega / (2 * np.pi):.6g} Hz"
        return f"{'none' if self.motion.failure else found} at gamma ratio {self.gamma_ratio:g}"


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
        found = lowered(damped, ratio * damped.grazing_gamma, heavy)
        if not found.failure:
            return Found(ratio, found)
        failure = found.failure
    if before is not None:
        way = risen(damped, ratio, before)
        if not way.failure:
            return Found(ratio, way.motions[-1])
        failure = f"{failure}; {way.failure}, on the way from gamma ratio {before.gamma_ratio:g}"
    return Found(ratio, replace(damped.linear(damped.grazing_gamma), failure=failure))


def risen(damped: DampedModel, ratio: float, before: Found) -> Walk:
    """From the motion at another gamma ratio, with the real damping."""
    flow = driven_by_push(damped.model, damped.rate, damped.push)

    def at(other: float, guess: ResonantMotion) -> ResonantMotion:
        return resonant_motion(flow, damped.push, other * damped.grazing_gamma, guess)

    return walk(at, damped.model.omega, (before.gamma_ratio, before.motion), ratio, _UP)
