"""Floquet multipliers of the motions of a branch: where they are, and how large they get."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.backbone.point_numbers import is_damped, largest_multiplier
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    AMOUNT,
    BLACK,
    BLUE,
    GAMMA,
    GREY,
    Plot,
    label_bar,
    legend_below,
    new_axes,
    new_figure,
)

#: Multipliers up to this modulus need no logarithmic axis, and have their place in the plane.
_NEAR = 2.0

#: Multipliers farther from the unit circle than this are drawn larger than those on it.
_OFF = 1e-3

#: Sizes of their marks in square points.
_SMALL, _LARGE = 4, 22

#: The plane is shown up to this modulus, or a little farther than the largest multiplier in it.
_PLANE, _ROOM = 1.15, 1.08


#: What their caption says of motions without damping, and of damped ones.
_UNDAMPED = (
    "; the two that are always 1 are left out. They come as mu, 1/mu and their conjugates: a "
    "motion is stable if all are on the unit circle."
)
_DAMPED = (
    ", under the force that keeps it up. A motion is stable if all are inside the unit circle."
)


def multiplier_plots(results: Results) -> list[Plot]:
    """Multipliers in the complex plane and the largest over energy; nothing if none is known."""
    return [*_in_the_plane(results), *_largest(results)]


def _in_the_plane(results: Results) -> list[Plot]:
    """All multipliers with the unit circle, coloured by the gamma ratio."""
    known = [point.stability for point in results.points]
    counts = [len(each.multipliers) if each else 0 for each in known]
    if not any(counts):
        return []
    multipliers = np.concatenate([each.multipliers for each in known if each])
    ratios = np.repeat(results.ratios, counts)
    modulus = np.abs(multipliers)
    beyond, off = modulus > _NEAR, np.abs(modulus - 1) > _OFF
    figure = new_figure(4.2)
    axes = new_axes(figure, "real part of the multiplier  (1)", "imaginary part  (1)")
    turn = np.linspace(0, 2 * np.pi, 361)
    axes.plot(np.cos(turn), np.sin(turn), color=GREY, lw=1, label="unit circle")
    norm = Normalize(*_ends(results.ratios))
    edge = _NEAR if beyond.any() else max(_PLANE, _ROOM * float(modulus.max()))
    _dots(axes, multipliers[~off], ratios[~off], norm, "o", _SMALL, "multipliers on it")
    near = off & ~beyond
    _dots(axes, multipliers[near], ratios[near], norm, "o", _LARGE, f"more than {_OFF:g} off it")
    at_edge = edge * multipliers[beyond] / np.abs(multipliers[beyond])
    _dots(axes, at_edge, ratios[beyond], norm, "^", _LARGE, f"modulus above {_NEAR:g}")
    axes.set(xlim=(-_ROOM * edge, _ROOM * edge), ylim=(-_ROOM * edge, _ROOM * edge), aspect="equal")
    bar = figure.colorbar(ScalarMappable(norm, AMOUNT), ax=axes, shrink=0.9)
    label_bar(bar, GAMMA)
    legend_below(figure, axes)
    missing = counts.count(0)
    caption = (
        "Floquet multipliers (no unit) of the exact motion near each point, coloured by the gamma "
        f"ratio{_DAMPED if _are_damped(results) else _UNDAMPED}"
        + (_beyond_explained(multipliers, beyond) if beyond.any() else "")
        + (f" Not known at {missing} of {len(counts)} points." if missing else "")
    )
    title = "Floquet multipliers in the complex plane"
    return [Plot("multipliers_plane", title, caption, "accuracy", figure)]


def _are_damped(results: Results) -> bool:
    return any(map(is_damped, results.points))


def _ends(ratios: Array) -> tuple[float, float]:
    """Lowest and highest gamma ratio, which differ."""
    low, high = float(ratios.min()), float(ratios.max())
    return low, high if high > low else low + 1


def _dots(
    axes: Axes, places: Complex, ratios: Array, norm: Normalize, marker: str, size: int, name: str
) -> None:
    if len(places):
        width = 0.5 if size == _LARGE else 0
        axes.scatter(places.real, places.imag, c=ratios, cmap=AMOUNT, norm=norm, marker=marker,
                     s=size, linewidths=width, edgecolors=BLACK, label=name, zorder=3)  # fmt: skip


def _beyond_explained(multipliers: Complex, beyond: Array) -> str:
    moduli = np.abs(multipliers[beyond])
    return (
        f" Triangles: moduli from {moduli.min():.3g} to {moduli.max():.3g}, drawn at {_NEAR:g} in "
        "their direction."
    )


def _largest(results: Results) -> list[Plot]:
    largest = np.array([largest_multiplier(point) for point in results.points])
    if not np.isfinite(largest).any():
        return []
    figure = new_figure(3.0)
    axes = new_axes(figure, GAMMA, "largest multiplier, modulus  (1)")
    axes.plot(results.ratios, largest, "o-", ms=3.5, lw=1, color=BLUE, label="exact motion nearby")
    axes.axhline(1, color=GREY, lw=1, ls="--", label="stable: on the unit circle")
    if np.nanmax(largest) > _NEAR:
        axes.set_yscale("log")
    else:
        axes.set_ylim(min(0.95, 0.98 * np.nanmin(largest)), max(1.05, 1.02 * np.nanmax(largest)))
    legend_below(figure, axes)
    missing = int(np.isnan(largest).sum())
    caption = (
        "Largest modulus (no unit) of the Floquet multipliers of the exact motion near each point, "
        f"over the gamma ratio. It is 1{' or less' if _are_damped(results) else ''} where the "
        "motion is stable; small disturbances grow by this factor in each period where it is "
        "larger." + (f" Not known at {missing} of {len(largest)} points." if missing else "")
    )
    return [Plot("multipliers", "Largest Floquet multiplier", caption, "accuracy", figure)]
