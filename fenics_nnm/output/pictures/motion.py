"""Motions of single points: phase projections, and the orbit of the one that moves most."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.output.pictures.amplitude import place_of
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    BLACK,
    Plot,
    label,
    legend_below,
    new_axes,
    new_figure,
    shades,
    unit_for,
)
from fenics_nnm.results.stored_branch import StoredBranch

#: Phases of a period that a closed orbit is drawn through.
_ORBIT = np.linspace(0, 2 * np.pi, 721)

#: Title of the legend of energies.
_ENERGIES = "gamma ratio  (1)"

#: Components below this part of the largest one make no orbit.
_STRAIGHT = 1e-2


def motion_plots(results: Results) -> list[Plot]:
    """Phase projections, and the orbit of the node that moves most."""
    plots = [_phase_of_contact(results)]
    if results.body is not None:
        plots += [_phase_of_tip(results, results.body), *_orbit(results, results.body)]
    return plots


def _phase_of_contact(results: Results) -> Plot:
    """Displacement and velocity of the contact point that is pushed most."""
    point = int(np.argmax(results.shown[-1].motion.force.max(axis=0)))
    chosen = results.chosen
    displacements = [results.contact_displacement(each, _ORBIT)[:, point] for each in chosen]
    velocities = [results.contact_velocity(each, _ORBIT)[:, point] for each in chosen]
    at = "" if results.body is None else f" at {place_of(results.body.contact_points[point])}"
    return _phase_plot(
        results,
        displacements,
        velocities,
        ("phase_contact", "Phase projection, contact point"),
        ("towards obstacle", f"towards the obstacle of contact point {point + 1}{at}"),
        gap=float(results.model.gap[point]),
    )


def _phase_of_tip(results: Results, body: StoredBranch) -> Plot:
    """Displacement and velocity of the node that moves most, along its largest component."""
    tip = results.tip
    node, chosen = np.array([tip]), results.chosen
    last = body.displacement(results.shown[-1], _ORBIT, node)[:, 0]
    axis = int(np.argmax(np.ptp(last, axis=0)))
    displacements = [body.displacement(each, _ORBIT, node)[:, 0, axis] for each in chosen]
    velocities = [body.velocity(each, _ORBIT, node)[:, 0, axis] for each in chosen]
    along = f"along {'xyz'[axis]}"
    return _phase_plot(
        results,
        displacements,
        velocities,
        ("phase_tip", "Phase projection, largest motion"),
        (along, f"{along} of the node that moves most, at {place_of(body.nodes[tip])},"),
    )


def _phase_plot(
    results: Results,
    displacements: Sequence[Array],
    velocities: Sequence[Array],
    name_and_title: tuple[str, str],
    direction: tuple[str, str],
    *,
    gap: float | None = None,
) -> Plot:
    """Velocities over displacements, a curve an energy; `direction` on the axes and in full."""
    length, speed = unit_for(np.array(displacements), "m"), unit_for(np.array(velocities), "m/s")
    short, words = direction
    figure = new_figure(3.7)
    axes = new_axes(
        figure, f"displacement {short}  ({length.name})", f"velocity {short}  ({speed.name})"
    )
    chosen = results.chosen
    for each, u, v, colour in zip(
        chosen, displacements, velocities, shades(len(chosen)), strict=True
    ):
        name = f"{each.gamma_ratio:.4g}"
        axes.plot(length.factor * u, speed.factor * v, color=colour, lw=1.1, label=name)
    caption = (
        f"Displacement in {length.name} and velocity in {speed.name} {words} over one period, at "
        "chosen energies."
    )
    if gap is not None:
        axes.axvline(length.factor * gap, color=BLACK, lw=1, ls="--", label="obstacle")
        caption += f" The obstacle (dashed) is at {length.factor * gap:.4g} {length.name}."
    legend_below(figure, axes, 4, _ENERGIES)
    return Plot(*name_and_title, caption, "motion", figure)


def _orbit(results: Results, body: StoredBranch) -> list[Plot]:
    """Path of the node that moves most, in the planes of the axes that it moves along."""
    tip, chosen = results.tip, results.chosen
    paths = [body.displacement(each, _ORBIT, np.array([tip]))[:, 0] for each in chosen]
    extent = np.max([np.ptp(path, axis=0) for path in paths], axis=0)
    moving = np.flatnonzero(extent > _STRAIGHT * extent.max())
    planes = list(combinations(moving, 2))
    if not planes:
        return []
    length = unit_for(np.array(paths), "m")
    figure = new_figure(2.5 * len(planes) + 1.2)
    grid = figure.subplots(len(planes), 1, squeeze=False)[:, 0]
    for axes, (i, j) in zip(grid, planes, strict=True):
        for each, path, colour in zip(chosen, paths, shades(len(chosen)), strict=True):
            x, y = length.factor * path[:, [i, j]].T
            axes.plot(x, y, color=colour, lw=1.1, label=f"{each.gamma_ratio:.4g}")
        names = [f"displacement {'xyz'[axis]}  ({length.name})" for axis in (i, j)]
        label(axes, *names)
    legend_below(figure, grid[0], 4, _ENERGIES)
    caption = (
        f"Path of the node that moves most, at {place_of(body.nodes[tip])}, over one period, at "
        f"chosen energies: its displacements in {length.name}, each axis with its own scale."
    )
    return [Plot("orbit", "Orbit of the largest motion", caption, "motion", figure)]
