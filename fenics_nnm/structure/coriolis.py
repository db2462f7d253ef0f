"""What Coriolis forces change of the frequencies of a structure that rotates."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.reduction.linear_modes import LinearModes


@dataclass(frozen=True, slots=True)
class Frequencies:
    """Frequencies in Hz, ascending; none where nothing loads the structure.

    Attributes:
        unloaded: Without steady loads, shape (J,).
        gyroscopic: About the static state with Coriolis forces, shape (J,);
            empty without speed.
    """

    unloaded: Array = field(default_factory=lambda: np.empty(0))
    gyroscopic: Array = field(default_factory=lambda: np.empty(0))


def coriolis_change(coupled: Array, modes: LinearModes, mode: int) -> float:
    """By what part Coriolis forces change the frequency of a mode; 0 where there are none.

    Args:
        coupled: Circular frequencies with Coriolis forces in rad/s; empty without them.
        modes: Modes without.
        mode: Index of the mode, from 0.
    """
    return float(coupled[mode] / modes.omega[mode] - 1) if len(coupled) else 0.0


def coriolis_words(coupled: Array, modes: LinearModes, mode: int) -> str:
    """What Coriolis forces, which a branch leaves out, would change; empty without speed."""
    change = coriolis_change(coupled, modes, mode)
    return f"left out: they would change the frequency by {change:+.1e} of it" if change else ""
