"""Blade sections as two smooth lines with blunt ends."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.sections import Section

MOST_EDGE_CUT = 0.03
"""Largest fraction of the mean line that may be left out at an edge."""

_EDGE_LENGTH = 0.05  # fraction of the mean line that gives its direction at an edge

_Line = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, slots=True)
class SectionLines:
    """The two sides of a section, sampled alike, in Cartesian coordinates.

    Attributes:
        parameter: From 0 to 1 along each side, shape (n,); the same for all sections.
        sides: Points of the two sides, shape (2, n, 3), in the unit of the section.
    """

    parameter: np.ndarray
    sides: np.ndarray


def section_lines(section: Section, *, edge_cut: float, count: int) -> SectionLines:
    """Sample both sides of a section between two cuts across its mean line.

    Each cut lies at `edge_cut` times the length of the mean line behind the foremost point of
    that edge. The mean line has the mean angle of the two sides at each (z, r) of the table;
    sides are monotone cubics of its arc length, sampled more densely towards the edges.

    Args:
        section: The section.
        edge_cut: Fraction of the mean line, at most `MOST_EDGE_CUT`.
        count: Number of points along each side.

    Raises:
        GeometryError: Points repeat, or the sides touch or cross between the cuts.
    """
    along = _along_mean_line(section)
    _check_thickness(section, along, edge_cut)
    mean = _line(section, along, section.theta.mean(axis=1))
    sides = [_line(section, along, theta) for theta in section.theta.T]
    starts = _cut_stations(mean, sides, edge_cut)
    ends = [1 - s for s in _cut_stations(_reverse(mean), [_reverse(s) for s in sides], edge_cut)]
    parameter = 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, count)))
    points = [
        side(start + (end - start) * parameter)
        for side, start, end in zip(sides, starts, ends, strict=True)
    ]
    return SectionLines(parameter, np.stack(points))


def cartesian(axial: np.ndarray, radius: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Points (x, y, z) = (axial, r sin theta, r cos theta), stacked on a last axis."""
    return np.stack([axial, radius * np.sin(theta), radius * np.cos(theta)], axis=-1)


def _along_mean_line(section: Section) -> np.ndarray:
    """Arc length of the mean line at the table points over its whole length."""
    mean = cartesian(section.axial, section.radius, section.theta.mean(axis=1))
    steps = np.linalg.norm(np.diff(mean, axis=0), axis=1)
    if steps.min() <= 1e-9 * steps.sum():
        row = int(steps.argmin()) + 1
        raise GeometryError(f"section {section.number}: points {row} and {row + 1} are the same")
    return np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()


def _check_thickness(section: Section, along: np.ndarray, edge_cut: float) -> None:
    """Refuse a section whose two sides touch or cross between the cuts."""
    inside = (along > edge_cut) & (along < 1 - edge_cut)
    angle = (section.theta[:, 0] - section.theta[:, 1])[inside]
    if angle.size and angle.min() <= 0:
        place = along[inside][angle.argmin()]
        raise GeometryError(
            f"section {section.number}: theta1_rad and theta2_rad touch or cross at {place:.1%} "
            "of the mean line; correct the table or raise edge_cut"
        )


def _line(section: Section, along: np.ndarray, theta: np.ndarray) -> _Line:
    """Line at the angles `theta`: fraction of the mean line to Cartesian points."""
    cylindrical = PchipInterpolator(along, np.column_stack([section.axial, section.radius, theta]))

    def points(stations: np.ndarray) -> np.ndarray:
        return cartesian(*cylindrical(stations).T)

    return points


def _reverse(line: _Line) -> _Line:
    """The same line from its other end."""
    return lambda stations: line(1 - stations)


def _cut_stations(mean: _Line, sides: list[_Line], edge_cut: float) -> list[float]:
    """Fractions of the mean line at which each side last crosses the cut at its start."""
    first, inner = mean(np.array([0.0, _EDGE_LENGTH]))
    direction = (inner - first) * _EDGE_LENGTH / np.sum((inner - first) ** 2)
    stations = np.linspace(0, 2 * _EDGE_LENGTH, 2001)
    depths = [(side(stations) - first) @ direction for side in sides]
    cut = min(depth.min() for depth in depths) + edge_cut
    return [_last_crossing(stations, depth - cut) for depth in depths]


def _last_crossing(stations: np.ndarray, values: np.ndarray) -> float:
    """Where the piecewise linear values last turn from negative to positive."""
    last = int(np.flatnonzero(values < 0)[-1]) if values.min() < 0 else -1
    if last in (-1, len(values) - 1):
        return float(stations[last + 1 if last == -1 else last])
    below, above = values[last], values[last + 1]
    return float(stations[last] + (stations[last + 1] - stations[last]) * below / (below - above))
