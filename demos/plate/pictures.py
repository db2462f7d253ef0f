"""Pictures of the demo: two methods compared, and pressure along the contact line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fenics_nnm.arrays import Array

#: Colour and line of each method.
_STYLE = {"massless": ("tab:blue", "-"), "Craig-Bampton": ("tab:orange", "--")}


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _finish(figure: Figure, path: Path, title: str, caption: str) -> None:
    figure.suptitle(title, fontsize=11)
    figure.supxlabel(caption, fontsize=8.5, color="0.35")
    figure.savefig(path, dpi=150)


def draw_comparison(path: Path, ratios: Array, found: dict[tuple[str, int], Array]) -> None:
    """Frequency ratios of both methods, and how far they are apart.

    Args:
        path: Picture file to write.
        ratios: gamma ratios of the points.
        found: Frequency ratios by method and number of harmonics.
    """
    figure = _figure(10, 4.6)
    left, right = figure.subplots(1, 2)
    orders = sorted({harmonics for _, harmonics in found})
    for (method, harmonics), values in found.items():
        colour, line = _STYLE[method]
        marker = "o" if harmonics == orders[-1] else "^"
        label = f"{method}, N = {harmonics}"
        left.plot(ratios, values, line, marker=marker, ms=4, mfc="white", color=colour, label=label)
    for harmonics, marker in zip(orders, "^o", strict=True):
        change = found["Craig-Bampton", harmonics] / found["massless", harmonics] - 1
        right.plot(ratios, 100 * change, "-", marker=marker, ms=4, color="0.3", mfc="white",
                   label=f"N = {harmonics}")  # fmt: skip
    left.set_ylabel("frequency / that of the linear mode  (1)")
    right.set_ylabel("Craig-Bampton over massless, minus 1  (%)")
    for axes in (left, right):
        axes.set_xlabel("gamma ratio  (1)")
        axes.axvline(1, color="0.6", lw=0.8, ls=":")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=9)
    caption = (
        "Left: frequency over gamma ratio; contact begins at 1 (dotted). Right: their difference."
    )
    _finish(figure, path, "Dumbbell on a line: two methods, 40 modes", caption)


def draw_pressure(
    path: Path,
    y: Array,
    ratio: float,
    instants: dict[str, dict[float, Array]],
    means: dict[str, dict[float, Array]],
) -> None:
    """Pressure along the line at instants of contact, and its mean over the period.

    Args:
        path: Picture file to write.
        y: Places of the contact points in m.
        ratio: gamma ratio of the instants.
        instants: Acting pressure in Pa by method and phase (part of the period).
        means: Mean pressure in Pa by method and gamma ratio.
    """
    figure = _figure(12, 4.6)
    axes = figure.subplots(1, 3)
    for place, (method, curves) in zip(axes, instants.items(), strict=False):
        for index, (phase, pressure) in enumerate(curves.items()):
            colour = f"C{index}"
            place.plot(1e3 * y, pressure / 1e6, ".-", ms=4, lw=1, color=colour,
                       label=f"t = {phase:.3f} T")  # fmt: skip
        place.set_title(f"{method}, gamma ratio {ratio:g}", fontsize=10)
        place.set_ylabel("pressure of harmonics 0 to N  (MPa)")
    top = max(place.get_ylim()[1] for place in axes[:2])
    for place in axes[:2]:
        place.set_ylim(0, 1.3 * top)
    for method, curves in means.items():
        colour, line = _STYLE[method]
        for reached, pressure in curves.items():
            marker = "o" if reached == ratio else "^"
            axes[2].plot(1e3 * y, pressure / 1e6, line, marker=marker, ms=3, lw=1, color=colour,
                         label=f"{method}, {reached:g}")  # fmt: skip
    axes[2].set_title("mean over the period, at gamma ratios", fontsize=10)
    axes[2].set_ylabel("mean pressure  (MPa)")
    axes[2].set_ylim(0, 1.45 * axes[2].get_ylim()[1])
    for place in axes:
        place.set_xlabel("place along the line  (mm)")
        place.grid(alpha=0.3)
        place.legend(fontsize=8, loc="upper center", ncols=1 if place is axes[2] else 2)
    caption = (
        "Every dot is a contact point; T is the period, t = 0 the middle of contact. "
        "Gamma ratios: gamma over its value at first contact."
    )
    _finish(figure, path, "Pressure along the contact line", caption)


def draw_pressed(path: Path, curves: dict[str, tuple[Array, Array]]) -> None:
    """Static pressure of a face moved by the same amount everywhere, over its mean.

    Args:
        path: Picture file to write.
        curves: Places in m and pressures in Pa by label; one panel for each.
    """
    figure = _figure(12, 5.6)
    panels = figure.subplots(2, len(curves) // 2, sharex=True, sharey=True)
    for axes, (label, (y, pressure)) in zip(np.ravel(panels), curves.items(), strict=True):
        axes.plot(1e3 * y, pressure / pressure.mean(), ".-", ms=4, lw=1)
        axes.set_title(label, fontsize=10)
        axes.grid(alpha=0.3)
    for axes in panels[-1]:
        axes.set_xlabel("place along the line  (mm)")
    for axes in panels[:, 0]:
        axes.set_ylabel("pressure over its mean  (1)")
    caption = (
        "Every dot is a contact point. Degree 1 is smooth; degree 2, with contact at the vertices "
        "alone, drops at the corners and oscillates on triangles."
    )
    _finish(figure, path, "Static pressure of the flat face, by element", caption)
