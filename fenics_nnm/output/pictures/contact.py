"""When and where a structure touches, how hard, and for how long."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.output.pictures.footprint import footprints
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    AMOUNT,
    BLUE,
    GAMMA,
    GREEN,
    GREY,
    PRESSURE,
    RED,
    TIME,
    Plot,
    Unit,
    label,
    label_bar,
    legend_below,
    new_axes,
    new_figure,
    shades,
    unit_for,
)
from fenics_nnm.output.pictures.unrolled import Ordered, ordered

#: Steps of the period in maps.
_INSTANTS = 360

#: Fewest contact points that a map is drawn of.
_FEWEST = 2

#: Most contact points of a map whose places are written.
_LABELLED = 7


def contact_plots(results: Results) -> list[Plot]:
    """Maps over contact points and time, and the duration of contact; none without contact."""
    if not results.touching:
        return []
    return [*_force(results), *footprints(results), *_maps(results), _duration(results)]


def contact_pressure(results: Results, point: BranchPoint, phase: Array) -> Array:
    """Pressure in Pa of a mesh, force in N of matrices, shape (len(phase), n_c)."""
    force = results.forces(point, phase)
    return force if results.areas is None else force / results.areas


def contact_order(results: Results) -> Ordered:
    """Contact points in an order that keeps neighbours together: along their patches."""
    body, count = results.body, results.model.points
    if body is None:
        places = np.arange(1.0, count + 1)
        words, label_of = "in the order of the matrices", "point  (1)"
        return Ordered(np.arange(count), places, (), words, label_of, factor=1.0)
    return ordered(body.contact_points, body.contact_patches)


def touching_shares(results: Results) -> tuple[Array, Array, Array]:
    """Shares of the period with contact anywhere, at a point in the mean, and at the busiest.

    Returns:
        Three arrays over the points of the branch, from 0 to 1.
    """
    weight = results.series.weight
    shares = [weight @ (point.motion.force > 0) for point in results.points]
    anywhere = [point.motion.contact_fraction for point in results.points]
    return (
        np.array(anywhere),
        np.array([share.mean() for share in shares]),
        np.array([share.max() for share in shares]),
    )


def _force(results: Results) -> list[Plot]:
    """The contact force of all points together, over time."""
    figure = new_figure(3.4)
    chosen = results.chosen_touching
    periods = [results.period_about(point, _INSTANTS) for point in chosen]
    forces = [
        results.forces(point, phase).sum(axis=1)
        for point, (_, phase) in zip(chosen, periods, strict=True)
    ]
    unit = unit_for(np.array(forces), "N")
    axes = new_axes(figure, TIME, f"contact force, all points  ({unit.name})")
    for point, (time, _), force, colour in zip(
        chosen, periods, forces, shades(len(chosen)), strict=True
    ):
        name = f"{point.gamma_ratio:.4g}"
        axes.plot(time, unit.factor * force, color=colour, lw=1.2, label=name)
    legend_below(figure, axes, 3, "gamma ratio  (1)")
    caption = (
        f"Sum of the contact forces in {unit.name} over one period, at chosen energies; the "
        f"middle of contact is at 0.{_with_mass(results)}"
    )
    return [Plot("contact_force", "Contact force", caption, "contact", figure)]


def _maps(results: Results) -> list[Plot]:
    """Pressure, and the distance to the obstacle, over contact points and time."""
    if results.model.points < _FEWEST:
        return []
    order = contact_order(results)
    chosen = results.chosen_touching
    pressures, distances = [], []
    for point in chosen:
        _, phase = results.period_about(point, _INSTANTS)
        pressures.append(contact_pressure(results, point, phase)[:, order.order])
        open_by = results.model.gap - results.contact_displacement(point, phase)
        distances.append(open_by[:, order.order])
    what, base = ("force", "N") if results.areas is None else ("pressure", "Pa")
    force, length = unit_for(np.array(pressures), base), unit_for(np.array(distances), "m")
    pressure = _map_figure(chosen, pressures, f"contact {what}", PRESSURE, force, order)
    distance = _map_figure(chosen, distances, "distance to the obstacle", AMOUNT, length, order)
    points = f"Contact points are ordered {order.words}; the middle of contact is at time 0"
    return [
        Plot(
            "contact_map",
            "Contact map",
            f"Contact {what} in {force.name} over contact points and one period, at chosen "
            f"energies. White is no contact. {points}.{_with_mass(results)}",
            "contact",
            pressure,
        ),
        Plot(
            "distance_map",
            "Distance to the obstacle",
            f"Distance of the contact points to the obstacle in {length.name} over one period, at "
            f"chosen energies; 0 is contact. {points}.",
            "contact",
            distance,
        ),
    ]


def _map_figure(
    points: Sequence[BranchPoint],
    values: Sequence[Array],
    name: str,
    colours: str,
    unit: Unit,
    order: Ordered,
) -> Figure:
    """Maps of one quantity below each other with one colour scale; values (time, points)."""
    figure = new_figure(1.0 + 1.5 * len(points))
    grid = figure.subplots(len(points), 1, sharex=True, squeeze=False)[:, 0]
    norm = Normalize(0, unit.factor * max(float(value.max()) for value in values))
    for axes, point, value in zip(grid, points, values, strict=True):
        none = colours == PRESSURE  # is drawn white
        shown = unit.factor * (np.ma.masked_less_equal(value.T, 0) if none else value.T)
        image = axes.imshow(
            shown,
            extent=(-0.5, 0.5, 0.5, value.shape[1] + 0.5),
            cmap=colormaps[colours],
            norm=norm,
            origin="lower",
            aspect="auto",
            interpolation="nearest",
        )
        _label_map(axes, point, order, last=axes is grid[-1])
    bar = figure.colorbar(image, ax=list(grid))
    label_bar(bar, f"{name}  ({unit.name})")
    return figure


def _label_map(axes: Axes, point: BranchPoint, order: Ordered, *, last: bool) -> None:
    """Labels, with the places of contact points along their patch in place of their numbers."""
    label(axes, TIME if last else "", order.label)
    axes.grid(visible=False)
    count = len(order.along)
    rows = np.unique(np.linspace(0, count - 1, min(count, _LABELLED)).round().astype(int))
    axes.set_yticks(rows + 1, [f"{order.shown[row]:.3g}" for row in rows])
    for row in order.breaks:
        axes.axhline(row + 0.5, color=GREY, lw=0.8)
    axes.set_title(
        f"gamma ratio {point.gamma_ratio:.4g}, {point.motion.frequency:.5g} Hz",
        fontsize=8.5,
    )


def _duration(results: Results) -> Plot:
    figure = new_figure(3.5)
    axes = new_axes(figure, GAMMA, "time in contact over period  (%)")
    anywhere, mean, busiest = (100 * share for share in touching_shares(results))
    curves = [("anywhere", anywhere, BLUE, "o", 6.0)]  # seen behind a busiest point like it
    if results.model.points > 1:
        curves += [
            ("busiest point", busiest, RED, "s", 3.0),
            ("mean of the points", mean, GREEN, "^", 3.5),
        ]
    for name, values, colour, marker, size in curves:
        axes.plot(results.ratios, values, color=colour, marker=marker, ms=size, lw=1, label=name)
    axes.set_ylim(bottom=0)
    legend_below(figure, axes, columns=3)
    last = results.shown[-1]
    milliseconds = 1e3 * last.motion.contact_fraction / last.motion.frequency
    caption = (
        "Share of the period with contact (%) over the gamma ratio, counted at the "
        f"{results.header.samples} samples of a period. At a gamma ratio of "
        f"{last.gamma_ratio:.4g} it is {100 * last.motion.contact_fraction:.3g} %, or "
        f"{milliseconds:.3g} ms."
    )
    return Plot("contact_duration", "Duration of contact", caption, "contact", figure)


def _with_mass(results: Results) -> str:
    if results.model.massless:
        return ""
    return (
        f" Contact points carry mass: drawn are the harmonics 0 to {results.header.harmonics} of "
        "the forces, as those above are not determined."
    )
