"""The shapes of the lowest linear modes, with their frequencies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from fenics_nnm.arrays import Array
from fenics_nnm.output.pictures.body import ENLARGED
from fenics_nnm.output.pictures.panels import Plan, grid_of, height_over_width, without_bands
from fenics_nnm.output.pictures.renderer import Image
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.scene import Camera, Faces, Lines, Scene, View, size_of
from fenics_nnm.output.pictures.skin import skin_of
from fenics_nnm.output.pictures.style import OUTLINE, SIZE, WIDTH, Plot, label_bar, new_figure
from fenics_nnm.results.stored_branch import StoredBranch

#: Most modes that are drawn, and how many stand side by side.
_MOST, _COLUMNS = 6, 3

#: Longer side of a panel in pixels.
_PIXELS = 500


def plan_linear(results: Results, body: StoredBranch, view: View) -> list[Plan]:
    """Shapes of the lowest linear modes; none where the model is written in other shapes."""
    hertz = results.summary.get("linear_frequencies_Hz", [])
    method = results.header.values.get("reduction", {}).get("method", "massless")
    count = min(_MOST, len(hertz), len(body.shapes))
    if not count or method == "craig-bampton" or results.model.at_rest().closed.any():
        return []
    skin = skin_of(body)
    fields = [_scaled(body.shapes[mode]) for mode in range(count)]
    places = [skin.moved(field, ENLARGED * size_of(skin.places)) for field in fields]
    camera = Camera.around(np.vstack([skin.places, *places]), view, pixels=_PIXELS, slenderness=0.3)
    scenes = [
        Scene(
            [
                Lines(skin.places[skin.edges], OUTLINE, 1.2),
                Faces(
                    moved,
                    skin.faces,
                    values=np.linalg.norm(field, axis=1)[skin.source],
                    colours=SIZE,
                    lit=skin.dim == 3,
                ),
            ],
            camera,
        )
        for field, moved in zip(fields, places, strict=True)
    ]

    def finish(images: Sequence[Image]) -> Plot:
        rows = -(-count // _COLUMNS)
        columns = -(-count // rows)
        height = float(np.clip(height_over_width(camera) * WIDTH / columns, 0.7, 4.0)) + 0.4
        figure = new_figure(height * rows, WIDTH)
        grid, fill = grid_of(figure, camera, rows, columns)
        panels = [axes for row in grid for axes in row]
        for axes in panels:
            axes.axis("off")
        for mode, (axes, image) in enumerate(zip(panels, images, strict=False)):
            fill(axes, image)
            axes.set_title(f"mode {mode + 1}\n{hertz[mode]:.5g} Hz", fontsize=8)
        scale = ScalarMappable(Normalize(0, 1), SIZE)
        bar = figure.colorbar(scale, ax=panels, shrink=0.8, aspect=20 * rows)
        label_bar(bar, "displacement  (1)")
        without_bands(figure)
        caption = (
            f"Shapes of the {count} lowest linear modes with their frequencies in Hz, without "
            "contact, each drawn with the same largest displacement. Colours: displacement over "
            "its largest. Lines: at rest."
        )
        return Plot("linear_modes", "Linear modes", caption, "linear", figure)

    return [Plan(scenes, finish)]


def _scaled(shape: Array) -> Array:
    """A shape whose longest displacement is 1."""
    return np.asarray(shape / np.linalg.norm(shape, axis=1).max())
