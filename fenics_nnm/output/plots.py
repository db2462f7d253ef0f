"""Pictures of a branch."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.time_domain.bifurcations import KINDS, Bifurcation
from fenics_nnm.time_domain.verdict import CONVERGED, FAILED, RESONANT, VERIFIED

#: Marker, face colour and edge colour of the points of each status.
_MARKERS = {
    VERIFIED: ("o", "tab:blue", "tab:blue"),
    CONVERGED: ("o", "white", "tab:blue"),
    RESONANT: ("s", "white", "tab:purple"),
    FAILED: ("X", "white", "tab:red"),
}

#: Line style, width and legend of the curve near points that are stable, unstable, or not known.
_LINES = {
    "stable": ("-", 1.6, "frequency, stable"),
    "unstable": ("--", 1.2, "frequency, unstable"),
    "": ("-", 0.6, "frequency, stability not known"),
}

#: Marker of each kind of bifurcation.
_BIFURCATIONS = dict(zip(KINDS, ("v", "P", "D", "*"), strict=True))

#: Energies that span more than this factor are drawn on a logarithmic axis.
_LOGARITHMIC = 30


def plot_backbone(
    path: Path,
    points: Sequence[BranchPoint],
    *,
    title: str,
    linear_frequency: float,
    failures: Sequence[float] = (),
    bifurcations: Sequence[Bifurcation] = (),
    curves: dict[str, tuple[Sequence[float], Sequence[float]]] | None = None,
) -> None:
    """Frequency over gamma ratio and over energy, with the Rayleigh frequency.

    Half of the way from a point to its neighbours is drawn as the point is: stable or unstable.

    Args:
        path: Picture file to write.
        points: Points of the branch, by ascending energy.
        title: Title of the study.
        linear_frequency: Frequency of the linear mode in Hz.
        failures: Gamma ratios without a point.
        bifurcations: Bifurcations to mark.
        curves: Further curves by name, as gamma ratios and frequencies in Hz.
    """
    figure = Figure(figsize=(12, 4.8), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, sharey=True)
    frequency = [point.frequency for point in points]
    rayleigh = [point.rayleigh_frequency for point in points]
    ratios = [point.gamma_ratio for point in points]
    energy = [point.energy for point in points]
    places = ([b.gamma_ratio for b in bifurcations], [b.energy for b in bifurcations])
    for axes, abscissa, bifurcates in zip((left, right), (ratios, energy), places, strict=True):
        _draw_stability(axes, abscissa, frequency, [_stability(point) for point in points])
        _mark(axes, abscissa, points)
        _mark_bifurcations(axes, bifurcates, bifurcations)
        axes.plot(abscissa, rayleigh, "-.", lw=1, color="tab:orange", label="Rayleigh frequency")
        axes.axhline(linear_frequency, color="0.6", lw=0.8, label="linear mode")
        axes.grid(alpha=0.3)
    for (name, (gamma, values)), style in zip(
        (curves or {}).items(), ("k-", "k:", "k-."), strict=False
    ):
        left.plot(gamma, values, style, lw=1, label=name, zorder=0.5)
    for ratio in failures:
        left.axvline(ratio, color="tab:red", lw=0.8, alpha=0.5)
    left.axvline(1, color="0.6", lw=0.8, ls=":")
    left.set_xlabel(r"modal energy coordinate $\gamma / \gamma_\mathrm{grazing}$  (1)")
    left.set_ylabel("frequency  (Hz)")
    figure.legend(*left.get_legend_handles_labels(), loc="outside right upper", fontsize=9)
    right.set_xlabel("total energy  (J)")
    if energy and max(energy) > _LOGARITHMIC * min(energy):
        right.set_xscale("log")
    for axes in (left, right):
        axes.yaxis.get_major_formatter().set_useOffset(False)
    if right.get_xscale() == "linear":
        right.xaxis.set_major_locator(MaxNLocator(5))
    figure.suptitle(title, fontsize=11)
    missing = f"  Red lines: {len(failures)} energies without a point." if failures else ""
    figure.supxlabel(
        "Frequency-energy curve of the nonlinear mode; contact begins at 1 (dotted)." + missing,
        fontsize=8.5,
        color="0.35",
    )
    figure.savefig(path, dpi=150)


def _stability(point: BranchPoint) -> str:
    return point.stability if point.stability in _LINES else "unstable"


def _draw_stability(
    axes: Axes, abscissa: Sequence[float], frequency: Sequence[float], kinds: Sequence[str]
) -> None:
    """Draw the curve in halves of the ways between points, those of each stability alike."""
    x, y = np.asarray(abscissa), np.asarray(frequency)
    for kind, (style, width, label) in _LINES.items():
        parts = [_around(i, x, y) for i, each in enumerate(kinds) if each == kind]
        if parts:
            line = np.concatenate(parts)
            axes.plot(line[:, 0], line[:, 1], style, lw=width, color="tab:blue", label=label)


def _around(index: int, x: Array, y: Array) -> Array:
    """A point with the middles of the ways to its neighbours, and a gap, shape (4, 2)."""
    near = [max(index - 1, 0), index, min(index + 1, len(x) - 1)]
    line = np.column_stack([(x[near] + x[index]) / 2, (y[near] + y[index]) / 2])
    return np.vstack([line, [np.nan, np.nan]])


def _mark_bifurcations(
    axes: Axes, abscissa: Sequence[float], bifurcations: Sequence[Bifurcation]
) -> None:
    """Draw bifurcations, those of each kind alike."""
    for kind, marker in _BIFURCATIONS.items():
        chosen = [i for i, each in enumerate(bifurcations) if each.kind == kind]
        if chosen:
            axes.plot(
                [abscissa[i] for i in chosen],
                [bifurcations[i].frequency for i in chosen],
                marker,
                ms=8,
                mfc="none",
                mec="k",
                label=kind,
                zorder=3,
            )


def _mark(axes: Axes, abscissa: Sequence[float], points: Sequence[BranchPoint]) -> None:
    """Draw the points, those of each status alike."""
    for status, (marker, face, edge) in _MARKERS.items():
        chosen = [i for i, point in enumerate(points) if point.status == status]
        if chosen:
            axes.plot(
                [abscissa[i] for i in chosen],
                [points[i].frequency for i in chosen],
                marker,
                ms=4.5,
                mfc=face,
                mec=edge,
                label=status,
            )
