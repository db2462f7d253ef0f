"""Pictures of a sweep: all backbones, and the frequency over a swept number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fenics_nnm.backbone.point import FAILED, RESONANT
from fenics_nnm.output.pictures.style import (
    BLUE,
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
    shades,
)
from fenics_nnm.sweep.outcome import Outcome
from fenics_nnm.sweep.plan import Plan
from fenics_nnm.sweep.variation import Variation, variations

#: Formats of the pictures.
FORMATS = ("png", "svg")

#: Linear frequencies that differ by more than this part are of different modes or bodies.
_SAME_FREQUENCY = 1e-6

#: Values that span more than this factor are drawn on a logarithmic axis.
_LOGARITHMIC = 30

#: Of more values than this the legend shows a few.
_MOST_ENTRIES = 10

#: Least height of an axis, as a part of the frequency, so that it does not show round-off.
_LEAST_SPAN = 1e-3

#: Width of curves in points. Over the gamma ratio those of the first value are thicker by `_NESTED`
#: than those of the last one, where values are few, so that all show where they coincide.
_THIN, _NESTED, _FEW = 1.1, 3.0, 6

_STYLES = ("-", "--", "-.", ":")
_MARKERS = ("o", "s", "^", "D", "v", "P")

#: What the first three keys that vary change of a curve.
_ARGUMENTS = ("color", "ls", "marker")

#: Marks of points that are not to be trusted, drawn on top of the curves.
_MARKS = ((RESONANT, "s", PURPLE), (FAILED, "X", RED))

Looks = list[dict[str, Any]]
"""Colour, line and marker of each value of the first three keys that vary."""


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
    figures = _figures(plan, outcomes, title)
    for name in {"sweep", "sweep_values"} - figures.keys():
        for kind in FORMATS:  # of an earlier sweep of other keys
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
    looks = _looks(keys)
    for index, outcome in enumerate(outcomes):
        if outcome.rows:
            scale = 1 / (outcome.linear_frequency or 1.0)
            width = _width(keys[0], index) if keys else _THIN
            for row, factor in zip(panels, (1.0, scale), strict=False):
                _draw(row, outcome, factor, width, _looks_of(index, keys, looks))
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
    _legend(figure, keys, looks, outcomes)
    missing = sum(not outcome.complete for outcome in outcomes)
    heading = (
        f"{title}\n{missing} of {len(outcomes)} studies are not complete" if missing else title
    )
    figure.suptitle(heading, fontsize=10)
    return figure


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


def _looks(keys: Sequence[Variation]) -> Looks:
    """What each value of the first three keys looks like; values beyond begin anew."""
    found: Looks = []
    for place, key in enumerate(keys[: len(_ARGUMENTS)]):
        kinds: Sequence[Any] = (_colours(key), _STYLES, _MARKERS)[place]
        found.append({name: kinds[i % len(kinds)] for i, name in enumerate(key.levels)})
    return found


def _looks_of(index: int, keys: Sequence[Variation], looks: Looks) -> dict[str, Any]:
    """Arguments of `plot` for a study, by its place in the plan."""
    chosen = {"color": BLUE, "ls": "-", "marker": ".", "ms": 3}
    for argument, key, kinds in zip(_ARGUMENTS, keys, looks, strict=False):
        chosen[argument] = kinds[key.names[index]]
    return chosen


def _colours(key: Variation) -> Sequence[Any]:
    """Colours from dark to light of numbers, colours that differ most of other values."""
    many = key.numeric or len(key.levels) > len(CURVES)
    return list(shades(len(key.levels))) if many else [colour for colour, _ in CURVES]


def _legend(
    figure: Figure, keys: Sequence[Variation], looks: Looks, outcomes: Sequence[Outcome]
) -> None:
    """Below all axes: one key in lines from left to right, several in columns of their own."""
    columns = [
        [_handle(name, **{argument: kinds[name]}) for name in _some(key.levels)]
        for argument, key, kinds in zip(_ARGUMENTS, keys, looks, strict=False)
    ]
    titles = [key.label for key in keys[: len(columns)]]
    statuses = {row.status for outcome in outcomes for row in outcome.rows}
    marks = [
        _handle(status, ls="", marker=marker, mfc="white", mec=colour)
        for status, marker, colour in _MARKS
        if status in statuses
    ]
    if marks:
        columns, titles = [*columns, marks], [*titles, "points"]
    alike = ", ".join(key.label for key in keys[len(_ARGUMENTS) :])
    only = columns[0] if len(columns) == 1 else None
    figure.legend(
        handles=only or _in_columns(columns, titles),
        loc="outside lower center",
        ncols=min(5, len(only)) if only else max(1, len(columns)),
        fontsize=8,
        title=titles[0] if only else f"the same colour: {alike}" if alike else None,
        title_fontsize=8,
        frameon=False,
    )


def _in_columns(columns: Sequence[Sequence[Line2D]], titles: Sequence[str]) -> list[Line2D]:
    """Entries of a legend that is filled column by column, each with its title on top."""
    height = max((len(column) for column in columns), default=0)
    return [
        handle
        for title, column in zip(titles, columns, strict=True)
        for handle in (
            _handle(title, ls=""),
            *column,
            *(_handle(" ", ls="") for _ in range(height - len(column))),
        )
    ]


def _handle(name: str, **looks: Any) -> Line2D:
    return Line2D([], [], label=name, **{"color": GREY, "lw": 1.4, "ms": 4, **looks})


def _some(levels: Sequence[str]) -> list[str]:
    """All values, or evenly spread ones where they are many."""
    if len(levels) <= _MOST_ENTRIES:
        return list(levels)
    chosen = np.unique(np.linspace(0, len(levels) - 1, _MOST_ENTRIES).round().astype(int))
    return [levels[index] for index in chosen]


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
    if values.min() > 0 and values.max() > _LOGARITHMIC * values.min():
        axes.set_xscale("log")
    low, high = axes.get_ylim()
    middle, half = (low + high) / 2, _LEAST_SPAN * (low + high) / 4
    axes.set_ylim(min(low, middle - half), max(high, middle + half))
    label(axes, key.label, "frequency  (Hz)")
    legend_below(figure, axes, columns=3)
    figure.suptitle(title, fontsize=10)
    return figure
