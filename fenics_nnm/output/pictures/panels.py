"""Drawn scenes as panels of a figure, with what gives them a scale."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fenics_nnm.output.pictures.gif import write_gif
from fenics_nnm.output.pictures.renderer import Image
from fenics_nnm.output.pictures.scene import Camera, Scene
from fenics_nnm.output.pictures.style import Plot, Unit, unit_for

#: Room below a picture for its scale and its axes, as a part of its longer side.
_FOOT = 0.15

#: Most rounds in which a figure is made lower, and the part of its height that may be blank;
#: least height over width, with which the words beside the scale of colours have room.
_ROUNDS, _BLANK, _LEAST = 4, 0.01, 0.42

#: The scale is about this part of the width.
_SCALE = 0.25

#: Length of the axes of the body in points.
_ARROW = 17.0

#: Axes of the body are drawn where they are seen longer than this, of 1.
_SEEN = 0.25


@dataclass(frozen=True, slots=True)
class Animation:
    """Frames of a motion.

    Attributes:
        name: Name of its file, without the ending.
        title: A few words.
        caption: What is seen, with units.
        group: As for `Plot`.
        frames: Pictures of one size, shown in a loop.
    """

    name: str
    title: str
    caption: str
    group: str
    frames: Sequence[Image]

    def save(self, folder: Path, formats: Sequence[str]) -> tuple[str, ...]:
        """Write it as a GIF, whatever the formats of plots; the name of its file.

        Raises:
            OSError: if it cannot be written.
        """
        write_gif(folder / f"{self.name}.gif", self.frames)
        return (f"{self.name}.gif",)


@dataclass(frozen=True, slots=True)
class Plan:
    """A picture whose scenes are still to be drawn.

    Attributes:
        scenes: What is to be drawn.
        finish: Makes the picture of the drawn scenes.
    """

    scenes: Sequence[Scene]
    finish: Callable[[Sequence[Image]], Plot | Animation]


def show(
    axes: Axes, image: Image, camera: Camera, *, scaled: bool = True, foot: bool = True
) -> None:
    """A picture, with a scale that is true to its lengths and the axes of the body below it.

    Args:
        axes: Where to draw.
        image: The picture.
        camera: What part of space it shows.
        scaled: Whether to draw scale and axes.
        foot: Whether there is room for them.
    """
    left, right, bottom, top = camera.extent
    below = _FOOT * max(right - left, top - bottom) if foot else 0.0
    axes.imshow(image, extent=camera.extent, interpolation="antialiased")
    axes.set_ylim(bottom - below, top)
    axes.axis("off")
    if scaled:
        _draw_scale(axes, camera, bottom - 0.4 * below)
        _draw_axes(axes, camera, bottom - 0.7 * below)


def height_over_width(camera: Camera, *, foot: bool = True) -> float:
    """Of a panel, with or without its foot."""
    width, height = camera.high - camera.low
    return float((height + (_FOOT * max(width, height) if foot else 0.0)) / width)


def grid_of(
    figure: Figure, camera: Camera, rows: int, columns: int
) -> tuple[Any, Callable[[Axes, Image], None]]:
    """Panels of one camera, of which those of the last row have a foot, and how to fill them.

    Returns:
        The panels, row by row, and `show` with the panel and the image: the first panel of the
        last row has the scale.
    """
    ratios = [height_over_width(camera, foot=row == rows - 1) for row in range(rows)]
    grid = figure.subplots(rows, columns, squeeze=False, height_ratios=ratios)

    def fill(axes: Axes, image: Image) -> None:
        last = axes in grid[-1]
        show(axes, image, camera, scaled=axes is grid[-1, 0], foot=last)

    return grid, fill


def without_bands(figure: Figure) -> None:
    """Make a figure as low as its panels let it be.

    Panels keep the ratio of their sides. Where they are as wide as there is room, what is left of
    the height is blank.
    """
    for _ in range(_ROUNDS):
        figure.draw_without_rendering()
        panels = [axes for axes in figure.axes if axes.images]
        rows: dict[int, float] = {}
        for axes in panels:
            row = axes.get_subplotspec().rowspan.start  # type: ignore[union-attr]
            slot, used = axes.get_position(original=True), axes.get_position()
            rows[row] = min(rows.get(row, np.inf), slot.height - used.height)
        width, height = figure.get_size_inches()
        lower = max(height * (1 - sum(rows.values())), _LEAST * width)
        if lower > (1 - _BLANK) * height:
            return
        figure.set_size_inches(width, lower)


def round_below(value: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above a positive value."""
    power = 10.0 ** np.floor(np.log10(value) + 1e-9)
    return float(max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))


def legend_of(figure: Figure, entries: Sequence[tuple[str, str, str]], columns: int = 2) -> None:
    """A legend below a figure of patches ("face"), lines ("line") and balls ("ball").

    Args:
        figure: Figure.
        entries: Kind, colour and name of each.
        columns: Number of columns.
    """
    handles = [_handle(kind, colour, name) for kind, colour, name in entries]
    if handles:
        figure.legend(
            handles=handles, loc="outside lower center", ncols=columns, fontsize=8, frameon=False
        )


def _handle(kind: str, colour: str, name: str) -> Patch | Line2D:
    if kind == "face":
        return Patch(facecolor=colour, edgecolor="0.4", lw=0.5, label=name)
    if kind == "line":
        return Line2D([], [], color=colour, lw=2, label=name)
    return Line2D([], [], ls="", marker="o", color=colour, ms=5, label=name)


def _scale(camera: Camera) -> tuple[float, Unit]:
    """Length of the scale in m, and the unit that it is written in."""
    left, right, _, _ = camera.extent
    length = round_below(_SCALE * (right - left))
    return length, unit_for(np.array([length]), "m")


def scale_words(camera: Camera) -> str:
    """Length of the scale below a picture, with its unit."""
    length, unit = _scale(camera)
    return f"{length * unit.factor:g} {unit.name}"


def _draw_scale(axes: Axes, camera: Camera, height: float) -> None:
    left, right, _, _ = camera.extent
    length, _ = _scale(camera)
    start = left + 0.04 * (right - left)
    axes.plot([start, start + length], [height, height], color="black", lw=1.5)
    name = f"{scale_words(camera)}\n"
    axes.text(start + length / 2, height, name, ha="center", va="center", fontsize=7.5)


def _draw_axes(axes: Axes, camera: Camera, height: float) -> None:
    left, right, _, _ = camera.extent
    for letter, rightwards, upwards in zip("xyz", *camera.frame[:2], strict=True):
        if np.hypot(rightwards, upwards) < _SEEN:
            continue
        axes.annotate(
            letter,
            xy=(right - 0.2 * (right - left), height),
            xytext=(_ARROW * rightwards, _ARROW * upwards),
            textcoords="offset points",
            arrowprops={"arrowstyle": "<-", "lw": 0.8, "shrinkA": 1, "shrinkB": 0},
            ha="center",
            va="center",
            fontsize=7.5,
            annotation_clip=False,
        )
