"""Quantities of a motion that values may be asked of: amplitude, stress, energy, frequency."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.motion import Motion

#: Units of the quantities that may be sought.
UNITS = {"amplitude": "m", "stress": "Pa", "energy": "J", "frequency": "Hz"}

Measures = Mapping[str, Callable[[Motion], float]]
"""What finds the quantities of a motion in SI units, by their name; nan where they have none."""

#: What every motion knows.
PLAIN: Measures = {
    "energy": lambda motion: motion.energy,
    "frequency": lambda motion: motion.frequency,
}


@dataclass(frozen=True, slots=True)
class Sought:
    """A value that motions are wanted of.

    Attributes:
        quantity: One of `UNITS`: the largest displacement, the largest von Mises stress away from
            singular places, the energy, or the frequency.
        value: Its value in SI units.
        reported: Whether its points are marked as asked for, and get ParaView files.
    """

    quantity: str
    value: float
    reported: bool = True

    def __str__(self) -> str:
        """The quantity with its value and unit."""
        return f"{self.quantity} {self.value:.6g} {UNITS[self.quantity]}"


def asked_points(points: Sequence[BranchPoint], ratios: Sequence[float]) -> list[BranchPoint]:
    """Points that were asked for by their gamma ratio or by a value."""
    return [point for point in points if point.notes.asked or point.gamma_ratio in ratios]
