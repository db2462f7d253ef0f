"""Families of a branch side by side: where each goes, and where several are confirmed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
    """Motions of several families at one energy, all confirmed in time.

    Attributes:
        energy: Energy in J.
        families: Numbers of the families with the lowest and with the highest frequency.
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
    """Energies of points at which motions of several families are confirmed, by rising energy.

    Only those whose frequencies differ by more than 1e-3.
    """
    confirmed = _by_family([point for point in points if point.confirmed])
    courses = {number: _course(members) for number, members in confirmed.items()}
    found = [
        _at(point, courses)
        for members in confirmed.values()
        for point in members
        if len(confirmed) > 1
    ]
    apart = [each for each in found if each.spread > SAME_FREQUENCY]
    return tuple(sorted(apart, key=lambda each: each.energy))


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


def _course(members: Sequence[BranchPoint]) -> tuple[Array, Array]:
    """Ln of energies, ascending, and frequencies."""
    energies = np.log([point.motion.energy for point in members])
    order = np.argsort(energies, kind="stable")
    return energies[order], np.array([point.motion.frequency for point in members])[order]


def _at(point: BranchPoint, courses: dict[int, tuple[Array, Array]]) -> Coexistence:
    """The families at the energy of a point."""
    energy, own = float(np.log(point.motion.energy)), (point.motion.frequency, point.family)
    others = [
        (frequency, number)
        for number, course in courses.items()
        if number != point.family and np.isfinite(frequency := _frequency(course, energy))
    ]
    low, high = min([own, *others]), max([own, *others])
    return Coexistence(point.motion.energy, (low[1], high[1]), (low[0], high[0]))


def _frequency(course: tuple[Array, Array], energy: float) -> float:
    """Frequency of a family at ln E between two of its points; nan where it is not known."""
    energies, frequencies = course
    after = int(np.searchsorted(energies, energy))
    if not 0 < after < len(energies) or energies[after] - energies[after - 1] > _NEAR:
        return float("nan")
    return float(np.interp(energy, energies, frequencies))
