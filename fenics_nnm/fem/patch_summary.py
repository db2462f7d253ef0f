"""What a contact patch turned out to be, in numbers and in a line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.contact import ContactInterface

#: Directions within this angle in radians of each other are one.
_ONE_DIRECTION = 1e-6


@dataclass(frozen=True, slots=True)
class PatchSummary:
    """Points, area and gaps of a patch.

    Attributes:
        name: Name.
        points: Number of contact points.
        area_m2: Area.
        smallest_gap_m: Smallest initial gap.
        largest_gap_m: Largest initial gap.
        mean_direction: Unit vector along the mean contact direction, or zeros if there is none.
        largest_turn_deg: Largest angle of a contact direction to it.
        without_counterpart: Number of vertices that have nothing opposite and were left out.
    """

    name: str
    points: int
    area_m2: float
    smallest_gap_m: float
    largest_gap_m: float
    mean_direction: tuple[float, ...]
    largest_turn_deg: float
    without_counterpart: int

    def __str__(self) -> str:
        """One line, with units."""
        low, high = self.smallest_gap_m, self.largest_gap_m
        even = high - low <= 1e-9 * max(abs(high), abs(low))
        gaps = f"gap {low:.4g} m" if even else f"gaps {low:.4g} to {high:.4g} m"
        mean = ", ".join(f"{round(x, 4) + 0.0:.4g}" for x in self.mean_direction)
        turned = self.largest_turn_deg > np.degrees(_ONE_DIRECTION)
        turn = f" within {self.largest_turn_deg:.3g} degrees" if turned else ""
        towards = f"towards ({mean}){turn}" if any(self.mean_direction) else "towards several sides"
        left = f", {self.without_counterpart} vertices with nothing opposite left out"
        return (
            f"{self.name}: {self.points} points, {self.area_m2:.6g} m^2, {gaps}, "
            f"{towards}{left if self.without_counterpart else ''}"
        )


def patch_summaries(interface: ContactInterface) -> tuple[PatchSummary, ...]:
    """Summary of each patch."""
    return tuple(_summary(interface, number) for number in range(len(interface.names)))


def _summary(interface: ContactInterface, number: int) -> PatchSummary:
    mine = interface.patch == number
    gap = interface.gap[mine]
    mean, turn = _mean_direction(interface.directions[mine])
    return PatchSummary(
        name=interface.names[number],
        points=int(np.count_nonzero(mine)),
        area_m2=float(interface.areas[mine].sum()),
        smallest_gap_m=float(gap.min()),
        largest_gap_m=float(gap.max()),
        mean_direction=tuple(float(x) for x in mean),
        largest_turn_deg=turn,
        without_counterpart=interface.left_out[number],
    )


def _mean_direction(directions: Array) -> tuple[Array, float]:
    """Unit vector along the mean of unit vectors, and the largest angle to it in degrees."""
    mean = directions.mean(axis=0)
    length = np.linalg.norm(mean)
    if length < 1e-9:
        return np.zeros_like(mean), 180.0
    mean = mean / length
    chord = np.linalg.norm(directions - mean, axis=1).max()
    return mean, float(np.degrees(2 * np.arcsin(min(chord / 2, 1.0))))
