"""What lies ahead of a branch: the followed mode alone, and the modes that it meets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.levels import HarmonicBalance, levels
from fenics_nnm.backbone.resonance import Meeting, meetings
from fenics_nnm.mechanics.force import AddedForce
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.newton import Newton

#: Energies of the outlook lie apart by this factor.
_FACTOR = 1.05


class Horizon(Protocol):
    """How far to look ahead."""

    @property
    def newton(self) -> Newton:
        """Newton's configuration."""

    @property
    def largest_ratio(self) -> float:
        """Gamma ratio to end at."""

    def lies_ahead(self, frequency_ratio: float) -> bool:
        """Whether more is wanted of a branch that has come to a frequency."""


@dataclass(frozen=True, slots=True)
class Outlook:
    """The branch of the followed mode alone, two harmonics, the other modes static.

    Attributes:
        gamma_ratio: Energies from grazing on, ascending, shape (p,).
        frequency_ratio: Frequencies over that of the linear mode, shape (p,), 1 at first where it
            begins with a linear motion.
        meetings: Internal resonances on the way, by frequency.
    """

    gamma_ratio: Array
    frequency_ratio: Array
    meetings: tuple[Meeting, ...]


def outlook(
    model: ReducedModel,
    wanted: Horizon,
    balance: HarmonicBalance,
    *,
    mode: int,
    forces: Sequence[AddedForce] = (),
) -> Outlook:
    """Look ahead at a branch before it is followed.

    Args:
        model: Reduced model in SI units.
        wanted: Which motions are wanted.
        balance: Series in time, and how contact is found.
        mode: Index of the linear mode that the branch starts at, from 0.
        forces: Forces besides contact that the motion determines, in SI units.

    Raises:
        ModelError: if the mode never touches.
    """
    scaled, scales = model.dimensionless(mode)
    own = [force.scaled(scales.amplitude, scales.energy) for force in forces]
    cascade = Cascade(levels(scaled, balance, mode=mode, forces=own), mode, wanted.newton)
    rest = scaled.at_rest()
    first = cascade.coarse(1.0)
    ratios = [1.0]
    linear = rest.is_linear(mode) and not cascade.levels[0].equations.mechanics.forces
    frequencies = [1.0 if linear or first is None else first.omega]
    last = wanted.largest_ratio
    while ratios[-1] < last and wanted.lies_ahead(frequencies[-1]):
        following = min(_FACTOR * ratios[-1], last)
        solution = cascade.coarse(following)
        if solution is None:
            break
        ratios.append(following)
        only_rises = not rest.closed.any()
        frequencies.append(max(solution.omega, frequencies[-1]) if only_rises else solution.omega)
    gamma_ratio, frequency_ratio = np.array(ratios), np.array(frequencies)
    return Outlook(
        gamma_ratio,
        frequency_ratio,
        meetings(
            rest.omega,
            mode=mode,
            harmonics=balance.harmonics,
            gamma_ratio=gamma_ratio,
            frequency_ratio=frequency_ratio,
        ),
    )
