"""How the frequency of a few motions depends on harmonics, samples and modes.

Each of the three numbers is varied alone, with the others as the study has them; the finest one
is the reference of its row. Beside the true differences are the errors that the points expect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone import point_numbers as numbers
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.errors import StudyError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.resolution.accuracy import SOURCES
from fenics_nnm.resolution.auto import Choice
from fenics_nnm.resolution.probes import probes, solved
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import linear_analysis, prepared
from fenics_nnm.study import Study
from fenics_nnm.study.resolution import Resolution

#: Each number is tried times these factors; the last one is the reference.
_FACTORS = {
    "harmonics": (0.4, 0.7, 1.0, 1.4, 2.0, 3.0),
    "samples": (0.25, 0.5, 1.0, 2.0, 8.0),
    "modes": (0.25, 0.5, 0.75, 1.0, 1.5, 2.0),
}

#: Number of energies where the study reports none.
_ENERGIES = 3


@dataclass(frozen=True, slots=True)
class Row:
    """One motion at one number.

    Attributes:
        source: "harmonics", "samples" or "modes".
        number: N, m or J.
        gamma_ratio: Gamma ratio.
        frequency: Frequency in Hz; nan where no motion was found.
        expected: Relative error of the frequency that the motion itself gives, from this source.
        true: Relative difference of the frequency to that of the largest number.
        status: What may be believed of the motion.
    """

    source: str
    number: int
    gamma_ratio: float
    frequency: float
    expected: float
    true: float
    status: str


@dataclass(frozen=True, slots=True)
class Convergence:
    """Result of a convergence study.

    Attributes:
        around: Numbers that the others are kept at.
        references: Largest number of each source, whose motions are the reference.
        rows: By source, number and energy; without those of the references.
    """

    around: Resolution
    references: dict[str, int]
    rows: tuple[Row, ...]

    @property
    def complete(self) -> bool:
        """Whether all motions were found."""
        return all(np.isfinite(row.true) for row in self.rows)

    def of(self, source: str) -> tuple[Row, ...]:
        """Rows of a source that have a difference."""
        return tuple(row for row in self.rows if row.source == source and np.isfinite(row.true))

    def medians(self, source: str) -> tuple[tuple[int, float, float], ...]:
        """Number, median true and median expected error over the energies, by number."""
        found = self.of(source)
        return tuple(
            (
                number,
                float(np.median([abs(r.true) for r in found if r.number == number])),
                float(np.median([abs(r.expected) for r in found if r.number == number])),
            )
            for number in sorted({row.number for row in found})
        )

    def rate(self, source: str) -> float:
        """Order p of the median error ~ number^-p, by least squares; nan from fewer than two."""
        numbers, errors, _ = np.array(self.medians(source) or [(1, 0, 0)], dtype=float).T
        positive = errors > 0
        if np.count_nonzero(positive) < 2:
            return float("nan")
        return float(-np.polyfit(np.log(numbers[positive]), np.log(errors[positive]), 1)[0])


def convergence(chosen: Choice, comm: MPI.Comm, stages: Stages | None = None) -> Convergence:
    """Vary harmonics, samples and modes of a study, one at a time.

    Args:
        chosen: Study with all its numbers, and what is linear of it.
        comm: Communicator of the mesh.
        stages: Timings and progress.

    Raises:
        StudyError: if the study is one of full order, or ends below grazing.
        NonlinearModeError: if it cannot be run.
    """
    stages, study = stages or Stages(), chosen.study
    if study.full_order:
        raise StudyError(
            'reduction.method = "none": a convergence study is one of reduced models: must be '
            '"massless" or "craig-bampton"'
        )
    ratios = _energies(study, chosen)
    rows: list[Row] = []
    references: dict[str, int] = {}
    for source in SOURCES:
        found = _varied(chosen, source, ratios, comm, stages)
        if len(found) > 1:
            references[source] = max(found)
            rows += _rows(source, ratios, found)
    return Convergence(study.resolution, references, tuple(rows))


def _energies(study: Study, chosen: Choice) -> tuple[float, ...]:
    """Energies that the study reports beyond grazing, or three spread ones."""
    reported = tuple(ratio for ratio in study.continuation.report_at if ratio > 1)
    spread = probes(chosen.prepared, count=_ENERGIES + 1)[1:]
    if not reported and not spread:
        raise StudyError(
            "continuation.energies: end below first contact, where all numbers are exact"
        )
    return reported or spread


def _varied(
    chosen: Choice, source: str, ratios: Sequence[float], comm: MPI.Comm, stages: Stages
) -> dict[int, dict[float, BranchPoint]]:
    """Points by gamma ratio, by number of a source."""
    found: dict[int, dict[float, BranchPoint]] = {}
    for number in _numbers(source, chosen):
        at = replace(chosen.study.resolution, **{source: number})
        linear = chosen.linear
        if source == "modes" and number != chosen.study.resolution.modes:
            linear = linear_analysis(chosen.study, comm, stages, at_most=number)
            at = replace(at, modes=len(linear.modes.omega))
        ready = prepared(chosen.study.with_resolution(at), linear)
        with stages.stage(source):
            points = on_root(comm, solved, ready, ratios)
        found[getattr(at, source)] = {point.gamma_ratio: point for point in points}
    return found


def _numbers(source: str, chosen: Choice) -> list[int]:
    """Numbers to try, ascending, all that the others allow."""
    study, bends = chosen.study, bool(chosen.linear.model.kinematics.forces)
    around, least = study.resolution, 4 if bends or study.cubic else 2
    middle = getattr(around, source)
    numbers = sorted({max(1, round(middle * factor)) for factor in _FACTORS[source]})
    if source == "harmonics":
        return [number for number in numbers if least * number < around.samples]
    if source == "samples":
        return [number for number in numbers if number > least * around.harmonics]
    return [number for number in numbers if number >= study.mode.number]


def _rows(
    source: str, ratios: Sequence[float], found: dict[int, dict[float, BranchPoint]]
) -> list[Row]:
    reference = found[max(found)]
    rows = []
    for number in sorted(found)[:-1]:
        for ratio in ratios:
            point, exact = found[number].get(ratio), reference.get(ratio)
            rows.append(
                Row(
                    source=source,
                    number=number,
                    gamma_ratio=ratio,
                    frequency=point.motion.frequency if point else np.nan,
                    expected=_expected(source, point) if point else np.nan,
                    true=point.motion.frequency / exact.motion.frequency - 1
                    if point and exact
                    else np.nan,
                    status=point.status if point else "no motion found",
                )
            )
    return rows


def _expected(source: str, point: BranchPoint) -> float:
    errors = {
        "harmonics": numbers.harmonics_error(point),
        "samples": numbers.samples_error(point),
        "modes": numbers.reduction_error(point),
    }
    return errors[source]
