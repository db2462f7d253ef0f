"""Pictures of a sweep of responses: all curves, and their peaks over a swept number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_nnm.output.pictures.response import axis_of, curves_of
from fenics_nnm.output.pictures.style import CURVES, label, legend_below, new_figure, unit_for
from fenics_nnm.sweep.case import Outcome, Plan
from fenics_nnm.sweep.levels import largest_peak, levels
from fenics_nnm.sweep.looks import legend, looks, looks_of
from fenics_nnm.sweep.pictures import heading, scale_of_values, write_figures
from fenics_nnm.sweep.variation import Variation, variations

#: The picture shows this many levels, the largest ones.
_MOST_LEVELS = 6


def draw_responses(plan: Plan, outcomes: Sequence[Outcome], title: str) -> list[str]:
    """Draw the responses of a sweep, and their peaks over the key if one number is swept.

    Args:
        plan: The sweep.
        outcomes: What its studies gave, in their order.
        title: Title of the study.

    Returns:
        Names of the files in the folder of the sweep; none if no study has motions.

    Raises:
        OSError: if they cannot be written.
    """
    if not any(outcome.points for outcome in outcomes):
        return write_figures(plan, {})
    keys = variations(plan)
    figures = {"sweep": _curves(plan, outcomes, keys, title)}
    peaks = [peak for each in outcomes for peak in each.response.peaks if peak.monitor == 0]
    if len(keys) == 1 and keys[0].numeric and peaks:
        figures["sweep_values"] = _over_value(plan, outcomes, keys[0], title)
    return write_figures(plan, figures)


def _curves(
    plan: Plan, outcomes: Sequence[Outcome], keys: Sequence[Variation], title: str
) -> Figure:
    """Amplitude of the first place that is watched over frequency, a panel for each level."""
    shown = levels(plan)[-_MOST_LEVELS:]
    rows, columns = -(-len(shown) // 2), min(2, len(shown))
    figure = new_figure(1.2 + 2.8 * rows, 4.6 * columns)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    every = [p.amplitude[0] for each in outcomes for p in each.response.points if p.found]
    unit = unit_for(np.array(every), "m")
    points = [point for each in outcomes for point in each.response.points]
    along, name_along = axis_of(points)
    kinds_of = looks(keys)
    for axes, level in zip(panels.flat, shown, strict=False):
        for index, outcome in enumerate(outcomes):
            _draw(axes, outcome, level, (along, unit.factor), looks_of(index, keys, kinds_of))
        axes.set_yscale("log")
        label(axes, name_along, f"amplitude, 0-peak  ({unit.name})")
        axes.set_title(f"level {level:g}", fontsize=9)
    for axes in panels.flat[len(shown) :]:
        axes.set_axis_off()
    legend(figure, keys, kinds_of)
    figure.suptitle(heading(outcomes, title), fontsize=10)
    return figure


def _draw(
    axes: Axes, outcome: Outcome, level: float, factors: tuple[float, float], look: dict[str, Any]
) -> None:
    """The curves of a study at a level; unstable motions, and those that failed, are thin."""
    for own in curves_of(outcome.response.points, level):
        x = factors[0] * np.array([point.frequency for point in own])
        y = factors[1] * np.array([point.amplitude[0] for point in own])
        good = np.array([p.judgement.stability in ("", "stable") and not p.refuted for p in own])
        style = {**look, "marker": ""}
        axes.plot(x, y, lw=0.6, **style)
        axes.plot(x, np.where(good, y, np.nan), lw=1.4, **style)


def _over_value(plan: Plan, outcomes: Sequence[Outcome], key: Variation, title: str) -> Figure:
    """Frequency and amplitude of the largest peak of each level over the swept number."""
    figure = new_figure(5.2)
    above, below = figure.subplots(2, 1, sharex=True)
    order = np.argsort(np.array(key.values, dtype=np.float64), kind="stable")
    values = np.array(key.values, dtype=np.float64)[order]
    found = {
        level: [largest_peak(outcomes[each].response, level) for each in order]
        for level in levels(plan)
    }
    amplitudes = [peak.amplitude for own in found.values() for peak in own if peak]
    unit = unit_for(np.array(amplitudes), "m")
    for number, (level, own) in enumerate(found.items()):
        colour, marker = CURVES[number % len(CURVES)]
        frequency = np.array([peak.frequency if peak else np.nan for peak in own])
        amplitude = np.array([peak.amplitude if peak else np.nan for peak in own])
        for axes, y in ((above, frequency), (below, unit.factor * amplitude)):
            axes.plot(
                values, y, color=colour, marker=marker, ms=4, lw=1.1, label=f"level {level:g}"
            )
    scale_of_values(above, values)
    label(above, "", "frequency of the peak  (Hz)")
    label(below, key.label, f"amplitude of the peak  ({unit.name})")
    legend_below(figure, above, columns=3)
    figure.suptitle(title, fontsize=10)
    return figure
