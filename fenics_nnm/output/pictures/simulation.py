"""The picture of a simulation: envelope over time or frequency, and Poincare points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_nnm.output.pictures.style import CURVES, Unit, label, legend_below, new_figure, unit_for
from fenics_nnm.structure.simulated import Leg, Simulated

#: The last part of the periods, whose Poincare points are drawn.
_LAST = 0.5


def simulation_plot(names: Sequence[str], found: Simulated, title: str) -> Figure:
    """Envelope and Poincare points of the place that moves most.

    The envelope of a motion at constant frequency is drawn over the periods, that of a sweep over
    frequency; Poincare points are states at the start of each period, of the last half of them.
    """
    figure = new_figure(height=3.4)
    envelope, section = figure.subplots(1, 2, width_ratios=(3, 2))
    place = _most_moved(found)
    moved = np.concatenate([leg.found.of("largest")[:, place] for leg in _with_periods(found)])
    speed = np.concatenate(
        [leg.found.of("section_speed")[:, place] for leg in _with_periods(found)]
    )
    units = unit_for(moved, "m"), unit_for(speed, "m/s")
    for (colour, _), leg in zip(CURVES, _with_periods(found), strict=False):
        _show_envelope(envelope, leg, place, units[0], colour)
        _show_section(section, leg, place, units, colour)
    constant = found.legs[0].name == "constant"
    along = "periods  (1)" if constant else "frequency  (Hz)"
    label(envelope, along, f"envelope, {names[place]}  ({units[0].name})")
    label(section, f"displacement  ({units[0].name})", f"speed  ({units[1].name})")
    section.set_title("once a period", fontsize=9)
    section.locator_params(axis="x", nbins=4)
    envelope.set_title(title, fontsize=9)
    if not constant:
        legend_below(figure, envelope)
    return figure


def _with_periods(found: Simulated) -> list[Leg]:
    return [leg for leg in found.legs if leg.found.periods]


def _most_moved(found: Simulated) -> int:
    """Number of the place with the largest amplitude."""
    amplitudes = [leg.found.of("amplitude").max(axis=0) for leg in _with_periods(found)]
    return int(np.argmax(np.max(amplitudes, axis=0))) if amplitudes else 0


def _show_envelope(axes: Axes, leg: Leg, place: int, unit: Unit, colour: str) -> None:
    largest, least = (unit.factor * leg.found.of(n)[:, place] for n in ("largest", "least"))
    along = leg.found.of("frequency")
    if leg.name == "constant":
        along = np.arange(1.0, len(largest) + 1)
    axes.plot(along, largest, color=colour, lw=0.9, label=leg.name)
    axes.plot(along, least, color=colour, lw=0.9)


def _show_section(axes: Axes, leg: Leg, place: int, units: tuple[Unit, Unit], colour: str) -> None:
    first = int(len(leg.found.periods) * (1 - _LAST))
    moved = units[0].factor * leg.found.of("section")[first:, place]
    speed = units[1].factor * leg.found.of("section_speed")[first:, place]
    axes.plot(moved, speed, ".", color=colour, ms=2)
