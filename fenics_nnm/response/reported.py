"""Motions of a response that files are wanted of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fenics_nnm.response.levels import Response
from fenics_nnm.response.peak_events import PEAK
from fenics_nnm.response.point import ResponsePoint

#: Frequencies that differ by less than this part are the same.
_SAME = 1e-9


def reported(found: Response, frequencies: Sequence[float]) -> tuple[int, ...]:
    """Numbers of the motions at some frequencies, or else of the highest peak of each level.

    Args:
        found: Response.
        frequencies: Frequencies in Hz; all motions that it has there are taken.
    """
    if not frequencies:
        return tuple(_highest_peaks(found))
    return tuple(
        number
        for number, point in enumerate(found.points)
        if point.found and any(abs(point.frequency / each - 1) < _SAME for each in frequencies)
    )


def absent(found: Response, frequencies: Sequence[float]) -> Iterator[str]:
    """Frequencies in Hz at which a level has no motion, a line each."""
    for level in found.levels:
        own = [point.frequency for point in found.at_level(level) if point.found]
        for each in frequencies:
            if not any(abs(frequency / each - 1) < _SAME for frequency in own):
                yield f"level {level:g} has no motion at {each:.6g} Hz to report"


def nearest(found: Response, frequency: float, levels: Sequence[float]) -> tuple[int, ...]:
    """Numbers of the motions nearest to a frequency, of each of some levels.

    Several that a curve has there are taken, each.
    """
    numbers: list[int] = []
    for level in levels:
        own = [n for n, p in enumerate(found.points) if p.level == level and p.found]
        near = min((_apart(found.points[n], frequency) for n in own), default=0.0)
        numbers += [n for n in own if _apart(found.points[n], frequency) <= near + _SAME]
    return tuple(numbers)


def _apart(point: ResponsePoint, frequency: float) -> float:
    return abs(point.frequency / frequency - 1)


def _highest_peaks(found: Response) -> Iterator[int]:
    """The point of each level with the largest amplitude of the first place; a located one first.

    Without contact peaks lie between the points.
    """
    for level in found.levels:
        own = [
            number
            for number, point in enumerate(found.points)
            if point.level == level and point.found and not point.refuted
        ]
        own = [n for n in own if found.points[n].event == PEAK] or own
        yield from sorted(own, key=lambda n: -found.points[n].amplitude[0])[:1]
