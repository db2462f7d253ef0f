"""The picture of a response: amplitude and phase over frequency."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_nnm.output.pictures.style import CURVES, GREY, label, legend_below, new_figure, unit_for
from fenics_nnm.response.driven import ResponsePoint
from fenics_nnm.response.peaks import most_moved

#: Phases at which the axis has ticks, in degrees.
_QUARTERS = (0, 90, 180, 270, 360)


def response_plot(monitors: Sequence[str], points: Sequence[ResponsePoint], title: str) -> Figure:
    """Amplitude and phase of the excited points, and of the contact point that moves most.

    Bands are frequencies without amplitudes.
    """
    figure = new_figure(height=4.6)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    frequency = np.array([point.frequency for point in points])
    amplitude = np.array([point.amplitude for point in points])
    phase = np.array([point.phase for point in points])
    unit = unit_for(amplitude, "m")
    every = range(len(monitors))
    excited = len(monitors) - len(points[0].gap)
    for (colour, _), each in zip(
        CURVES, (*every[:excited], most_moved(points, every[excited:])), strict=False
    ):
        style = {"color": colour, "lw": 1.2}
        above.plot(frequency, unit.factor * amplitude[:, each], label=monitors[each], **style)
        below.plot(frequency, _without_jumps(phase[:, each]), **style)
    above.set_yscale("log")
    label(above, "", f"amplitude, 0-peak  ({unit.name})")
    label(below, "frequency  (Hz)", "lag  (deg)")
    below.set_ylim(-5, 365 if np.nanmax(phase, initial=0.0) > 180.5 else 185)
    below.set_yticks([tick for tick in _QUARTERS if tick <= below.get_ylim()[1]])
    _show_missing((above, below), points)
    above.set_title(title, fontsize=9)
    legend_below(figure, above, columns=3)
    return figure


def _without_jumps(phase: np.ndarray) -> np.ndarray:
    """Phases with a break where they go round from 360 to 0 degrees."""
    broken = phase.copy()
    broken[1:][np.abs(np.diff(phase)) > 180] = np.nan
    return broken


def _show_missing(panels: Sequence[Axes], points: Sequence[ResponsePoint]) -> None:
    """Bands where there are no amplitudes."""
    frequency = np.array([point.frequency for point in points])
    middles = (frequency[1:] + frequency[:-1]) / 2
    edges = np.concatenate([frequency[:1], middles, frequency[-1:]])
    name = "touches, or not found"
    for number, point in enumerate(points):
        if not point.found:
            for axes in panels:
                axes.axvspan(
                    edges[number], edges[number + 1], color=GREY, alpha=0.3, lw=0, label=name
                )
            name = "_"
