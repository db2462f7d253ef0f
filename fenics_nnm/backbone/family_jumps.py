"""Neighbours of a branch whose frequencies do not follow from each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.motion import Motion


@dataclass(frozen=True, slots=True)
class Jump:
    """Where the frequency changes between neighbours by more than their slopes say.

    Attributes:
        gamma_ratios: Gamma ratios of the two.
        change: Relative change of the frequency.
        predicted: Smallest and largest relative change that their slopes say.
        contacts: Number of contacts a period of the two.
    """

    gamma_ratios: tuple[float, float]
    change: float
    predicted: tuple[float, float]
    contacts: tuple[int, int]

    def __str__(self) -> str:
        first, second = self.gamma_ratios
        low, high = (f"{100 * each + 0.0:+.2g}" for each in self.predicted)
        expected = f"{low} %" if low == high else f"{low} to {high} %"
        one, other = self.contacts
        bounces = "" if one == other else f"; contacts a period: {one} and {other}"
        return (
            f"jump between gamma ratio {first:g} and {second:g}: the frequency changes by "
            f"{100 * self.change:+.2g} %, predicted {expected}{bounces}"
        )


def contacts(series: Series, motion: Motion) -> int:
    """Number of separate times a period in which some point touches; 1 if one always does.

    Args:
        series: Series that the motion is written in.
        motion: Motion.
    """
    touches = np.asarray((motion.force > 0).any(axis=1))
    if not series.free_phase:  # the samples are those of half a period
        touches = np.concatenate([touches, touches[1 : series.samples - len(touches) + 1][::-1]])
    return max(int(np.count_nonzero(touches & ~np.roll(touches, 1))), int(touches.any()))
