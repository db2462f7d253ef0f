"""The frequency of a branch over energy and amplitude, with all that is known of its points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import (
    CONVERGED,
    FAILED,
    MAIN_BRANCH,
    RESONANT,
    VERIFIED,
    BranchPoint,
)
from fenics_nnm.backbone.point_numbers import is_damped, stability_kind
from fenics_nnm.output.engine_orders import EngineOrder, orders_near
from fenics_nnm.output.pictures.amplitude import amplitude_of, stress_of
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    BLACK,
    BLUE,
    GAMMA,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    Plot,
    label,
    legend_below,
    new_axes,
    new_figure,
)
from fenics_nnm.time_domain.bifurcations import KINDS, BifurcationPoint


class LinearMode(NamedTuple):
    """The linear mode of a branch.

    Attributes:
        frequency: Its frequency in Hz.
        at_one: What happens at gamma ratio 1.
    """

    frequency: float
    at_one: str = "first contact"


class Places(NamedTuple):
    """Where something happens on the way of a branch, or nothing was found.

    Attributes:
        bifurcations: Bifurcations to mark.
        jumps: Gamma ratios of neighbours that the frequency jumps between.
        failures: Gamma or frequency ratios without a point, as in summary.json.
    """

    bifurcations: Sequence[BifurcationPoint] = ()
    jumps: Sequence[Sequence[float]] = ()
    failures: Sequence[Mapping[str, Any]] = ()


class Curve(NamedTuple):
    """A further curve.

    Attributes:
        gamma_ratios: Gamma ratios.
        energies: Total energies in J.
        frequencies: Frequencies in Hz.
    """

    gamma_ratios: Array
    energies: Array
    frequencies: Array


class Mark(NamedTuple):
    """How points of one kind are drawn."""

    marker: str
    face: str
    edge: str
    size: float


#: Marks of the points of each status, and of each kind of bifurcation.
_STATUSES = {
    VERIFIED: Mark("o", BLUE, BLUE, 4.5),
    CONVERGED: Mark("o", "white", BLUE, 4.5),
    RESONANT: Mark("s", "white", PURPLE, 4.5),
    FAILED: Mark("X", "white", RED, 4.5),
}
_BIFURCATIONS = {
    kind: Mark(marker, "none", BLACK, 8) for kind, marker in zip(KINDS, "vPD*", strict=True)
}

#: Line style, width and legend of the curve near points that are stable, unstable, or not known.
_LINES = {
    "stable": ("-", 1.6, "stable"),
    "unstable": ("--", 1.2, "unstable without damping"),
    "unstable, damped": ("--", 1.2, "unstable"),
    "": ("-", 0.6, "stability not known"),
}

#: Energies that span more than this factor are drawn on a logarithmic axis.
_LOGARITHMIC = 30

_ENERGY = "total energy  (J)"

#: Numbers of internal resonances stand so far apart, in points.
_LETTER = 9.0

#: Room for them above the curve, as a part of its height.
_ROOM = 0.1


def plot_backbone(
    path: Path,
    points: Sequence[BranchPoint],
    *,
    title: str,
    linear: LinearMode,
    places: Places = Places(),
    curves: Mapping[str, Curve] | None = None,
) -> None:
    """Frequency over gamma ratio and over energy, with the Rayleigh frequency.

    Half of the way from a point to its neighbours is drawn as the point is: stable or unstable. No
    line joins neighbours of different families, or such that the frequency jumps between.

    Args:
        path: Picture file to write.
        points: Points of the branch, by ascending energy.
        title: Title of the study.
        linear: The linear mode that the branch begins at.
        places: Where something happens.
        curves: Further curves by name.
    """
    figure = new_figure(4.4, 9.0)
    left, right = figure.subplots(1, 2, sharey=True)
    ratios, energies = _gamma_ratios(points), _energies(points)
    joined = _joined(points, places.jumps)
    _draw(left, ratios, points, joined)
    _draw(right, energies, points, joined)
    found = places.bifurcations
    _draw_bifurcations(left, [place.gamma_ratio for place in found], found)
    _draw_bifurcations(right, [place.energy for place in found], found)
    for axes in (left, right):
        axes.axhline(linear.frequency, color=GREY, lw=0.8, label="linear mode")
    styles = ("k-", "k:", "k-.")
    for (name, curve), style in zip((curves or {}).items(), styles, strict=False):
        left.plot(curve.gamma_ratios, curve.frequencies, style, lw=1, label=name, zorder=0.5)
        right.plot(curve.energies, curve.frequencies, style, lw=1, zorder=0.5)
    _draw_failures(left, places.failures, linear.frequency)
    left.axvline(1, color=GREY, lw=0.8, ls=":", label=linear.at_one)
    label(left, GAMMA, "frequency  (Hz)")
    _set_energy_scale(right, energies)
    label(right, _ENERGY, "")
    legend_below(figure, left, columns=4)
    figure.suptitle(title, fontsize=10)
    figure.savefig(path, dpi=150)


class Abscissa(NamedTuple):
    """What the frequency is drawn over.

    Attributes:
        name: "gamma ratio", "energy", "amplitude" or "stress".
        words: What it is, in words.
        label: Label of its axis.
        values: Its value at each point.
    """

    name: str
    words: str
    label: str
    values: Array


def frequency_plots(results: Results) -> list[Plot]:
    """The frequency over the gamma ratio, the energy, the amplitude and, if known, the stress."""
    return [_frequency_plot(results, each) for each in abscissas(results)]


def abscissas(results: Results) -> list[Abscissa]:
    """What the frequency of a branch is drawn over."""
    sizes = {"amplitude": amplitude_of(results), "stress": stress_of(results)}
    event = at_gamma_ratio_1(results.summary)
    over_gamma = (
        f"the gamma ratio: the modal energy coordinate gamma over its value at {event} (no unit)"
    )
    return [
        Abscissa("gamma ratio", over_gamma, GAMMA, results.ratios),
        Abscissa("energy", "the total energy in J", _ENERGY, _energies(results.points)),
        *(Abscissa(name, s.words, s.label, s.values) for name, s in sizes.items() if s),
    ]


def at_gamma_ratio_1(summary: Mapping[str, Any]) -> str:
    """What happens at gamma ratio 1, of a summary."""
    pressed = summary.get("at_rest", {}).get("at_gamma_ratio_1", "first contact")
    return str(summary.get("at_gamma_ratio_1", pressed))


def draw_frequency(axes: Axes, results: Results, over: Abscissa) -> str:
    """Draw one frequency curve without its legend; what the numbers of resonances mean."""
    jumps = [each["gamma_ratio"] for each in results.summary.get("jumps", [])]
    _draw(axes, over.values, results.points, _joined(results.points, jumps))
    if over.name in ("gamma ratio", "energy"):
        places = _bifurcations(results.summary)
        attribute = over.name.replace(" ", "_")
        _draw_bifurcations(axes, [getattr(place, attribute) for place in places], places)
    axes.axhline(results.linear_frequency, color=GREY, lw=0.8, label="linear mode")
    if over.name == "gamma ratio":
        _draw_failures(axes, results.summary.get("failures", []), results.linear_frequency)
        at_one = at_gamma_ratio_1(results.summary)
        axes.axvline(1, color=GREY, lw=0.8, ls=":", label=at_one)
    if over.name == "energy":
        _set_energy_scale(axes, over.values)
        _draw_orders(axes, results)
    label(axes, over.label, "frequency  (Hz)")
    return _number_resonances(axes, over.values, results.points)


def _frequency_plot(results: Results, over: Abscissa) -> Plot:
    """One frequency curve; its marks and lines are explained with the one over the gamma ratio."""
    figure = new_figure(3.7)
    axes = new_axes(figure, over.label, "frequency  (Hz)")
    numbers = draw_frequency(axes, results, over)
    legend_below(figure, axes)
    explained = (
        " The Rayleigh frequency is that of the paper; it is not the frequency of the motion "
        f"once there is a gap.{_verdicts(results.points)}{numbers}"
    )
    return Plot(
        name=f"frequency_{over.name.split()[0]}",
        title=f"Frequency over {over.name}",
        caption=f"Frequency in Hz of nonlinear mode {results.header.mode} over {over.words}."
        + (explained if over.name == "gamma ratio" else _as_over_gamma(results, over)),
        group="frequency",
        figure=figure,
    )


def _orders(results: Results) -> tuple[EngineOrder, ...]:
    """Engine orders among the frequencies of the points."""
    hertz = np.array([point.motion.frequency for point in results.points])
    return orders_near(results.header.values, hertz)


def _draw_orders(axes: Axes, results: Results) -> None:
    for order in _orders(results):
        axes.axhline(order.frequency, color=RED, lw=0.9, ls=(0, (6, 3)), label=order.name)


def _as_over_gamma(results: Results, over: Abscissa) -> str:
    """What is said of a curve that is explained with another one."""
    words = " Marks and lines as over the gamma ratio."
    orders = _orders(results) if over.name == "energy" else ()
    named = ", ".join(f"{order.number}: {order.frequency:.5g} Hz" for order in orders)
    return f"{words} Engine orders, multiples of the speed: {named}." if orders else words


def _gamma_ratios(points: Sequence[BranchPoint]) -> Array:
    return np.array([point.gamma_ratio for point in points])


def _energies(points: Sequence[BranchPoint]) -> Array:
    return np.array([point.motion.energy for point in points])


def _joined(points: Sequence[BranchPoint], jumps: Sequence[Sequence[float]]) -> list[bool]:
    """Whether each point is joined to the next: of one family, and without a jump."""
    return [
        one.family == other.family
        and not any(
            np.allclose((one.gamma_ratio, other.gamma_ratio), jump, rtol=1e-9, atol=0)
            for jump in jumps
        )
        for one, other in pairwise(points)
    ]


def _draw(
    axes: Axes, abscissa: Array, points: Sequence[BranchPoint], joined: Sequence[bool]
) -> None:
    """The curve by its stability, the points by their status, and the Rayleigh frequency."""
    frequency = np.array([point.motion.frequency for point in points])
    _draw_stability(axes, abscissa, frequency, [_stability(point) for point in points], joined)
    _draw_other_families(axes, abscissa, points)
    _draw_marks(axes, abscissa, frequency, [point.status for point in points], _STATUSES)
    rayleigh = _broken(np.array([point.motion.rayleigh_frequency for point in points]), joined)
    places = _broken(abscissa, joined)
    axes.plot(places, rayleigh, "-.", lw=1, color=ORANGE, label="Rayleigh frequency")


def _broken(values: Array, joined: Sequence[bool]) -> Array:
    """Values with a gap behind each that is not joined to the next."""
    behind = [index + 1 for index, each in enumerate(joined) if not each]
    return np.insert(np.asarray(values, dtype=float), behind, np.nan)


def _draw_other_families(axes: Axes, x: Array, points: Sequence[BranchPoint]) -> None:
    """Rings about the points that are not on the main branch."""
    other = [index for index, point in enumerate(points) if point.family > MAIN_BRANCH]
    if other:
        y = [points[index].motion.frequency for index in other]
        axes.plot(x[other], y, "o", ms=9, mfc="none", mec=GREY, mew=0.7, label="other family")


def _draw_bifurcations(
    axes: Axes, abscissa: Sequence[float], places: Sequence[BifurcationPoint]
) -> None:
    frequency = np.array([place.frequency for place in places])
    kinds = [place.kind for place in places]
    _draw_marks(axes, np.array(abscissa), frequency, kinds, _BIFURCATIONS)


def _draw_marks(
    axes: Axes, x: Array, y: Array, kinds: Sequence[str], marks: Mapping[str, Mark]
) -> None:
    """Draw marks, those of each kind alike and with one entry of the legend."""
    for kind, mark in marks.items():
        chosen = np.array([each == kind for each in kinds], dtype=bool)
        if chosen.any():
            axes.plot(
                x[chosen],
                y[chosen],
                mark.marker,
                ms=mark.size,
                mfc=mark.face,
                mec=mark.edge,
                label=kind,
                zorder=3,
            )


def _draw_failures(
    axes: Axes, failures: Sequence[Mapping[str, Any]], linear_frequency: float
) -> None:
    """Lines where points were wanted, over the gamma ratio: upright, or at a frequency."""
    for number, each in enumerate(failures):
        line: dict[str, Any] = {"color": RED, "lw": 0.8, "alpha": 0.5}
        line["label"] = "no point found" if number == 0 else None
        if "gamma_ratio" in each:
            axes.axvline(each["gamma_ratio"], **line)
        else:
            axes.axhline(each["frequency_ratio"] * linear_frequency, **line)


def _set_energy_scale(axes: Axes, energies: Array) -> None:
    if len(energies) and energies.min() > 0 and energies.max() > _LOGARITHMIC * energies.min():
        axes.set_xscale("log")


def _stability(point: BranchPoint) -> str:
    kind = stability_kind(point)
    unstable = "unstable, damped" if is_damped(point) else "unstable"
    return kind if kind in _LINES else unstable


def _draw_stability(
    axes: Axes, x: Array, y: Array, kinds: Sequence[str], joined: Sequence[bool]
) -> None:
    """Draw the curve in halves of the ways between points, those of each stability alike."""
    for kind, (style, width, name) in _LINES.items():
        parts = [_around(i, x, y, joined) for i, each in enumerate(kinds) if each == kind]
        if parts:
            line = np.concatenate(parts)
            axes.plot(line[:, 0], line[:, 1], style, lw=width, color=BLUE, label=name)


def _around(index: int, x: Array, y: Array, joined: Sequence[bool]) -> Array:
    """A point with the middles of the ways to those it is joined to, and a gap, shape (4, 2)."""
    before = index > 0 and joined[index - 1]
    after = index < len(x) - 1 and joined[index]
    near = [index - before, index, index + after]
    line = np.column_stack([(x[near] + x[index]) / 2, (y[near] + y[index]) / 2])
    return np.vstack([line, [np.nan, np.nan]])


def _bifurcations(summary: Mapping[str, Any]) -> list[BifurcationPoint]:
    """Bifurcations as summary.json has them."""
    return [
        BifurcationPoint(each["kind"], each["gamma_ratio"], each["energy_J"], each["frequency_Hz"])
        for each in summary.get("bifurcations", [])
    ]


def _number_resonances(axes: Axes, x: Array, points: Sequence[BranchPoint]) -> str:
    """Number the internal resonances where the branch enters them; what the numbers mean."""
    entered: dict[str, int] = {}
    for index, point in enumerate(points):
        if point.resonance:
            entered.setdefault(point.resonance, index)
    if entered:
        axes.margins(y=_ROOM)
    taken: list[Array] = []
    for number, index in enumerate(entered.values(), start=1):
        place = (x[index], points[index].motion.frequency)
        offset = _LETTER
        at = axes.transData.transform(place) * 72 / axes.figure.dpi + np.array([0, offset])
        while any(np.abs(at - other).max() < _LETTER for other in taken):
            offset += _LETTER
            at[1] += _LETTER
        taken.append(at)
        axes.annotate(
            str(number),
            place,
            xytext=(0, offset),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8,
            color=PURPLE,
        )
    if not entered:
        return ""
    named = ", ".join(f"{number}: {name}" for number, name in enumerate(entered, start=1))
    return f" Internal resonances: {named}."


def _verdicts(points: Sequence[BranchPoint]) -> str:
    """What the marks of the points mean."""
    words = {
        VERIFIED: "verified: confirmed by integration in time",
        CONVERGED: "converged: solves its equations, not confirmed in time",
        RESONANT: "inside resonance: another mode draws energy",
        FAILED: "failed: no motion of the model, or expected to be far off",
    }
    found = {point.status for point in points}
    return " Points are " + "; ".join(text for name, text in words.items() if name in found) + "."
