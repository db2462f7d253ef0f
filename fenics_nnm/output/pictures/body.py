"""Pictures of a body: its mesh, its deformed shapes, and an animation of its motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.output.pictures.obstacle import WORDS, obstacle_layers
from fenics_nnm.output.pictures.panels import (
    Plan,
    grid_of,
    height_over_width,
    legend_of,
    round_below,
    scale_words,
    show,
    without_bands,
)
from fenics_nnm.output.pictures.renderer import Image
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.scene import (
    Balls,
    Camera,
    Faces,
    Layer,
    Lines,
    Scene,
    View,
    size_of,
)
from fenics_nnm.output.pictures.skin import Skin, best_view, held, skin_of
from fenics_nnm.output.pictures.style import (
    BLUE,
    OUTLINE,
    RED,
    SIZE,
    WIDTH,
    Plot,
    Unit,
    label_bar,
    new_figure,
    unit_for,
)
from fenics_nnm.results.stored_branch import StoredBranch

#: Colour of a body.
BODY = "#d7dee6"

#: Radius of the ball at a contact point, as a part of the size of the body.
_BALL = 0.008

#: The largest displacement is drawn as about this part of the size of the body.
ENLARGED = 0.12

#: Displacements that differ by less than this part are of one size.
_TIE = 1e-3

#: Longer side of the picture of the mesh, and of a panel beside others, in pixels.
_LARGE, _PANEL = 1000, 700


#: Width of a figure of two views in inches, and what is said of one and of two views.
_TWO_VIEWS = 7.4
_SIDES = {1: "", 2: "; seen from two opposite sides"}


@dataclass(frozen=True, slots=True)
class Shape:
    """A deformed shape to draw.

    Attributes:
        name: Title of its panel.
        displacement: Displacement of all nodes in m, shape (n, dim).
    """

    name: str
    displacement: Array

    @property
    def magnitude(self) -> Array:
        """Length of the displacement of each node in m, shape (n,)."""
        return np.asarray(np.linalg.norm(self.displacement, axis=1))


@dataclass(frozen=True, slots=True)
class Row:
    """Shapes side by side with one scale of colours.

    Attributes:
        label: What is drawn, for the scale of colours.
        factor: How many times displacements are enlarged.
        shapes: Deformed shapes.
    """

    label: str
    factor: float
    shapes: Sequence[Shape]


def factor_for(skin: Skin, displacements: Sequence[Array]) -> float:
    """How many times displacements of shape (n, dim) are enlarged to be seen: 1, 2 or 5 times 10^k.

    Not below 1, as a displacement that large needs no help.
    """
    largest = max(float(np.linalg.norm(field, axis=1).max()) for field in displacements)
    if largest <= 0:
        return 1.0
    return max(1.0, round_below(ENLARGED * size_of(skin.places) / largest))


def view_of(body: StoredBranch, point: BranchPoint, tip: int) -> View:
    """The view that a body is drawn from: of its contact surface and of its motion."""
    skin = skin_of(body)
    field = displacement_of(body, point, _largest_at(body, point, tip))
    return best_view(skin, body.contact_directions, field[skin.source])


def displacement_of(body: StoredBranch, point: BranchPoint, phase: float) -> Array:
    """Displacement of all nodes at a phase in m, shape (n, dim)."""
    return body.displacement(point, np.array([phase]))[0]


def _largest_at(body: StoredBranch, point: BranchPoint, tip: int) -> float:
    """Phase at which a node is farthest from rest; of several the one nearest to pi."""
    phase = np.linspace(0, 2 * np.pi, 97)
    moved = np.linalg.norm(body.displacement(point, phase, np.array([tip]))[:, 0], axis=1)
    farthest = phase[moved > (1 - _TIE) * moved.max()]
    return float(farthest[np.argmin(np.abs(farthest - np.pi))])


def contact_balls(places: Array, size: float, colour: str = RED) -> Balls:
    """Balls at contact points of a body of a size in m."""
    return Balls(places, np.full(len(places), _BALL * size), colour)


def plan_mesh(body: StoredBranch, view: View) -> Plan:
    """The mesh with its contact points, and where it is held.

    It is drawn from the other side too where no clamped face is turned to the viewer.
    """
    skin = skin_of(body)
    layers: list[Layer] = [
        Faces(skin.places, skin.faces, BODY, edges=True),
        Lines(skin.places[skin.edges], OUTLINE, 1.5),
        contact_balls(body.contact_points, size_of(skin.places)),
    ]
    fixed = _clamp(skin, held(body)[skin.source])
    if fixed:
        layers.append(fixed)

    hidden = fixed is not None and not fixed.is_seen(view.frame[2])
    views = [view, view.opposite] if hidden else [view]
    cameras = [Camera.around(skin.places, each, pixels=_LARGE) for each in views]

    def finish(images: Sequence[Image]) -> Plot:
        width = WIDTH if len(views) == 1 else _TWO_VIEWS
        figure = new_figure(max(_height(each, len(views), width) for each in cameras) + 0.4, width)
        panels = figure.subplots(1, len(views), squeeze=False)[0]
        for axes, image, camera in zip(panels, images, cameras, strict=True):
            show(axes, image, camera)
        entries = [("ball", RED, f"contact points ({len(body.contact_points)})")]
        if fixed:
            entries.append((fixed.symbol, BLUE, "clamped"))
        legend_of(figure, entries)
        caption = (
            f"Mesh of {len(body.cells)} cells with {len(body.nodes)} nodes; balls: contact points, "
            f"{len(body.contact_points)} in all{_SIDES[len(views)]}. Lengths in the plane of the "
            f"picture have the scale below it, of {scale_words(cameras[0])}."
        )
        return Plot("mesh", "Mesh and contact points", caption, "body", figure)

    return Plan([Scene(layers, camera) for camera in cameras], finish)


def _clamp(skin: Skin, still: Array) -> Layer | None:
    """Faces of a solid, edges of a plane body or an end of a rod that do not move."""
    if skin.dim == 3:
        faces = skin.faces[still[skin.faces].all(axis=1)]
        return Faces(skin.places, faces, BLUE, edges=True) if len(faces) else None
    edges = skin.edges[still[skin.edges].all(axis=1)]
    return Lines(skin.places[edges], BLUE, 6.0) if len(edges) else None


def plan_shapes(
    body: StoredBranch,
    rows: Sequence[Row],
    view: View,
    *,
    name: str,
    title: str,
    caption: str,
    beside: Sequence[Layer] = (),
) -> Plan:
    """Deformed shapes side by side, coloured by displacement, over the outline at rest.

    Args:
        body: The body.
        rows: Shapes of each row, as many in one as in the other.
        view: Where the body is looked at from.
        name: Name of the picture's files.
        title: Its title.
        caption: What is said of it, besides scales.
        beside: What is drawn besides the body.
    """
    skin = skin_of(body)
    unit = unit_for(np.array([[s.magnitude.max() for s in row.shapes] for row in rows]), "m")
    places = [[skin.moved(s.displacement, row.factor) for s in row.shapes] for row in rows]
    drawn_places = [each for row in places for each in row]
    everywhere = np.vstack([skin.places, *drawn_places, *(each.extent for each in beside)])
    camera = Camera.around(everywhere, view, pixels=_PANEL, slenderness=0.3)
    scenes = [
        Scene([*_outline(skin), _coloured(skin, moved, shape, row, unit), *beside], camera)
        for row, drawn in zip(rows, places, strict=True)
        for shape, moved in zip(row.shapes, drawn, strict=True)
    ]

    def finish(images: Sequence[Image]) -> Plot:
        columns = len(rows[0].shapes)
        width = max(WIDTH, 2.0 * columns + 0.8)
        height = (_height(camera, columns, width) + 0.45) * len(rows)
        figure = new_figure(height, width)
        grid, fill = grid_of(figure, camera, len(rows), columns)
        for row, panels, drawn in zip(rows, grid, _split(images, columns), strict=True):
            for axes, shape, image in zip(panels, row.shapes, drawn, strict=True):
                fill(axes, image)
                axes.set_title(shape.name, fontsize=8 * width / WIDTH)
            norm = Normalize(*_limits(row, unit))
            bar = figure.colorbar(ScalarMappable(norm, SIZE), ax=list(panels), shrink=0.85)
            label_bar(bar, f"{row.label}  ({unit.name})")
            bar.ax.yaxis.label.set_fontsize(9 * width / WIDTH)
            bar.ax.tick_params(labelsize=8 * width / WIDTH)
        without_bands(figure)
        return Plot(name, title, caption + _factors(rows, unit), "body", figure)

    return Plan(scenes, finish)


def _outline(skin: Skin) -> list[Layer]:
    return [Lines(skin.places[skin.edges], OUTLINE, 1.2)]


def _coloured(skin: Skin, moved: Array, shape: Shape, row: Row, unit: Unit) -> Faces:
    """A deformed shape coloured by its displacement."""
    values = unit.factor * shape.magnitude[skin.source]
    lit = skin.dim == 3
    return Faces(moved, skin.faces, values=values, limits=_limits(row, unit), colours=SIZE,
                 lit=lit)  # fmt: skip


def _limits(row: Row, unit: Unit) -> tuple[float, float]:
    largest = max(float(shape.magnitude.max()) for shape in row.shapes)
    return 0.0, unit.factor * largest or 1.0


def _factors(rows: Sequence[Row], unit: Unit) -> str:
    """How many times displacements are enlarged."""
    if len({row.factor for row in rows}) == 1:
        drawn = f"Displacements are drawn {_times(rows[0].factor)}"
    else:
        drawn = "Drawn are: " + ", ".join(f"{row.label} {_times(row.factor)}" for row in rows)
    return f" Colours: displacement in {unit.name}. {drawn}; lines: at rest."


def _times(factor: float) -> str:
    return "to scale" if factor == 1 else f"{factor:g} times as large"


def _split(images: Sequence[Image], columns: int) -> list[Sequence[Image]]:
    return [images[start : start + columns] for start in range(0, len(images), columns)]


def _height(camera: Camera, columns: int, width: float = WIDTH) -> float:
    """Height in inches of a row of so many panels."""
    return float(np.clip(height_over_width(camera) * width / columns, 0.7, 6.0))


def plan_energies(results: Results, body: StoredBranch, view: View) -> Plan:
    """The shape at the instant of the largest motion, an energy a panel."""
    fields = [
        displacement_of(body, point, _largest_at(body, point, results.tip))
        for point in results.chosen
    ]
    shapes = [
        Shape(
            f"gamma ratio {point.gamma_ratio:.4g}\n{point.motion.frequency:.5g} Hz",
            field,
        )
        for point, field in zip(results.chosen, fields, strict=True)
    ]
    factor = factor_for(skin_of(body), fields)
    obstacle = obstacle_layers(results, body, factor)
    return plan_shapes(
        body,
        [Row("displacement", factor, shapes)],
        view,
        name="mode_shapes",
        title="Shapes at several energies",
        caption=f"Nonlinear mode {results.header.mode} at the instant of the largest displacement "
        f"of the node that moves most, at chosen energies.{WORDS if obstacle else ''}",
        beside=obstacle,
    )
