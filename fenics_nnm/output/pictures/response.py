"""The picture of a response: amplitude and phase over frequency, or over speed."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_nnm.arrays import Array
from fenics_nnm.output.pictures.style import (
    BLACK,
    CURVES,
    GREY,
    label,
    legend_below,
    new_figure,
    unit_for,
)
from fenics_nnm.response.levels import Response
from fenics_nnm.response.peaks import most_moved
from fenics_nnm.response.phase_resonance import DampedBackbone
from fenics_nnm.response.point import ResponsePoint

#: Phases at which the axis has ticks, in degrees.
_QUARTERS = (0, 90, 180, 270, 360)


def response_plot(monitors: Sequence[str], found: Response, title: str) -> Figure:
    """Amplitude and phase of all levels, of places that are watched; over speed where it is known.

    These are the excited and further places, and the contact point that moves most; with several
    levels the first of them alone. Unstable motions are dashed. Bands are frequencies without
    amplitudes.
    The damped backbone is that of the first place.
    """
    points, (along, name_along) = found.points, axis_of(found.points)
    figure = new_figure(height=4.6)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    unit = unit_for(np.array([point.amplitude for point in points]), "m")
    names = _names(monitors, points)
    for (colour, _), ((level, place), name) in zip(
        itertools.cycle(CURVES), names.items(), strict=False
    ):
        for own in curves_of(points, level):
            frequency, amplitude, phase = _columns(own, place)
            frequency *= along
            stable = np.array([each.judgement.stability in ("", "stable") for each in own])
            for axes, values in ((above, unit.factor * amplitude), (below, _without_jumps(phase))):
                axes.plot(frequency, values, ls="--", lw=0.8, color=colour)
                full = np.where(stable, values, np.nan)
                axes.plot(frequency, full, lw=1.4, color=colour, label=name)
            name = "_"
    _show_backbone(above, found.backbone, unit.factor, along)
    above.set_yscale("log")
    several = len({level for level, _ in names}) > 1
    label(above, "", f"amplitude{f' of {monitors[0]}' if several else ''}, 0-peak  ({unit.name})")
    label(below, name_along, "lag  (deg)")
    shown = [place for _, place in names]
    phases = np.array([point.phase[shown] for point in points])
    below.set_ylim(-5, 365 if np.nanmax(phases, initial=0.0) > 180.5 else 185)
    below.set_yticks([tick for tick in _QUARTERS if tick <= below.get_ylim()[1]])
    _show_missing((above, below), points, along)
    above.set_title(title, fontsize=9)
    legend_below(figure, above, columns=3)
    return figure


def axis_of(points: Sequence[ResponsePoint]) -> tuple[float, str]:
    """What is drawn along the axis per frequency in Hz, and its name: speeds where they are known.

    Speeds are proportional to frequencies.
    """
    first = points[0]
    turns = float(first.speed * 30 / np.pi / first.frequency)
    return (turns, "speed  (rpm)") if np.isfinite(turns) else (1.0, "frequency  (Hz)")


def _show_backbone(axes: Axes, backbone: DampedBackbone, factor: float, along: float) -> None:
    """Amplitudes of the first place in phase resonance, over everything else."""
    name = "damped backbone"
    for _, own in itertools.groupby(backbone.points, key=lambda each: each.point.branch):
        points = [each.point for each in own]
        frequency, amplitude, _ = _columns(points, 0)
        axes.plot(
            along * frequency, factor * amplitude, ":", color=BLACK, lw=1.2, zorder=3, label=name
        )
        name = "_"


def _names(
    monitors: Sequence[str], points: Sequence[ResponsePoint]
) -> dict[tuple[float, int], str]:
    """Names of what is drawn, by level and number of the place."""
    levels = list(dict.fromkeys(point.level for point in points))
    if len(levels) > 1:
        return {(level, 0): f"level {level:g}" for level in levels}
    every = range(len(monitors))
    others = len(monitors) - len(points[0].gap)
    places = (*every[:others], most_moved(points, every[others:]))
    return {(levels[0], place): monitors[place] for place in places}


def curves_of(points: Sequence[ResponsePoint], level: float) -> list[list[ResponsePoint]]:
    """Branches of a level."""
    own = [point for point in points if point.level == level]
    return [list(branch) for _, branch in itertools.groupby(own, key=lambda each: each.branch)]


def _columns(points: Sequence[ResponsePoint], place: int) -> tuple[Array, Array, Array]:
    """Frequencies, amplitudes and phases of a place."""
    return (
        np.array([point.frequency for point in points]),
        np.array([point.amplitude[place] for point in points]),
        np.array([point.phase[place] for point in points]),
    )


def _without_jumps(phase: Array) -> Array:
    """Phases with a break where they go round from 360 to 0 degrees."""
    broken = phase.copy()
    broken[1:][np.abs(np.diff(phase)) > 180] = np.nan
    return broken


def _show_missing(panels: Sequence[Axes], points: Sequence[ResponsePoint], along: float) -> None:
    """Bands where there are no amplitudes."""
    frequency = along * np.array([point.frequency for point in points])
    missing = np.array([not point.found for point in points])
    name = "touches, or not found"
    for number in np.flatnonzero(missing):
        edges = [
            (frequency[number] + frequency[beside]) / 2
            for beside in (max(number - 1, 0), min(number + 1, len(points) - 1))
        ]
        for axes in panels:
            axes.axvspan(*edges, color=GREY, alpha=0.3, lw=0, label=name)
        name = "_"
