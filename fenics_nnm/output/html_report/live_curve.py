"""The curve drawn in the page itself: the pointer over a point shows its numbers, without scripts.

Each mark has a title, which browsers show beside the pointer and which screen readers read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import CONVERGED, FAILED, RESONANT, VERIFIED, BranchPoint
from fenics_nnm.output.engine_orders import orders_near
from fenics_nnm.output.html_report.elements import Html, element, joined, text
from fenics_nnm.output.html_report.words import hardening, plain, signed
from fenics_nnm.output.pictures.amplitude import amplitude_of
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.results.tables import COLUMNS

#: Width and height of the drawing, and its margins: left, right, above, below. Letters of 12 are
#: read at 350 pixels across.
_SIZE, _MARGINS = (400, 290), (58, 12, 14, 46)

#: Energies that span more than this factor are drawn on a logarithmic axis.
_LOGARITHMIC = 30

#: Fewest and most steps of an axis.
_STEPS = 5

#: Columns of backbone.csv that a point shows besides, where they are known: words, factor, unit.
_FURTHER = {
    "von_mises_Pa": ("largest von Mises stress", 1e-6, "MPa"),
    "principal_Pa": ("largest principal stress", 1e-6, "MPa"),
    "yield_margin": ("yield strength over stress", 1.0, "(1)"),
}

#: What marks stand for.
_STATUSES = (VERIFIED, CONVERGED, RESONANT, FAILED)


@dataclass(frozen=True, slots=True)
class _Scale:
    """From values to places along an axis of the drawing.

    Attributes:
        low: Value at the beginning.
        high: Value at the end.
        begin: Place of the beginning.
        end: Place of the end.
        logarithmic: Whether factors of values are distances.
    """

    low: float
    high: float
    begin: float
    end: float
    logarithmic: bool = False

    def at(self, value: float) -> float:
        """Place of a value."""
        low, high = self.low, self.high
        if self.logarithmic:
            low, high, value = np.log(low), np.log(high), np.log(value)
        return float(self.begin + (value - low) / (high - low) * (self.end - self.begin))

    @property
    def ticks(self) -> list[float]:
        """Round values along it."""
        if self.logarithmic:
            decades = range(
                int(np.ceil(np.log10(self.low))), int(np.floor(np.log10(self.high))) + 1
            )
            return [10.0**decade for decade in decades]
        raw = (self.high - self.low) / _STEPS
        size = 10.0 ** np.floor(np.log10(raw))
        step = size * next(factor for factor in (1, 2, 5, 10) if factor * size >= raw)
        first = np.ceil(self.low / step)
        return [float(step * n) for n in np.arange(first, np.floor(self.high / step) + 1)]


def live_curve(results: Results) -> Html:
    """The frequency over the energy as a drawing in the page, with a title on each point."""
    points = results.points
    energy = np.array([point.motion.energy for point in points])
    hertz = np.array([point.motion.frequency for point in points])
    orders = orders_near(results.header.values, hertz)
    levels = [results.linear_frequency, *(order.frequency for order in orders)]
    across, up = _across(energy), _up(np.array([*hertz, *levels]))
    drawn = [
        *_axes(across, up),
        _level(across, up, results.linear_frequency, "linear mode", "linear"),
        *(_level(across, up, order.frequency, order.name, "order") for order in orders),
        *_lines(points, across, up),
        *_marks(results, across, up),
    ]
    width, height = _SIZE
    drawing = element(
        "svg",
        joined(drawn),
        viewBox=f"0 0 {width} {height}",
        role="img",
        aria_label="Frequency over energy; each point has its numbers",
    )
    caption = element(
        "figcaption",
        element("strong", text("Frequency over energy, point by point. ")),
        text(
            "Hold the pointer over a point to read its status, frequency, amplitude and contact. "
            f"{_legend(points)}"
        ),
    )
    return element("figure", drawing, caption, class_="live")


def _legend(points: Sequence[BranchPoint]) -> str:
    words = {
        VERIFIED: "filled: verified",
        CONVERGED: "ring: converged",
        RESONANT: "square: inside a resonance",
        FAILED: "cross: failed",
    }
    found = {point.status for point in points}
    return "; ".join(words[status] for status in _STATUSES if status in found).capitalize() + "."


def _across(energy: Array) -> _Scale:
    left, right, _, _ = _MARGINS
    low, high = float(energy.min()), float(energy.max())
    if low > 0 and high > _LOGARITHMIC * low:
        return _Scale(low / 1.3, high * 1.3, left, _SIZE[0] - right, logarithmic=True)
    return _Scale(*_with_room(low, high), left, _SIZE[0] - right)


def _up(hertz: Array) -> _Scale:
    _, _, above, below = _MARGINS
    return _Scale(*_with_room(float(hertz.min()), float(hertz.max())), _SIZE[1] - below, above)


def _with_room(low: float, high: float) -> tuple[float, float]:
    room = 0.06 * (high - low) or 0.05 * abs(high) or 1.0
    return low - room, high + room


def _axes(across: _Scale, up: _Scale) -> list[Html]:
    digits = max(4, int(np.ceil(np.log10(abs(up.high) / (up.high - up.low)))) + 3)
    drawn = [_line(across.begin, up.at(y), across.end, up.at(y), "grid") for y in up.ticks]
    drawn += [_line(across.at(x), up.begin, across.at(x), up.end, "grid") for x in across.ticks]
    drawn += [_words(across.begin - 5, up.at(y) + 4, f"{y:.{digits}g}", "end") for y in up.ticks]
    drawn += [_words(across.at(x), up.begin + 16, f"{x:.4g}", "middle") for x in across.ticks]
    middle = (across.begin + across.end) / 2
    drawn.append(_words(middle, _SIZE[1] - 8, "total energy (J)", "middle"))
    turned = f"rotate(-90 12 {(up.begin + up.end) / 2:g})"
    place = {"x": "12", "y": f"{(up.begin + up.end) / 2:g}"}
    drawn.append(
        element("text", text("frequency (Hz)"), text_anchor="middle", transform=turned, **place)
    )
    return drawn


def _level(across: _Scale, up: _Scale, hertz: float, name: str, kind: str) -> Html:
    """A horizontal line with its name; nothing beyond the drawing."""
    if not up.low <= hertz <= up.high:
        return Html("")
    line = _line(across.begin, up.at(hertz), across.end, up.at(hertz), kind)
    return joined([line, _words(across.end - 3, up.at(hertz) - 4, name, "end")])


def _lines(points: Sequence[BranchPoint], across: _Scale, up: _Scale) -> list[Html]:
    """Lines between neighbours of one family."""
    places = [(across.at(p.motion.energy), up.at(p.motion.frequency)) for p in points]
    return [
        _line(*places[n], *places[n + 1], "curve")
        for n, (one, other) in enumerate(pairwise(points))
        if one.family == other.family
    ]


def _marks(results: Results, across: _Scale, up: _Scale) -> list[Html]:
    amplitude = amplitude_of(results)
    return [
        _mark(
            across.at(point.motion.energy),
            up.at(point.motion.frequency),
            point.status,
            element("title", text(_numbers(point, f"{value:.4g} {amplitude.unit.name}"))),
        )
        for point, value in zip(results.points, amplitude.values, strict=True)
    ]


def _mark(x: float, y: float, status: str, title: Html) -> Html:
    kind = {VERIFIED: "verified", RESONANT: "inside", FAILED: "failed"}.get(status, "converged")
    if status == RESONANT:
        corner = {"x": f"{x - 4:.1f}", "y": f"{y - 4:.1f}", "width": "8", "height": "8"}
        return element("rect", title, class_=kind, **corner)
    if status == FAILED:
        cross = f"M{x - 4:.1f} {y - 4:.1f}l8 8m0 -8l-8 8"
        return element("path", title, class_=kind, d=cross)
    return element("circle", title, class_=kind, cx=f"{x:.1f}", cy=f"{y:.1f}", r="4.5")


def _numbers(point: BranchPoint, amplitude: str) -> str:
    """What is known of a point, a line each."""
    motion = point.motion
    lines = [
        f"{point.status}" + (f": {point.reason}" if point.reason else ""),
        f"frequency {motion.frequency:.7g} Hz ({signed(hardening(point))} %)",
        f"energy {plain(motion.energy)} J, gamma ratio {point.gamma_ratio:.4g}",
        f"largest displacement {amplitude}",
        f"contact {100 * motion.contact_fraction:.3g} % of the period, "
        f"{plain(motion.force.sum(axis=1).max(initial=0.0))} N in all",
    ]
    for name, (words, factor, unit) in _FURTHER.items():
        printed = COLUMNS[name].printed(point)
        if printed:  # stress is not known of matrices
            lines.append(f"{words} {factor * float(printed):.4g} {unit}")
    return "\n".join(lines)


def _line(x: float, y: float, to_x: float, to_y: float, kind: str) -> Html:
    ends = {"x1": f"{x:.1f}", "y1": f"{y:.1f}", "x2": f"{to_x:.1f}", "y2": f"{to_y:.1f}"}
    return element("line", class_=kind, **ends)


def _words(x: float, y: float, words: str, anchor: str) -> Html:
    return element("text", text(words), x=f"{x:.1f}", y=f"{y:.1f}", text_anchor=anchor)
