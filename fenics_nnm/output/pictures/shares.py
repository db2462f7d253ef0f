"""Shares of harmonics and of linear modes in the kinetic energy, over energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.output.motion_measures import harmonic_shares, kinetic_shares
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    CURVES,
    GAMMA,
    GREY,
    Plot,
    legend_below,
    new_axes,
    new_figure,
)

#: Smallest share that is drawn, in percent.
_SMALLEST = 1e-8


def share_plots(results: Results) -> list[Plot]:
    """Harmonics and modes of the motion, where there is more than one of them."""
    series, points = results.series, results.points
    harmonics = 100 * np.array([harmonic_shares(series, point.motion.q) for point in points])
    modes = 100 * np.array([kinetic_shares(series, point.motion.q) for point in points])
    hertz = results.model.omega / (2 * np.pi)
    mode = results.header.mode
    return [
        *_plot(
            results,
            harmonics,
            [f"harmonic {n}" for n in range(harmonics.shape[1])],
            ("harmonic_shares", "Harmonic content"),
            "Share of the harmonics n of the frequency in the mean kinetic energy (%) over the "
            "gamma ratio; before contact (dotted) there is one. Drawn are the harmonics "
            "with the largest shares.",
        ),
        *_plot(
            results,
            modes,
            [f"mode {j + 1}, {f:.5g} Hz" for j, f in enumerate(hertz)],
            ("mode_shares", "Linear modes in the motion"),
            f"Share of the linear modes in the mean kinetic energy of nonlinear mode {mode} (%) "
            "over the gamma ratio; before contact (dotted) there is one. Drawn are the "
            "modes with the largest shares.",
        ),
    ]


def _plot(
    results: Results,
    shares: Array,
    names: Sequence[str],
    name_and_title: tuple[str, str],
    caption: str,
) -> list[Plot]:
    """Those of the columns with the largest shares anywhere, in their order."""
    largest = shares.max(axis=0)
    drawn = np.sort(np.argsort(-largest, kind="stable")[: len(CURVES)])
    drawn = drawn[largest[drawn] > _SMALLEST]
    if len(drawn) < 2:
        return []
    figure = new_figure(3.9)
    axes = new_axes(figure, GAMMA, "share of the kinetic energy  (%)")
    for column, (colour, marker) in zip(drawn, CURVES, strict=False):
        values = np.where(shares[:, column] > _SMALLEST, shares[:, column], np.nan)
        axes.semilogy(
            results.ratios,
            values,
            color=colour,
            marker=marker,
            ms=3,
            lw=1,
            label=names[int(column)],
        )
    axes.axvline(1, color=GREY, lw=0.8, ls=":")
    legend_below(figure, axes, columns=3 if max(map(len, names)) < 14 else 2)
    name, title = name_and_title
    return [Plot(name, title, caption, "motion", figure)]
