"""Points of a stored branch that are nearest to a value of a quantity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.quantities import UNITS, Sought
from fenics_nnm.errors import OutputError

#: Quantities of a stored point in SI units, by their names in `UNITS`; nan where not known.
QUANTITIES: dict[str, Callable[[BranchPoint], float]] = {
    "amplitude": lambda point: point.extremes.displacement.value,
    "stress": lambda point: point.extremes.von_mises.away.value,
    "energy": lambda point: point.motion.energy,
    "frequency": lambda point: point.motion.frequency,
}


#: Relative differences of this size, and larger ones, say nothing in per cent.
_MOST_OFF = 1.0


@dataclass(frozen=True, slots=True)
class Nearest:
    """The point that is nearest to one of the crossings of a value.

    Attributes:
        sought: The value.
        point: The point.
        value: What it has in its place.
        number: Which crossing it is, from 1, along the branch; 0 where the value is not crossed.
        crossings: Number of crossings.
    """

    sought: Sought
    point: BranchPoint
    value: float
    number: int
    crossings: int

    @property
    def off(self) -> float:
        """How far the point is from the value, relative to it."""
        return self.value / self.sought.value - 1

    def __str__(self) -> str:
        """The crossing, and the point."""
        where = f"crossing {self.number} of {self.crossings}" if self.crossings else "not crossed"
        off = f", {self.off:+.2%}" if abs(self.off) < _MOST_OFF else ""
        unit = UNITS[self.sought.quantity]
        return (
            f"{self.sought} ({where}): the nearest point, at gamma ratio "
            f"{self.point.gamma_ratio:.6g}, has {self.value:.6g} {unit}{off}"
        )


def nearest_to(points: Sequence[BranchPoint], sought: Sought) -> list[Nearest]:
    """The points nearest to each crossing of a value, or the nearest of all if there is none.

    Raises:
        OutputError: if the points do not know the quantity.
    """
    of = QUANTITIES[sought.quantity]
    known = [(point, of(point)) for point in points if of(point) == of(point)]
    if not known:
        raise OutputError(
            f"{sought}: the points have no {sought.quantity}: they are of matrices, of full order "
            "or of an earlier version"
        )

    def off(each: tuple[BranchPoint, float]) -> float:
        return abs(each[1] - sought.value)

    pairs = [ends for ends in pairwise(known) if _between(ends[0][1], sought.value, ends[1][1])]
    found = list(dict.fromkeys(min(ends, key=off)[0].position for ends in pairs))
    by_position = {point.position: (point, value) for point, value in known}
    if not found:
        return [Nearest(sought, *min(known, key=off), 0, 0)]
    return [
        Nearest(sought, *by_position[position], number, len(found))
        for number, position in enumerate(found, start=1)
    ]


def _between(one: float, value: float, other: float) -> bool:
    return min(one, other) <= value <= max(one, other)
