"""An animation of one period of a motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from fenics_nnm.arrays import Array, Indices, in_space
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.output.pictures.body import contact_balls, factor_for
from fenics_nnm.output.pictures.obstacle import WORDS, obstacle_layers
from fenics_nnm.output.pictures.panels import (
    Animation,
    Plan,
    height_over_width,
    legend_of,
    show,
)
from fenics_nnm.output.pictures.renderer import Image
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.scene import Camera, Faces, Layer, Lines, Scene, View, size_of
from fenics_nnm.output.pictures.skin import Skin, skin_of
from fenics_nnm.output.pictures.style import OUTLINE, RED, SIZE, label_bar, new_figure, unit_for
from fenics_nnm.results.stored_branch import StoredBranch

#: Frames of a period.
FRAMES = 30

#: Width of a frame in inches, its dots per inch, and most height over width.
_WIDTH, _DPI, _SLENDEREST = 4.6, 110, 1.3

#: Least width of a frame in inches: the title and the legend have room.
_NARROWEST = 3.2

#: Longer side of the drawn scene in pixels.
_PIXELS = 480


def plan_animation(results: Results, body: StoredBranch, view: View) -> Plan:
    """The last of the chosen motions over one period, with balls where it is in contact."""
    point, skin = results.chosen[-1], skin_of(body)
    time = np.arange(FRAMES) / FRAMES
    phase = 2 * np.pi * time + results.middle(point) - np.pi
    fields = body.displacement(point, phase)
    pressed = results.forces(point, phase) > 0
    factor = factor_for(skin, list(fields))
    magnitude = np.linalg.norm(fields, axis=2)
    unit = unit_for(magnitude, "m")
    limits = (0.0, unit.factor * float(magnitude.max()) or 1.0)
    places = [skin.moved(field, factor) for field in fields]
    obstacle = obstacle_layers(results, body, factor)
    everywhere = np.vstack([skin.places, *places, *(each.extent for each in obstacle)])
    camera = Camera.around(everywhere, view, pixels=_PIXELS)
    scenes = []
    for frame, moved in enumerate(places):
        faces = Faces(
            moved,
            skin.faces,
            values=unit.factor * magnitude[frame][skin.source],
            limits=limits,
            colours=SIZE,
            lit=skin.dim == 3,
        )
        outline = Lines(skin.places[skin.edges], OUTLINE, 1.2)
        balls = _touching(body, skin, fields[frame], np.flatnonzero(pressed[frame]), factor)
        scenes.append(Scene([outline, faces, *obstacle, *balls], camera))

    def finish(images: Sequence[Image]) -> Animation:
        bar = ScalarMappable(Normalize(*limits), SIZE)
        frames = _frames(images, camera, time, bar, f"displacement  ({unit.name})", _title(point))
        times = "to scale" if factor == 1 else f"{factor:g} times as large"
        caption = (
            f"One period of nonlinear mode {results.header.mode} at gamma ratio "
            f"{point.gamma_ratio:.4g} ({point.motion.frequency:.5g} Hz). Colours: displacement in "
            f"{unit.name}, drawn {times}; lines: at rest; red balls: contact points that touch. "
            f"The middle of contact is at t / T = 0.5.{_overlap(body, factor)}"
            f"{WORDS if obstacle else ''}"
        )
        return Animation("motion", "Motion over one period", caption, "body", frames)

    return Plan(scenes, finish)


def _overlap(body: StoredBranch, factor: float) -> str:
    """Why patches that face each other seem to overlap where displacements are enlarged."""
    if factor == 1 or not body.facet_side.any():
        return ""
    return " Gaps are not enlarged, so facing patches seem to pass through each other."


def _touching(
    body: StoredBranch, skin: Skin, field: Array, touching: Indices, factor: float
) -> list[Layer]:
    """Balls at the contact points that touch, where they have moved to."""
    if not len(touching):
        return []
    moved = field[body.contact_nodes[touching]]
    places = body.contact_points[touching] + factor * in_space(moved)
    return [contact_balls(places, size_of(skin.places))]


def _title(point: BranchPoint) -> str:
    return f"gamma ratio {point.gamma_ratio:.4g}, {point.motion.frequency:.5g} Hz"


def _size(slenderness: float) -> tuple[float, float]:
    """Height and width in inches of a frame that fits a panel of a height over its width."""
    panel = min(_SLENDEREST, slenderness) * _WIDTH * 0.8
    return panel + 0.7, float(np.clip(panel / slenderness + 1.2, _NARROWEST, _WIDTH))


def _frames(
    images: Sequence[Image],
    camera: Camera,
    time: Array,
    bar: ScalarMappable,
    label: str,
    title: str,
) -> list[Image]:
    """Drawn scenes with a scale of colours and the time."""
    figure = new_figure(*_size(height_over_width(camera)))
    axes = figure.subplots()
    show(axes, images[0], camera)
    label_bar(figure.colorbar(bar, ax=axes, shrink=0.85), label)
    heading = axes.set_title("", fontsize=9)
    legend_of(figure, [("ball", RED, "in contact"), ("line", OUTLINE, "at rest")])
    figure.set_dpi(_DPI)
    canvas = FigureCanvasAgg(figure)
    frames = []
    for image, instant in zip(images, time, strict=True):
        axes.images[0].set_data(image)
        heading.set_text(f"{title}, t / T = {instant:.2f}")
        canvas.draw()
        frames.append(np.asarray(canvas.buffer_rgba())[:, :, :3].copy())
    return frames
