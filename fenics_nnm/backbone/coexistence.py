"""Families of a branch side by side: where each goes, and where several are confirmed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.families import SAME_FREQUENCY
from fenics_nnm.backbone.point import NO_FAMILY, BranchPoint

#: A family is known at an energy between two of its points that are no farther apart in ln E.
_NEAR = 0.15


@dataclass(frozen=True, slots=True)
class Reach:
    """Where the points of a family are.

    Attributes:
        family: Its number.
        points: How many there are.
        confirmed: How many of them integration in time confirms.
        gamma_ratio: Smallest and largest gamma ratio.
        energy: Smallest and largest energy in J.
        frequency: Smallest and largest frequency in Hz.
    """

    family: int
    points: int
    confirmed: int
    gamma_ratio: tuple[float, float]
    energy: tuple[float, float]
    frequency: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Coexistence:
    """Motions of one energy with different frequencies, all confirmed in time.

    Attributes:
        energy: Energy in J.
        families: Numbers of the families with the lowest and with the highest frequency; one and
            the same where that turns back.
        frequencies: Lowest and highest frequency in Hz.
    """

    energy: float
    families: tuple[int, int]
    frequencies: tuple[float, float]

    @property
    def spread(self) -> float:
        """Highest frequency over the lowest, less 1."""
        return self.frequencies[1] / self.frequencies[0] - 1

    def __str__(self) -> str:
        low, high = (f"{each:.6g}" for each in self.frequencies)
        return (
            f"at {self.energy:.4g} J several motions are confirmed in time, with frequencies from "
            f"{low} to {high} Hz ({self.spread:.2%} apart)"
        )


def reaches(points: Sequence[BranchPoint]) -> tuple[Reach, ...]:
    """Where each family of a branch goes, by their numbers."""
    return tuple(_reach(number, members) for number, members in sorted(_by_family(points).items()))


def coexistences(points: Sequence[BranchPoint]) -> tuple[Coexistence, ...]:
    """Energies of points at which several motions are confirmed, by rising energy.

    Only those whose frequencies differ by more than 1e-3. Between two neighbours of one family that
    are both confirmed its frequency is taken linear in ln E.

    Args:
        points: Points in the order of the branch.
    """
    ways = [
        _Way(start, np.log([one.motion.energy, other.motion.energy]), one, other)
        for start, (one, other) in enumerate(pairwise(points))
        if one.confirmed and other.confirmed and one.family == other.family != NO_FAMILY
    ]
    near = [way for way in ways if abs(way.ends[1] - way.ends[0]) <= _NEAR]
    found = [
        _at(index, point, near)
        for index, point in enumerate(points)
        if point.confirmed and point.family != NO_FAMILY
    ]
    apart = [each for each in found if each.spread > SAME_FREQUENCY]
    return tuple(sorted(apart, key=lambda each: each.energy))


@dataclass(frozen=True, slots=True)
class _Way:
    """From a point to the next one of its family: the number of the first, ln E of both, and both.

    Attributes:
        start: Number of the first point.
        ends: ln E of both.
        one: The first point.
        other: The second one.
    """

    start: int
    ends: Array
    one: BranchPoint
    other: BranchPoint

    def passes(self, energy: float) -> bool:
        """Whether it leads over an energy, given as ln E."""
        return bool(self.ends.min() <= energy <= self.ends.max())

    def frequency(self, energy: float) -> float:
        """Frequency on the way at an energy, given as ln E."""
        ends = (self.one.motion.frequency, self.other.motion.frequency)
        width = self.ends[1] - self.ends[0]
        part = (energy - self.ends[0]) / width if width else 0.0
        return float(ends[0] + part * (ends[1] - ends[0]))


def _at(index: int, point: BranchPoint, ways: Sequence[_Way]) -> Coexistence:
    """The motions at the energy of a point: itself, and those that other ways lead over."""
    energy = float(np.log(point.motion.energy))
    found = [(point.motion.frequency, point.family)]
    found += [
        (way.frequency(energy), way.one.family)
        for way in ways
        if way.start not in (index - 1, index) and way.passes(energy)
    ]
    low, high = min(found), max(found)
    return Coexistence(point.motion.energy, (low[1], high[1]), (low[0], high[0]))


def _by_family(points: Sequence[BranchPoint]) -> dict[int, list[BranchPoint]]:
    known = [point for point in points if point.family != NO_FAMILY]
    return {
        number: [point for point in known if point.family == number]
        for number in sorted({point.family for point in known})
    }


def _reach(number: int, members: Sequence[BranchPoint]) -> Reach:
    def span(values: Sequence[float]) -> tuple[float, float]:
        return min(values), max(values)

    return Reach(
        family=number,
        points=len(members),
        confirmed=sum(point.confirmed for point in members),
        gamma_ratio=span([point.gamma_ratio for point in members]),
        energy=span([point.motion.energy for point in members]),
        frequency=span([point.motion.frequency for point in members]),
    )
