"""Plots of the face: axes in, axes out."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from fenics_nnm.face.histories import ContactHistory, MotionHistory
from fenics_nnm.output.pictures.amplitude import place_of
from fenics_nnm.output.pictures.backbone import abscissas, draw_frequency
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import BLACK, label, unit_for

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


def _axes(axes: Axes | None) -> Any:
    """The axes, or new ones."""
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]
