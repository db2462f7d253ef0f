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

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.damped_descent import lowered
from fenics_nnm.backbone.damped_model import DampedModel
from fenics_nnm.backbone.damped_path import Solver, Step, Walk, walk
from fenics_nnm.time_domain.resonant_motion import (
    ResonantMotion,
    driven_by_push,
    resonant_motion,
)

#: Up in energy the way begins at this gamma ratio, or at the first one that is wanted.
_OPEN = 0.95

#: Steps of the gamma ratio: the frequency has a kink at first contact.
_UP = Step(0.05, 1e-3)

#: Where no step leads over that kink the way begins anew so far above it, with such parts of what
#: the frequency rises by at a rigid stop; not where the way ended at more than the last of them.
_ABOVE, _RISES = (0.003, 0.01, 0.02, 0.05), (0.6, 0.4, 0.8, 0.2, 1.0)

#: A motion there rises by no more than this times that part: other modes move as well.
_MOST = 1.5


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
    omega = damped.model.omega
    return over_contact(at, omega, walk(at, omega, (first, begun), ratios[-1], _UP, ratios), ratios)


def over_contact(solver: Solver, omega: Array, climbed: Walk, ratios: Sequence[float]) -> Walk:
    """The way up with what is beyond first contact, where it ended there; why it did is kept.

    A mode that would go an amplitude a, and meets a rigid stop at g, has a half period that is
    shorter by arccos(g / a) / omega: with a gamma ratio of 1 + e at a / g = sqrt(1 + e) its
    frequency is higher by the part sqrt(e) / pi, at a softer stop by less. So are guesses.

    Args:
        solver: Finds motions.
        omega: Natural circular frequencies, shape (J,).
        climbed: The way up so far.
        ratios: Gamma ratios that are wanted, ascending.
    """
    last, open_ = climbed.values[-1], [each for each in climbed.motions if not each.changes]
    if not climbed.failure or not open_ or last >= 1 + _ABOVE[-1]:
        return climbed
    grazing = open_[-1]
    for above in _ABOVE:
        ratio = min(max(last, 1.0) + above, ratios[-1])
        rigid = float(np.sqrt(max(ratio - 1, 0.0)) / np.pi)
        for rise in _RISES:
            guess = replace(grazing, omega=(1 + rise * rigid) * grazing.omega)
            found = solver(ratio, guess)
            if not found.failure and found.omega / grazing.omega - 1 <= _MOST * rigid:
                rest = walk(solver, omega, (ratio, found), ratios[-1], _UP, ratios)
                return Walk(
                    climbed.values + rest.values,
                    climbed.motions + rest.motions,
                    rest.failure or climbed.failure,
                )
    return climbed


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
