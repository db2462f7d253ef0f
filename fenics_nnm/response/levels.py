"""Responses of a driven structure at several levels of its forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.response.curve import curve
from fenics_nnm.response.driven import open_response
from fenics_nnm.response.instead import Instead
from fenics_nnm.response.open_peaks import open_peaks
from fenics_nnm.response.peaks import Peak, curve_peaks
from fenics_nnm.response.phase_resonance import DampedBackbone
from fenics_nnm.response.point import Judgement, ResponsePoint, Status
from fenics_nnm.response.structure import DrivenStructure


@dataclass(frozen=True, slots=True)
class CurveEnd:
    """Where a curve ends that does not reach from the lowest frequency to the highest one.

    Attributes:
        reason: Why.
        level: Factor of the forces.
    """

    reason: str
    level: float = 1.0

    def __str__(self) -> str:
        return f"level {self.level:g}, {self.reason}"


@dataclass(frozen=True, slots=True)
class Response:
    """Motions of a driven structure over frequency, level by level.

    Attributes:
        points: Its points: those of each level in the order of their curves.
        peaks: Peaks of the amplitudes, level by level.
        reasons: Why curves do not reach from the lowest frequency to the highest one.
        backbone: Motions in phase resonance; none if they were not asked for.
        instead: What the structure does where no stable motion is known.
    """

    points: tuple[ResponsePoint, ...]
    peaks: tuple[Peak, ...] = ()
    reasons: tuple[CurveEnd, ...] = ()
    backbone: DampedBackbone = field(default_factory=DampedBackbone)
    instead: tuple[Instead, ...] = ()

    def doubted(self, doubt: str) -> Response:
        """The same, where a doubt stands against all motions in contact."""
        points = tuple(point.doubted(doubt) for point in self.points)
        return replace(self, points=points, backbone=self.backbone.doubted(doubt))

    @property
    def missing(self) -> tuple[ResponsePoint, ...]:
        """Points without amplitudes."""
        return tuple(point for point in self.points if not point.found)

    @property
    def refuted(self) -> tuple[ResponsePoint, ...]:
        """Points with amplitudes that are no motions of the structure."""
        return tuple(point for point in self.points if point.refuted)

    @property
    def levels(self) -> tuple[float, ...]:
        """Levels in the order of the points."""
        of_points = [point.level for point in self.points]
        return tuple(dict.fromkeys([*of_points, *(each.level for each in self.reasons)]))

    def at_level(self, level: float) -> tuple[ResponsePoint, ...]:
        """Points of a level."""
        return tuple(point for point in self.points if point.level == level)

    def by_level(self) -> tuple[Response, ...]:
        """The response of each level, without the damped backbone."""
        return tuple(self.only((level,)) for level in self.levels)

    def only(self, levels: Sequence[float]) -> Response:
        """The response of some levels, without the damped backbone."""
        return Response(
            tuple(point for point in self.points if point.level in levels),
            tuple(peak for peak in self.peaks if peak.level in levels),
            tuple(reason for reason in self.reasons if reason.level in levels),
        )

    def followed_by(self, other: Response) -> Response:
        """The points, peaks and reasons of both, and the damped backbone of this one."""
        return replace(
            self,
            points=self.points + other.points,
            peaks=self.peaks + other.peaks,
            reasons=self.reasons + other.reasons,
        )


def response(
    structure: DrivenStructure,
    series: FourierSeries,
    frequencies: Array,
    levels: Sequence[float] = (1.0,),
    *,
    known: Response | None = None,
    on_level: Callable[[int, Response], None] = lambda number, found: None,
    on_progress: Callable[[float], None] = lambda part: None,
) -> Response:
    """Responses of a structure at some levels of its forces.

    Args:
        structure: Driven structure.
        series: Series in time.
        frequencies: Frequencies in Hz, ascending, shape (f,).
        levels: Factors of the forces.
        known: Levels that were found before, which are taken as they are.
        on_level: Called with the number of each level, from 0, and its response.
        on_progress: Called with the part that is done.

    Raises:
        ModelError: if a gap is not positive where contact points carry mass.
    """
    before = {level.levels[0]: level for level in known.by_level()} if known else {}
    found = Response(())
    for number, level in enumerate(levels):

        def report(part: float, before: int = number) -> None:
            on_progress((before + part) / len(levels))

        if (own := before.get(level)) is None:
            own = _of_level(
                _at_level(structure.at_level(level), series, frequencies, report), level
            )
        on_level(number, own)
        found = found.followed_by(own)
    return found


def _of_level(found: Response, level: float) -> Response:
    """A response as that of a level."""
    return Response(
        tuple(replace(each, level=level) for each in found.points),
        tuple(replace(each, level=level) for each in found.peaks),
        tuple(replace(each, level=level) for each in found.reasons),
    )


def _at_level(
    structure: DrivenStructure,
    series: FourierSeries,
    frequencies: Array,
    on_progress: Callable[[float], None],
) -> Response:
    """The response at one level."""
    others = structure.watched.before_contact
    if not _pressed(structure) and not (structure.bends and len(frequencies) > 1):
        opened = open_response(structure, series, frequencies, on_progress=on_progress)
        between = open_response(structure, series, resonances(structure, series, frequencies))
        if not any(each.status is Status.TOUCHES for each in (*opened, *between)):
            return Response(opened, tuple(open_peaks(structure, series, opened)))
        if structure.objection or len(frequencies) < 2:
            told = tuple(_with_reason(each, structure.objection) for each in opened)
            return Response(told, tuple(curve_peaks(told, others)))
    found = curve(structure, series, frequencies, on_progress=on_progress)
    reasons = (CurveEnd(found.reason),) if found.reason else ()
    return Response(found.points, tuple(curve_peaks(found.points, others)), reasons)


def resonances(structure: DrivenStructure, series: FourierSeries, frequencies: Array) -> Array:
    """Frequencies in Hz within a range at which a harmonic of a force meets a natural frequency.

    The largest motions that lie between the wanted frequencies are there, or next to there.
    """
    low, high = frequencies[[0, -1]]
    driving = np.array([n for n in structure.harmonics if n])
    natural = structure.natural / (2 * np.pi)
    met = np.unique(natural[:, None] / driving)
    return met[(met > low) & (met < high)]


def _pressed(structure: DrivenStructure) -> bool:
    """Whether contact points touch at rest, so that every motion has contact."""
    return structure.smallest_gap <= 0 and not structure.objection


def _with_reason(point: ResponsePoint, objection: str) -> ResponsePoint:
    """A point, with the reason why contact cannot be followed added to that it touches."""
    if point.status is not Status.TOUCHES or not objection:
        return point
    return replace(point, judgement=Judgement(point.status, f"{point.reason}: {objection}"))
