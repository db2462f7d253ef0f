"""Plots of the face: axes in, axes out."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fenics_nnm.face.histories import ContactHistory, MotionHistory
from fenics_nnm.face.response_curve import ResponseCurve
from fenics_nnm.face.tables import Table
from fenics_nnm.output.pictures.amplitude import place_of
from fenics_nnm.output.pictures.backbone import abscissas, draw_frequency
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import BLACK, CURVES, label, unit_for

#: Colours of levels.
_COLOURS = tuple(colour for colour, _ in CURVES)

_TIME = "time  (ms)"


def plot_frequency(results: Results, axes: Axes | None, over: str) -> Axes:
    """The frequency of a branch over one of the abscissas of `fenics-nnm plot`.

    Raises:
        ValueError: if there is no such abscissa.
    """
    known = {each.name: each for each in abscissas(results)}
    if over not in known:
        raise ValueError(f"over = {over!r}: must be one of {', '.join(map(repr, known))}")
    drawn = _axes(axes)
    draw_frequency(drawn, results, known[over])
    drawn.legend(fontsize=8)
    return drawn


def plot_force(history: ContactHistory, axes: Axes | None, name: str) -> Axes:
    """The sum of the contact forces over time."""
    force = history.force_N.sum(axis=1)
    unit, drawn = unit_for(force, "N"), _axes(axes)
    drawn.plot(1e3 * history.time_s, unit.factor * force, lw=1.2, label=name)
    label(drawn, _TIME, f"contact force, all points  ({unit.name})")
    drawn.legend(fontsize=8)
    return drawn


def plot_motion(history: MotionHistory, axes: Axes | None) -> Axes:
    """Displacement of the first node over time."""
    moved = history.displacement_m[:, 0]
    unit, drawn = unit_for(moved, "m"), _axes(axes)
    for values, letter in zip(moved.T, "xyz", strict=True):
        drawn.plot(1e3 * history.time_s, unit.factor * values, lw=1.2, label=letter)
    drawn.axhline(0, color=BLACK, lw=0.5)
    label(drawn, _TIME, f"displacement  ({unit.name})")
    drawn.set_title(f"node at {place_of(history.places_m[0])}", fontsize=9)
    drawn.legend(fontsize=8)
    return drawn


def plot_response(curves: Sequence[ResponseCurve], resonances: Table, axes: Axes | None) -> Axes:
    """Amplitudes of a place over frequency, with the damped backbone if there is one."""
    drawn = _axes(axes)
    unit = unit_for(np.concatenate([curve.amplitude_m for curve in curves]), "m")
    levels = dict.fromkeys(curve.level for curve in curves)
    colours = dict(zip(levels, itertools.cycle(_COLOURS), strict=False))
    named: set[float] = set()
    for curve in curves:
        look = {"color": colours[curve.level], "lw": 1.2}
        amplitude = unit.factor * curve.amplitude_m
        drawn.plot(curve.frequency_Hz, amplitude, ls="--", **look)
        name = "_" if curve.level in named else f"level {curve.level:g}"
        full = np.where(curve.stable, amplitude, np.nan)
        drawn.plot(curve.frequency_Hz, full, label=name, **look)
        named.add(curve.level)
    if len(resonances.get("level", ())):
        amplitude = unit.factor * resonances["amplitude_m"]
        drawn.plot(resonances["frequency_Hz"], amplitude, ":", color=BLACK, label="damped backbone")
    drawn.set_yscale("log")
    label(drawn, "frequency  (Hz)", f"amplitude of {curves[0].place}, 0-peak  ({unit.name})")
    drawn.legend(fontsize=8)
    return drawn


def plot_campbell(table: Table, crossings: Table, axes: Axes | None) -> Axes:
    """Frequencies over speed: linear lines, points of the nonlinear mode, crossings."""
    drawn = _axes(axes)
    linear = table["status"] == "linear"
    for mode in np.unique(table["mode"][linear]):
        own = linear & (table["mode"] == mode)
        drawn.plot(table["rpm"][own], table["frequency_Hz"][own], lw=1.2, label=f"mode {mode:g}")
    others = ~linear & np.isfinite(table["frequency_Hz"])
    if others.any():
        drawn.plot(table["rpm"][others], table["frequency_Hz"][others], "o", ms=4, color=BLACK,
                   label="nonlinear mode")  # fmt: skip
    rpm = crossings["speed_rad_s"] * 30 / np.pi
    drawn.plot(rpm, crossings["frequency_Hz"], "x", color=BLACK, label="engine order")
    label(drawn, "speed  (rpm)", "frequency  (Hz)")
    drawn.legend(fontsize=8)
    return drawn


def _axes(axes: Axes | None) -> Any:
    """The axes, or new ones."""
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]
