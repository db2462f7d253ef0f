"""Pictures of a sweep: all backbones, and the frequency over a swept number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import FAILED, RESONANT
from fenics_nnm.output.pictures.style import (
    CURVES,
    GAMMA,
    GREY,
    PURPLE,
    RED,
    label,
    legend_below,
    new_axes,
    new_figure,
    save,
)
from fenics_nnm.sweep.case import Outcome, Plan
from fenics_nnm.sweep.looks import handle, legend, looks, looks_of
from fenics_nnm.sweep.variation import Variation, variations

#: Formats of the pictures.
FORMATS = ("png", "svg")

#: Linear frequencies that differ by more than this part are of different modes or bodies.
_SAME_FREQUENCY = 1e-6

#: Values that span more than this factor are drawn on a logarithmic axis.
_LOGARITHMIC = 30

#: Least height of an axis, as a part of the frequency, so that it does not show round-off.
_LEAST_SPAN = 1e-3

#: Width of curves in points. Over the gamma ratio those of the first value are thicker by `_NESTED`
#: than those of the last one, where values are few, so that all show where they coincide.
_THIN, _NESTED, _FEW = 1.1, 3.0, 6

#: Marks of points that are not to be trusted, drawn on top of the curves.
_MARKS = ((RESONANT, "s", PURPLE), (FAILED, "X", RED))


def draw_sweep(plan: Plan, outcomes: Sequence[Outcome], title: str) -> list[str]:
    """Draw the backbones of a sweep, and the frequency over the key if one number is swept.

    Args:
        plan: The sweep.
        outcomes: What its studies gave, in their order.
        title: Title of the study.

    Returns:
        Names of the files in the folder of the sweep; none if no study has points.

    Raises:
        OSError: if they cannot be written.
    """
    return write_figures(plan, _figures(plan, outcomes, title))


def write_figures(plan: Plan, figures: Mapping[str, Figure]) -> list[str]:
    """Write figures by the names of their files; those of an earlier sweep of other keys go.

    Raises:
        OSError: if they cannot be written.
    """
    for name in {"sweep", "sweep_values"} - figures.keys():
        for kind in FORMATS:
            (plan.folder / f"{name}.{kind}").unlink(missing_ok=True)
    return [
        file
        for name, figure in figures.items()
        for file in save(figure, plan.folder, name, FORMATS)
    ]


def _figures(plan: Plan, outcomes: Sequence[Outcome], title: str) -> dict[str, Figure]:
    """Figures by the names of their files."""
    if not any(outcome.rows for outcome in outcomes):
        return {}
    keys = variations(plan)
    figures = {"sweep": _backbones(outcomes, keys, title)}
    ratios = [ratio for ratio in plan.ratios if any(each.at(ratio) for each in outcomes)]
    if len(keys) == 1 and keys[0].numeric and ratios:
        figures["sweep_values"] = _over_value(outcomes, keys[0], ratios, title)
    return figures


def _backbones(outcomes: Sequence[Outcome], keys: Sequence[Variation], title: str) -> Figure:
    """Frequency over gamma ratio and energy; over the linear one too where that differs."""
    linear = np.array([each.linear_frequency for each in outcomes if each.rows])
    rows = 2 if np.ptp(linear) > _SAME_FREQUENCY * linear.min() else 1
    figure = new_figure(4.6 + 2.6 * (rows - 1), 9.0)
    panels = figure.subplots(rows, 2, sharex="col", sharey="row", squeeze=False)
    kinds_of = looks(keys)
    for index, outcome in enumerate(outcomes):
        if outcome.rows:
            scale = 1 / (outcome.linear_frequency or 1.0)
            width = _width(keys[0], index) if keys else _THIN
            for row, factor in zip(panels, (1.0, scale), strict=False):
                _draw(row, outcome, factor, width, looks_of(index, keys, kinds_of))
    energies = [row.energy for outcome in outcomes for row in outcome.rows]
    names = ("frequency  (Hz)", "frequency over\nlinear frequency  (1)")
    for row, name in zip(panels, names, strict=False):
        row[0].axvline(1, color=GREY, lw=0.8, ls=":")
        if min(energies) > 0 and max(energies) > _LOGARITHMIC * min(energies):
            row[1].set_xscale("log")
        label(row[0], "", name)
        label(row[1], "", "")
    panels[-1][0].set_xlabel(GAMMA, fontsize=9)
    panels[-1][1].set_xlabel("total energy  (J)", fontsize=9)
    legend(figure, keys, kinds_of, _marks(outcomes))
    figure.suptitle(heading(outcomes, title), fontsize=10)
    return figure


def heading(outcomes: Sequence[Outcome], title: str) -> str:
    """Title of a picture, with the number of studies that are not complete."""
    missing = sum(not outcome.complete for outcome in outcomes)
    return f"{title}\n{missing} of {len(outcomes)} studies are not complete" if missing else title


def _marks(outcomes: Sequence[Outcome]) -> list[Line2D]:
    statuses = {row.status for outcome in outcomes for row in outcome.rows}
    return [
        handle(status, ls="", marker=marker, mfc="white", mec=colour)
        for status, marker, colour in _MARKS
        if status in statuses
    ]


def _draw(
    row: Sequence[Axes], outcome: Outcome, factor: float, width: float, looks: dict[str, Any]
) -> None:
    y = factor * np.array([row.frequency for row in outcome.rows])
    for axes, name, lw in zip(row, ("gamma_ratio", "energy"), (width, _THIN), strict=True):
        x = np.array([getattr(row, name) for row in outcome.rows])
        axes.plot(x, y, lw=lw, **looks)
        for status, marker, colour in _MARKS:
            chosen = np.array([row.status == status for row in outcome.rows])
            axes.plot(x[chosen], y[chosen], marker, ms=4, mfc="white", mec=colour, zorder=3)


def _width(key: Variation, index: int) -> float:
    """Width of the curve of a study over the gamma ratio."""
    levels = key.levels
    last = len(levels) - 1
    nested = 0 < last < _FEW
    return _THIN + (_NESTED * (1 - levels.index(key.names[index]) / last) if nested else 0.0)


def _over_value(
    outcomes: Sequence[Outcome], key: Variation, ratios: Sequence[float], title: str
) -> Figure:
    """Frequency at some gamma ratios over the swept number."""
    figure = new_figure(3.7)
    axes = new_axes(figure, key.label, "frequency  (Hz)")
    values = np.array(key.values, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    linear = np.array([each.linear_frequency or np.nan for each in outcomes])
    axes.plot(values[order], linear[order], "-", color=GREY, lw=0.8, label="linear mode")
    for number, ratio in enumerate(ratios):
        colour, marker = CURVES[number % len(CURVES)]
        rows = [outcome.at(ratio) for outcome in outcomes]
        found = np.array([row.frequency if row else np.nan for row in rows])
        axes.plot(
            values[order],
            found[order],
            marker=marker,
            ms=4,
            lw=1.1,
            color=colour,
            label=f"gamma ratio {ratio:g}",
        )
    scale_of_values(axes, values)
    low, high = axes.get_ylim()
    middle, half = (low + high) / 2, _LEAST_SPAN * (low + high) / 4
    axes.set_ylim(min(low, middle - half), max(high, middle + half))
    label(axes, key.label, "frequency  (Hz)")
    legend_below(figure, axes, columns=3)
    figure.suptitle(title, fontsize=10)
    return figure


def scale_of_values(axes: Axes, values: Array) -> None:
    """A logarithmic axis for swept numbers that span orders of magnitude."""
    if values.min() > 0 and values.max() > _LOGARITHMIC * values.min():
        axes.set_xscale("log")
