"""The picture of a Campbell diagram: frequencies over speed with engine orders, and the gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fenics_nnm.arrays import Array
from fenics_nnm.output.campbell_crossings import Met, NonlinearLine, borne, nonlinear_lines
from fenics_nnm.output.pictures.style import (
    BLACK,
    CURVES,
    GREY,
    label,
    legend_below,
    new_figure,
    unit_for,
)
from fenics_nnm.structure.campbell import AtSpeed
from fenics_nnm.structure.motions_at_speed import Target


def campbell_plot(
    points: Sequence[AtSpeed],
    crossings: Sequence[Met],
    orders: Sequence[int],
    title: str,
    *,
    turns: bool = False,
    lobes: Sequence[int] = (),
) -> Figure:
    """Frequencies of all lines over speed, engine orders with their crossings; the gap beside it.

    Nonlinear lines lie near their linear mode: how far they are from it has a panel of its own.

    Args:
        points: The body at each speed; some with a static state.
        crossings: Where engine orders meet lines.
        orders: Engine orders.
        title: Title.
        turns: Whether speeds are shown in turns per minute.
        lobes: Orders that are those of lobes that pass: the diagram is an interaction map.
    """
    found, unit = borne(points), 30 / np.pi if turns else 1.0
    speed = unit * np.array([point.speed for point in found])
    lines, nonlinear = np.array([point.frequencies for point in found]).T, nonlinear_lines(points)
    figure = new_figure(height=4.0, width=8.6 if nonlinear else 6.4)
    left, *middle, right = figure.subplots(
        1, 3 if nonlinear else 2, width_ratios=(2.4, 1.3, 1) if nonlinear else (2.4, 1)
    )
    _draw_linear(left, speed, lines)
    _draw(left, speed, nonlinear)
    shown = [lines.ravel(), *(line.frequency for line in nonlinear)]
    top = 1.05 * float(np.nanmax(np.concatenate(shown)))
    names = {order: f"{order} lobes" if order in lobes else f"{order}" for order in orders}
    _draw_orders(left, names, float(speed.max()), top, turn=2 * np.pi * unit)
    what = "lobes x speed" if lobes else "engine order"
    _draw_crossings(left, crossings, unit, f"{what} meets a line")
    left.set_ylim(0, top)
    name = "speed  (rpm)" if turns else "speed  (rad/s)"
    label(left, name, "frequency  (Hz)")
    for axes in middle:
        _draw_changes(axes, speed, lines, nonlinear, name)
    _draw_gap(right, speed, np.array([point.gap for point in found]), name)
    left.set_title(title, fontsize=9)
    legend_below(figure, left, columns=4)
    return figure


def _draw_linear(axes: Axes, speed: Array, lines: Array) -> None:
    """Linear modes, each in a colour of its own."""
    for mode, line in enumerate(lines):
        colour, _ = CURVES[mode % len(CURVES)]
        axes.plot(speed, line, color=colour, lw=1.3, marker=".", ms=3, label=f"mode {mode + 1}")


def _draw_orders(
    axes: Axes, names: Mapping[int, str], fastest: float, top: float, *, turn: float
) -> None:
    """Engine orders as far as the picture goes; `turn` is the shown speed of a turn a second."""
    for order, name in names.items():
        end = min(fastest, top * turn / order)
        axes.plot([0, end], [0, order * end / turn], color=GREY, lw=0.8, ls="--")
        axes.annotate(name, (end, order * end / turn), fontsize=7, color=GREY)


def _draw_crossings(axes: Axes, crossings: Sequence[Met], unit: float, name: str) -> None:
    """Where orders meet lines; `unit` is the shown speed of 1 rad/s."""
    speed = [unit * each.speed for each in crossings]
    frequency = [each.frequency for each in crossings]
    axes.plot(speed, frequency, "o", mfc="none", color=BLACK, ms=5, label=name)


def _draw_gap(axes: Axes, speed: Array, gaps: Array, name: str) -> None:
    """Smallest gap over speed."""
    length = unit_for(gaps, "m")
    axes.plot(speed, length.factor * gaps, color=BLACK, lw=1.3, marker=".", ms=3)
    label(axes, name, f"smallest gap  ({length.name})")
    axes.xaxis.set_major_locator(MaxNLocator(nbins=3))


def _draw(axes: Axes, speed: Array, lines: Sequence[NonlinearLine]) -> None:
    """Nonlinear lines in the colour of their mode, each with a marker of its own."""
    for number, line in enumerate(lines):
        colour, _ = CURVES[(line.mode - 1) % len(CURVES)]
        _, marker = CURVES[number % len(CURVES)]
        name = f"mode {line.mode}, {_named(line.target)}"
        axes.plot(speed, line.frequency, color=colour, lw=0.9, marker=marker, ms=3.5, label=name)


def _draw_changes(
    axes: Axes, speed: Array, linear: Array, lines: Sequence[NonlinearLine], name: str
) -> None:
    """How far nonlinear lines are from their linear modes, in per cent, over speed."""
    for number, line in enumerate(lines):
        colour, _ = CURVES[(line.mode - 1) % len(CURVES)]
        _, marker = CURVES[number % len(CURVES)]
        change = 100 * (line.frequency / linear[line.mode - 1] - 1)
        axes.plot(speed, change, color=colour, lw=0.9, marker=marker, ms=3.5)
    label(axes, name, "change from the linear mode  (%)")
    axes.xaxis.set_major_locator(MaxNLocator(nbins=4))


def _named(target: Target) -> str:
    unit = unit_for(np.array([target.value]), target.quantity.unit)
    return f"{unit.factor * target.value:g} {unit.name}"
