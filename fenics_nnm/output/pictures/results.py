"""A results folder, read for its pictures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.backbone.point import CONVERGED, VERIFIED, BranchPoint, believable
from fenics_nnm.errors import OutputError
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.motion import (
    force_rates_at,
    forces_at,
    free_displacement,
    free_rates,
)
from fenics_nnm.results import branch_file
from fenics_nnm.results.branch_file import BranchHeader
from fenics_nnm.results.stored_branch import StoredBranch, read_stored_branch

#: Most energies that one picture shows.
_MOST_CHOSEN = 3

#: Forces of a period whose first harmonic is below this part of their sum have no middle.
_NO_MIDDLE = 0.05


@dataclass(frozen=True, slots=True)
class Results:
    """A branch with all that its pictures need.

    Attributes:
        header: What holds for all points.
        points: Points by position.
        summary: Contents of summary.json; empty for a run that was stopped.
        body: The branch on its mesh; None for matrices.
        areas: Tributary areas of the contact points in m^2, shape (n_c,); None for matrices.
        tip: The node that moves most at the last point shown; 0 for matrices.
    """

    header: BranchHeader
    points: tuple[BranchPoint, ...]
    summary: dict[str, Any]
    body: StoredBranch | None
    areas: Array | None
    tip: int = 0

    @property
    def model(self) -> ReducedModel:
        """Reduced model in SI units."""
        return self.header.model

    @property
    def series(self) -> Series:
        """Series in time of the points."""
        return self.header.time_series

    @property
    def linear_frequency(self) -> float:
        """Frequency of the followed linear mode in Hz."""
        known = self.summary.get("linear_frequencies_Hz")
        index = self.header.mode - 1
        return float(known[index] if known else self.model.at_rest().omega[index] / (2 * np.pi))

    @property
    def ratios(self) -> Array:
        """Gamma ratio of each point."""
        return np.array([point.gamma_ratio for point in self.points])

    @property
    def shown(self) -> tuple[BranchPoint, ...]:
        """Points whose motions are shown: not those that failed, unless all did."""
        return _shown(self.points)

    @property
    def trusted(self) -> tuple[BranchPoint, ...]:
        """Points whose numbers stand alone: verified ones in contact, else converged ones.

        Where none of these touches, those without contact; where there is none, all that are shown.
        """
        for status in (VERIFIED, CONVERGED):
            alike = tuple(point for point in self.touching if point.status == status)
            if alike:
                return alike
        calm = tuple(point for point in self.shown if point.status in (VERIFIED, CONVERGED))
        return calm or self.shown

    @property
    def touching(self) -> tuple[BranchPoint, ...]:
        """Points shown that have contact."""
        return tuple(point for point in self.shown if point.motion.force.max(initial=0.0) > 0)

    @property
    def chosen(self) -> tuple[BranchPoint, ...]:
        """Points that pictures of motions show: reported ones that are trusted, or else others."""
        continuation = self.header.values.get("continuation", {})
        named = continuation.get("report_at", [])
        wanted = [ratio for ratio in named if not isinstance(ratio, str)]
        asked = tuple(point for point in self.trusted if point.notes.asked)
        return _spread(_first_of_each(self.trusted, wanted) or asked or self.trusted)

    @property
    def chosen_touching(self) -> tuple[BranchPoint, ...]:
        """Chosen points with contact, or else some with contact."""
        chosen = [point for point in self.chosen if point.motion.force.max(initial=0.0) > 0]
        return tuple(chosen) or _spread(self.touching)

    def forces(self, point: BranchPoint, phase: Array) -> Array:
        """Contact forces in N at phases omega t, shape (len(phase), n_c)."""
        return forces_at(self.model, self.series, point.motion, phase)

    def contact_displacement(self, point: BranchPoint, phase: Array) -> Array:
        """Displacement of the contact points towards the obstacle in m, (len(phase), n_c)."""
        free = free_displacement(self.model, self.series, point.motion, phase)
        return np.asarray(free - self.forces(point, phase) @ self.model.R)

    def contact_velocity(self, point: BranchPoint, phase: Array) -> Array:
        """Velocity of the contact points towards the obstacle in m/s, (len(phase), n_c)."""
        free = free_rates(self.model, self.series, point.motion, phase)
        rates = force_rates_at(self.model, self.series, point.motion, phase)
        return 2 * np.pi * point.motion.frequency * np.asarray(free - rates @ self.model.R)

    def middle(self, point: BranchPoint) -> float:
        """Phase of the middle of contact; 0 where contact is spread over the period."""
        phase = self.series.phase
        total = (
            self.series.weight @ (point.motion.force.sum(axis=1)[:, None] * _circle(phase, self))
        )[0]
        mean = float(self.series.weight @ point.motion.force.sum(axis=1))
        return float(np.angle(total)) if abs(total) > _NO_MIDDLE * mean else 0.0

    def period_about(self, point: BranchPoint, instants: int) -> tuple[Array, Array]:
        """Time over the period from -1/2 to 1/2, and the phases, the middle of contact at 0."""
        time = np.linspace(-0.5, 0.5, instants + 1)
        return time, 2 * np.pi * time + self.middle(point)


def _circle(phase: Array, results: Results) -> Array:
    """exp(i phase); cosines only where samples stand for both halves of a period."""
    turning = np.exp(1j * phase) if results.series.free_phase else np.cos(phase) + 0j
    return np.asarray(turning[:, None])


def read_results(folder: Path) -> Results:
    """Read a results folder of `fenics-nnm run`.

    Raises:
        OutputError: if it has no branch.h5, or one that cannot be read or has no points.
    """
    path = folder / "branch.h5"
    if not path.exists():
        raise OutputError(f"{path}: is missing: must be the results folder of a run")
    header, points = branch_file.read(path)
    if not points:
        raise OutputError(f"{path}: has no points to draw")
    with h5py.File(path, "r") as file:
        meshed = "mesh" in file
        areas = np.array(file["contact/areas"]) if "contact/areas" in file else None
    body = read_stored_branch(path) if meshed else None
    tip = int(np.argmax(body.largest_displacement(_shown(points)[-1]))) if body else 0
    return Results(header, points, _summary(folder / "summary.json"), body, areas, tip)


def _summary(path: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(path.read_text("utf-8"))) if path.exists() else {}
    except ValueError as error:
        raise OutputError(f"{path}: cannot be read: {error}") from error


def _shown(points: tuple[BranchPoint, ...]) -> tuple[BranchPoint, ...]:
    return believable(points) or points


def _first_of_each(
    points: Sequence[BranchPoint], ratios: Sequence[float]
) -> tuple[BranchPoint, ...]:
    """The first point at each gamma ratio, by position."""
    found: dict[float, BranchPoint] = {}
    for point in points:
        if point.gamma_ratio in ratios:
            found.setdefault(point.gamma_ratio, point)
    return tuple(found.values())


def _spread(points: Sequence[BranchPoint]) -> tuple[BranchPoint, ...]:
    """At most so many points as one picture shows, with the first and the last."""
    count = min(len(points), _MOST_CHOSEN)
    places: Indices = np.unique(np.linspace(0, len(points) - 1, count).round().astype(int))
    return tuple(points[place] for place in places) if count else ()
