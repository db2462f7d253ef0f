"""Pictures of a body: its mesh with the contact points, and deformed shapes.

Bodies are projected onto the plane of the picture without perspective, so that lengths in that
plane are true.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fenics_nnm.arrays import Array
from fenics_nnm.output.stored_branch import StoredBranch
from fenics_nnm.output.surface import face_normals, feature_edges, surface_faces

#: Brightness of the faces that are seen edgewise.
_DARKEST = 0.6

#: Colours of displacements: light where there is none.
_COLOURS = "YlGnBu"

_CAPTION = {"fontsize": 8.5, "color": "0.35"}

#: The three axes, the upward one last.
_AXES = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}


@dataclass(frozen=True, slots=True)
class View:
    """Where a body is looked at from.

    Attributes:
        elevation: Angle above the plane normal to the upward axis, in degrees.
        azimuth: Angle about the upward axis, in degrees.
        up: Axis that points upwards: x, y or z.
    """

    elevation: float = 20.0
    azimuth: float = -60.0
    up: str = "z"

    @property
    def frame(self) -> Array:
        """Unit vectors to the right, upwards, and towards the viewer, shape (3, 3)."""
        elevation, azimuth = np.radians([self.elevation, self.azimuth])
        sin_e, cos_e = np.sin(elevation), np.cos(elevation)
        sin_a, cos_a = np.sin(azimuth), np.cos(azimuth)
        frame = np.empty((3, 3))
        frame[:, list(_AXES[self.up])] = [
            [-sin_a, cos_a, 0.0],
            [-sin_e * cos_a, -sin_e * sin_a, cos_e],
            [cos_e * cos_a, cos_e * sin_a, sin_e],
        ]
        return frame


#: The x-y plane from above, for bodies in the plane.
PLANE = View(elevation=90.0, azimuth=-90.0)


@dataclass(frozen=True, slots=True)
class Deformed:
    """A deformed shape to draw.

    Attributes:
        name: Title of its panel.
        displacement: Displacement of all nodes in m, shape (n, dim).
    """

    name: str
    displacement: Array

    @property
    def magnitude(self) -> Array:
        """Length of the displacement of each node in mm, shape (n,)."""
        return 1e3 * np.linalg.norm(self.displacement, axis=1)


@dataclass(frozen=True, slots=True)
class Row:
    """Shapes side by side with one colour scale.

    Attributes:
        label: What is drawn, for the colour scale.
        factor: How many times displacements are enlarged.
        shapes: Deformed shapes.
    """

    label: str
    factor: float
    shapes: Sequence[Deformed]


def plot_contact_mesh(
    path: Path, branch: StoredBranch, *, title: str, view: View | None = None
) -> None:
    """The surface mesh with the contact points marked.

    Args:
        path: Picture file to write.
        branch: Branch of a body in the plane or in space.
        title: Title.
        view: Where it is looked at from.

    Raises:
        OutputError: if its cells have no faces.
    """
    faces = surface_faces(branch.cells, branch.cell_type)
    frame = (view or View()).frame
    seen = 1e3 * branch.nodes @ frame.T
    limits = _limits(seen[faces])
    figure = Figure(figsize=(5.4, 4.5 * _slenderness(limits) + 1.1), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    _draw_faces(axes, seen[faces], np.array([0.80, 0.85, 0.90, 1.0]), edge="0.35")
    contact = 1e3 * branch.contact_points @ frame.T
    count = len(contact)
    axes.plot(*contact[:, :2].T, "o", ms=5.5, mfc="#d55e00", mec="black", mew=0.6)
    _dress(axes, limits, frame)
    axes.set_ylabel("height in this view  (mm)")
    figure.suptitle(title, fontsize=11)
    figure.supxlabel(
        f"Surface of {len(branch.cells)} cells with {len(branch.nodes)} nodes; "
        f"circles: {count} contact points.",
        **_CAPTION,
    )
    figure.savefig(path, dpi=150)


def plot_deformed(
    path: Path,
    branch: StoredBranch,
    rows: Sequence[Row],
    *,
    title: str,
    caption: str = "",
    view: View | None = None,
) -> None:
    """Deformed shapes side by side, coloured by displacement, over the undeformed outline.

    Args:
        path: Picture file to write.
        branch: Branch of a body in the plane or in space.
        rows: Shapes of each row, as many in one as in the other.
        title: Title.
        caption: Text below the panels.
        view: Where the body is looked at from.

    Raises:
        OutputError: if its cells have no faces.
    """
    faces = surface_faces(branch.cells, branch.cell_type)
    frame = (view or View()).frame
    outline = 1e3 * branch.nodes[feature_edges(branch.nodes, faces)] @ frame.T
    corners = [
        [_displaced(branch, row.factor * s.displacement)[faces] @ frame.T for s in row.shapes]
        for row in rows
    ]
    limits = _limits(np.vstack([outline.reshape(-1, 3), np.reshape(corners, (-1, 3))]))
    height = (2.5 * _slenderness(limits) + 0.8) * len(rows) + 0.9
    figure = Figure(figsize=(3.3 * len(rows[0].shapes) + 1, height))
    FigureCanvasAgg(figure)
    figure.set_layout_engine("constrained", hspace=0.04)
    grid = figure.subplots(len(rows), len(rows[0].shapes), sharex=True, sharey=True, squeeze=False)
    for row, panels, drawn in zip(rows, grid, corners, strict=True):
        norm = Normalize(0, max(shape.magnitude.max() for shape in row.shapes))
        for shape, axes, places in zip(row.shapes, panels, drawn, strict=True):
            colours = colormaps[_COLOURS](norm(shape.magnitude[faces].mean(axis=1)))
            _draw_faces(axes, places, colours)
            axes.add_collection(LineCollection(list(outline[:, :, :2]), colors="0.1", lw=0.8))
            axes.set_title(shape.name, fontsize=9.5)
            _dress(axes, limits, frame)
        figure.colorbar(ScalarMappable(norm, _COLOURS), ax=panels, label=f"{row.label}  (mm)")
        panels[0].set_ylabel("height in this view  (mm)")
    figure.suptitle(title, fontsize=11)
    figure.supxlabel(caption, **_CAPTION)
    figure.savefig(path, dpi=150)


def _displaced(branch: StoredBranch, displacement: Array) -> Array:
    """Places of the displaced nodes in mm, shape (n, 3)."""
    missing = 3 - displacement.shape[1]
    return 1e3 * (branch.nodes + np.pad(displacement, ((0, 0), (0, missing))))


def _draw_faces(axes: Axes, corners: Array, colours: Array, edge: str | None = None) -> None:
    """Faces with corners of shape (faces, 3 or 4, 3), from the farthest to the nearest.

    Their brightness falls with the angle between face and picture plane.
    """
    order = np.argsort(corners[:, :, 2].mean(axis=1))
    shade = _DARKEST + (1 - _DARKEST) * np.abs(face_normals(corners)[:, 2])
    shaded = np.broadcast_to(colours, (len(corners), 4)).copy()
    shaded[:, :3] *= shade[:, None]
    axes.add_collection(
        PolyCollection(
            list(corners[order, :, :2]),
            facecolors=shaded[order],
            edgecolors=edge or shaded[order],
            linewidths=0.3,
        )
    )


def _limits(places: Array) -> Array:
    """Corners of a picture in mm that holds all places and a triad of axes below, (2, 2)."""
    flat = places.reshape(-1, 3)[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    size = (high - low).max()
    return np.array([low - size * np.array([0.05, 0.25]), high + 0.05 * size])


def _slenderness(limits: Array) -> float:
    """Height over width, within what a page can hold."""
    width, height = limits[1] - limits[0]
    return float(np.clip(height / width, 0.5, 1.7))


def _dress(axes: Axes, limits: Array, frame: Array) -> None:
    """Equal scales, labels, and the triad of axes."""
    axes.set_xlim(*limits[:, 0])
    axes.set_ylim(*limits[:, 1])
    axes.set_aspect("equal")
    axes.set_xlabel("width in this view  (mm)")
    axes.label_outer()
    for letter, axis in zip("xyz", np.eye(3), strict=True):
        right, up = float(frame[0] @ axis), float(frame[1] @ axis)
        if np.hypot(right, up) > 0.25:
            axes.annotate(
                letter,
                xy=(0.10, 0.06),
                xycoords="axes fraction",
                xytext=(30 * right, 30 * up),
                textcoords="offset points",
                arrowprops={"arrowstyle": "<-", "lw": 0.8, "shrinkA": 2, "shrinkB": 0},
                ha="center",
                va="center",
                fontsize=8,
            )
