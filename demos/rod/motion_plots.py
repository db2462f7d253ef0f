"""Pictures of the paper, Figs 4 and 5: projections of phase space, maps over space and time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.results.stored_branch import StoredBranch

#: Instants of a period that a closed orbit is drawn through.
_ORBIT = 720

#: Places that a map is drawn through.
_PLACES = 401

_CAPTION = {"fontsize": 8.5, "color": "0.35"}


def plot_phase_space(
    path: Path,
    branch: StoredBranch,
    ratios: Sequence[float],
    stations: Mapping[str, int],
    *,
    title: str,
    component: int = 0,
) -> None:
    """Orbits of nodes against displacement and velocity of the first one, a row a node.

    The orbits of a branch lie on the invariant manifold of its mode; with u and v of the first
    node as parameters the picture shows that manifold.

    Args:
        path: Picture file to write.
        branch: Branch.
        ratios: Gamma ratios of the orbits, ascending.
        stations: Nodes by their names; the displacements of all but the first are the ordinates.
        title: Title.
        component: Component of the displacement, from 0.

    Raises:
        OutputError: if the branch has no point at one of the ratios.
    """
    reference, *followers = stations
    figure = Figure(figsize=(11.5, 3.6 * len(followers) + 1.2))
    FigureCanvasAgg(figure)
    figure.set_layout_engine("constrained", wspace=0.05, hspace=0.05)
    grid = figure.add_gridspec(len(followers), 3, width_ratios=(1.2, 1, 1))
    panels = [
        _phase_space_row(figure, [grid[row, k] for k in range(3)], reference, name)
        for row, name in enumerate(followers)
    ]
    colours = colormaps["viridis"](np.linspace(0.0, 0.9, len(ratios)))
    nodes = np.array(list(stations.values()))
    for rank, (ratio, colour) in enumerate(zip(ratios, colours, strict=True)):
        u, v, *others = _orbit(branch, branch.point(ratio), nodes, component)
        line = {"color": colour, "lw": 1.3, "zorder": 3 - 0.01 * rank}
        for (solid, over_u, over_v), w in zip(panels, others, strict=True):
            solid.plot(u, v, w, **line)
            over_u.plot(u, w, label=f"{ratio:g}", **line)
            over_v.plot(v, w, **line)
    figure.legend(
        *panels[0][1].get_legend_handles_labels(),
        loc="outside upper right",
        ncols=len(ratios),
        title="gamma ratio  (1)",
        fontsize=9,
    )
    figure.suptitle(title, fontsize=11, x=0.02, ha="left")
    figure.supxlabel(
        f"Closed orbits of the nonlinear mode, one an energy: displacements u over displacement "
        f"u and velocity v at {reference}.\n"
        "Below first contact (1) all nodes move in proportion, so the orbits of all energies lie "
        "in one plane; contact bends it.",
        **_CAPTION,
    )
    figure.savefig(path, dpi=150)


def _phase_space_row(
    figure: Figure, cells: Sequence[SubplotSpec], reference: str, name: str
) -> tuple[Axes3D, Axes, Axes]:
    """Axes of one node: in space, over displacement, over velocity of the reference node."""
    solid = cast(Axes3D, figure.add_subplot(cells[0], projection="3d"))
    over_u, over_v = (figure.add_subplot(cell) for cell in cells[1:])
    displacement, velocity = f"u, {reference}  (mm)", f"v, {reference}  (m/s)"
    ordinate = f"u, {name}  (mm)"
    solid.set_xlabel(displacement, fontsize=8)
    solid.set_ylabel(velocity, fontsize=8)
    solid.set_zlabel(ordinate, fontsize=8)
    solid.view_init(elev=28, azim=-35)
    solid.set_box_aspect((1, 1, 0.85), zoom=0.86)
    solid.tick_params(labelsize=7, pad=0)
    for axis in (solid.xaxis, solid.yaxis, solid.zaxis):
        axis.set_major_locator(MaxNLocator(4))
    for axes, abscissa in ((over_u, displacement), (over_v, velocity)):
        axes.set_xlabel(abscissa)
        axes.set_ylabel(ordinate)
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.grid(alpha=0.3)
    return solid, over_u, over_v


def _orbit(
    branch: StoredBranch, point: BranchPoint, nodes: Indices, component: int
) -> tuple[Array, ...]:
    """Displacement (mm) and velocity (m/s) of the first node, displacements (mm) of the others."""
    phase = np.linspace(-np.pi, np.pi, _ORBIT + 1)
    u = 1e3 * branch.displacement(point, phase, nodes)[:, :, component]
    v = branch.velocity(point, phase, nodes[:1])[:, 0, component]
    return (u[:, 0], v, *u[:, 1:].T)


@dataclass(frozen=True, slots=True)
class SpaceTime:
    """A motion over a line of places and one period of time.

    Attributes:
        name: What it is, such as its energy.
        time: Time over the period, uniform, with both ends, shape (t,).
        place: Coordinate along the line in m, ascending, shape (p,).
        displacement: In m, shape (t, p).
        velocity: In m/s, shape (t, p).
    """

    name: str
    time: Array
    place: Array
    displacement: Array
    velocity: Array


def space_time(
    branch: StoredBranch,
    point: BranchPoint,
    *,
    name: str,
    axis: int = 0,
    component: int = 0,
    instants: int = 240,
) -> SpaceTime:
    """The motion of all nodes of a slender body, from half a period before phase 0 to half after.

    Args:
        branch: Branch.
        point: One of its points.
        name: What the map is called.
        axis: Coordinate of the nodes along the body, from 0.
        component: Component of the displacement, from 0.
        instants: Steps of the period.
    """
    order = np.argsort(branch.nodes[:, axis])
    time = np.linspace(-0.5, 0.5, instants + 1)
    phase = 2 * np.pi * time
    return SpaceTime(
        name=name,
        time=time,
        place=branch.nodes[order, axis],
        displacement=branch.displacement(point, phase, order)[:, :, component],
        velocity=branch.velocity(point, phase, order)[:, :, component],
    )


def plot_space_time(
    path: Path, motions: Sequence[SpaceTime], *, title: str, caption: str = ""
) -> None:
    """Maps of displacement (above) and velocity (below), a column a motion.

    Each row has one colour scale, symmetric about zero.

    Args:
        path: Picture file to write.
        motions: Motions of the same body.
        title: Title.
        caption: Text below the maps.
    """
    figure = Figure(figsize=(1.2 + 3.4 * len(motions), 6.6), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(2, len(motions), sharex=True, sharey=True, squeeze=False)
    displacements = [1e3 * motion.displacement for motion in motions]
    _map_row(figure, grid[0], motions, displacements, "displacement  (mm)", "PuOr_r")
    velocities = [motion.velocity for motion in motions]
    _map_row(figure, grid[1], motions, velocities, "velocity  (m/s)", "RdBu_r")
    for axes, motion in zip(grid[0], motions, strict=True):
        axes.set_title(motion.name, fontsize=10)
    for axes in grid[1]:
        axes.set_xlabel("time over period  t / T  (1)")
    for axes in grid[:, 0]:
        axes.set_ylabel("place along the body  x  (m)")
    figure.suptitle(title, fontsize=11)
    if caption:
        figure.supxlabel(caption, **_CAPTION)
    figure.savefig(path, dpi=150)


def _map_row(
    figure: Figure,
    row: Sequence[Axes],
    motions: Sequence[SpaceTime],
    values: Sequence[Array],
    label: str,
    colours: str,
) -> None:
    """Maps of one quantity with one colour scale."""
    largest = max(float(np.abs(value).max()) for value in values)
    for axes, motion, value in zip(row, motions, values, strict=True):
        image = axes.imshow(
            _uniform(motion.place, value).T,
            extent=(motion.time[0], motion.time[-1], motion.place[0], motion.place[-1]),
            cmap=colours,
            vmin=-largest,
            vmax=largest,
            origin="lower",
            aspect="auto",
            interpolation="bilinear",
        )
    figure.colorbar(image, ax=row, label=label)


def _uniform(place: Array, values: Array) -> Array:
    """Values of shape (t, p) at uniform places, linear between the nodes."""
    places = np.linspace(place[0], place[-1], _PLACES)
    return np.array([np.interp(places, place, row) for row in values])
