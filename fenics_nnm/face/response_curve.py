"""A curve of a response in Python: motions of one place along it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.response.point import ResponsePoint


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ResponseCurve:
    """Motions of one place along a curve, in its order; nan where no motion was found.

    Attributes:
        level: Factor of the forces.
        branch: Number of the curve at this level, from 1.
        place: Name of the place that is watched.
        frequency_Hz: Frequency of each point in Hz, shape (p,).
        speed_rad_per_s: Speed of rotation in rad/s; nan where it is not tied to the frequency.
        amplitude_m: Amplitude of the first harmonic in m, 0-peak.
        phase_deg: Its lag in degrees, behind cos(omega t).
        highest_m: Largest displacement over the period in m.
        lowest_m: Smallest displacement over the period in m.
        contact_fraction: Part of the period with contact.
        stable: Whether the motion is stable, or nothing says that it is not.
        status: Status of each point: "exact", "verified", "converged", "touches" or "failed".
    """

    level: float
    branch: int
    place: str
    frequency_Hz: Array
    speed_rad_per_s: Array
    amplitude_m: Array
    phase_deg: Array
    highest_m: Array
    lowest_m: Array
    contact_fraction: Array
    stable: Array
    status: Array

    def __len__(self) -> int:
        return len(self.frequency_Hz)

    def __repr__(self) -> str:
        return f"ResponseCurve({len(self)} points of {self.place} at level {self.level:g})"


def curve_of(points: Sequence[ResponsePoint], name: str, place: int) -> ResponseCurve:
    """The curve of points of one level, for the place of a name and a number."""

    def along(of: Iterable[float]) -> Array:
        return np.array(list(of))

    moved = [point.displacements for point in points]
    return ResponseCurve(
        level=points[0].level,
        branch=points[0].branch,
        place=name,
        frequency_Hz=along(point.frequency for point in points),
        speed_rad_per_s=along(point.speed for point in points),
        amplitude_m=along(point.amplitude[place] for point in points),
        phase_deg=along(point.phase[place] for point in points),
        highest_m=along(each.highest[place] for each in moved),
        lowest_m=along(each.lowest[place] for each in moved),
        contact_fraction=along(each.contact[place] for each in moved),
        stable=np.array([point.judgement.stability in ("", "stable") for point in points]),
        status=np.array([str(point.status) for point in points]),
    )
