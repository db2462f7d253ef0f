"""The mesh of a study with its named groups, contact points and clamp, before it is run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.errors import OutputError
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.mesh_groups import MeshGroups, gathered_groups
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.output.pictures.body import BODY, OUTLINE, contact_balls, size_of
from fenics_nnm.output.pictures.panels import height_over_width, legend_of, show
from fenics_nnm.output.pictures.renderer import Image, RenderError, render
from fenics_nnm.output.pictures.scene import Arrows, Balls, Camera, Faces, Layer, Lines, Scene, View
from fenics_nnm.output.pictures.skin import Skin, best_view, skin_around
from fenics_nnm.output.pictures.style import BLACK, CURVES, new_figure, unit_for
from fenics_nnm.study import MeshStudy, Study

#: Colours of groups of facets, and light ones of groups of cells; then from the beginning.
_FACETS = [colour for colour, _ in CURVES[:-1]]
_CELLS = ("#d7dee6", "#f0e6c8", "#d9ead3", "#ead1dc", "#cfe2f3", "#fce5cd")

#: Length of the arrows at contact points, as a part of the size of the body.
_ARROW = 0.09

#: Longer side of a panel in pixels, its width in inches, and dots per inch of the file.
_PIXELS, _WIDTH, _DOTS = 900, 4.6, 150

#: Names of groups stand so far apart, beside and above each other, in points, and in such boxes.
_APART = np.array([60.0, 13.0])
_BOX = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "0.5", "lw": 0.5, "alpha": 0.85}


def roles_of(study: Study) -> dict[str, str]:
    """What groups of facets are there for: held, or in contact."""
    if not isinstance(study, MeshStudy):
        return {}
    clamped = dict.fromkeys(study.clamp.facets if study.clamp else (), "clamped")
    patches = study.contact.patches.values()
    touching = [name for patch in patches for name in (*patch.facets, *(patch.against or ()))]
    return {**clamped, **dict.fromkeys(touching, "contact")}


def draw_groups(
    path: Path,
    tagged: TaggedMesh,
    roles: Mapping[str, str],
    interface: ContactInterface | None = None,
) -> None:
    """Draw a mesh with its groups, and with its contact points if they are known.

    A solid is drawn from two opposite sides. To be called on all ranks.

    Args:
        path: Picture file to write.
        tagged: The mesh.
        roles: What named groups are there for.
        interface: Contact points.

    Raises:
        OutputError: if there is no renderer, or the file cannot be written.
    """
    groups = gathered_groups(tagged)

    def draw() -> None:
        assert groups is not None  # as this is rank 0
        try:
            _draw(path, groups, roles, interface)
        except RenderError as error:
            raise OutputError(f"{path}: cannot be drawn: {error}") from error
        except OSError as error:
            raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error

    on_root(tagged.mesh.comm, draw)


def _draw(
    path: Path,
    groups: MeshGroups,
    roles: Mapping[str, str],
    interface: ContactInterface | None,
) -> None:
    skin = skin_around(groups.nodes, groups.faces, groups.dim)
    directions = interface.directions if interface else np.empty((0, groups.dim))
    front = best_view(skin, directions)
    views = [front, front.opposite] if groups.dim == 3 else [front]
    layers = [*_body(groups, skin), *_facets(groups, skin)]
    if interface:
        layers += _contact(interface, size_of(skin.places))
    places = np.vstack([skin.places, *(_arrow_ends(layer) for layer in layers)])
    cameras = [Camera.around(places, view, pixels=_PIXELS, slenderness=0.3) for view in views]
    images = render([Scene(layers, camera) for camera in cameras])
    _compose(path, groups, roles, interface, views, cameras, images)


def _compose(
    path: Path,
    groups: MeshGroups,
    roles: Mapping[str, str],
    interface: ContactInterface | None,
    views: Sequence[View],
    cameras: Sequence[Camera],
    images: Sequence[Image],
) -> None:
    """Panels beside each other, with names at the groups and a legend."""
    entries = _entries(groups, roles, interface)
    height = max(height_over_width(camera) for camera in cameras) * _WIDTH
    height = float(np.clip(height, 1.5, 7.5)) + 0.3 + 0.2 * -(-len(entries) // 3)
    figure = new_figure(height, _WIDTH * len(views))
    panels = figure.subplots(1, len(views), squeeze=False)[0]
    for axes, camera, image in zip(panels, cameras, images, strict=True):
        show(axes, image, camera)
    legend_of(figure, entries, columns=2 if len(views) == 1 else 4)
    figure.draw_without_rendering()
    turned = [_turned_to(groups, camera) for camera in cameras]
    for number, (axes, camera) in enumerate(zip(panels, cameras, strict=True)):
        shown = [
            name
            for name in groups.facets
            if len(groups.facets[name]) and int(np.argmax([t[name] for t in turned])) == number
        ]
        _name(axes, camera, {name: _middle(groups, name) for name in shown})
    figure.savefig(path, dpi=_DOTS)


def _body(groups: MeshGroups, skin: Skin) -> list[Layer]:
    """The faces, those of each group of cells alike, and the outline."""
    layers: list[Layer] = [Faces(skin.places, skin.faces, BODY, edges=True)]
    if len(groups.cells) > 1:
        layers = [
            Faces(skin.places, skin.faces[rows], _CELLS[number % len(_CELLS)], edges=True)
            for number, rows in enumerate(groups.cells.values())
            if len(rows)
        ]
    return [*layers, Lines(skin.places[skin.edges], OUTLINE, 1.5)]


def _facets(groups: MeshGroups, skin: Skin) -> list[Layer]:
    """Groups of facets: faces of a solid, edges of a plane body, ends of a rod."""
    layers: list[Layer] = []
    for number, corners in enumerate(groups.facets.values()):
        colour = _FACETS[number % len(_FACETS)]
        if not len(corners):
            continue
        if groups.dim == 3:
            layers.append(Faces(groups.nodes, corners, colour, edges=True))
        elif groups.dim == 2:
            layers.append(Lines(groups.nodes[corners], colour, 6.0))
        else:
            ends = groups.nodes[corners[:, 0]]
            radius = np.full(len(ends), 0.012 * size_of(skin.places))
            layers.append(Balls(ends, radius, colour))
    return layers


def _contact(interface: ContactInterface, size: float) -> list[Layer]:
    places, directions = in_space(interface.points), in_space(interface.directions)
    return [contact_balls(places, size, BLACK), Arrows(places, _ARROW * size * directions, BLACK)]


def _arrow_ends(layer: Layer) -> Array:
    return layer.places + layer.vectors if isinstance(layer, Arrows) else np.empty((0, 3))


def _entries(
    groups: MeshGroups, roles: Mapping[str, str], interface: ContactInterface | None
) -> list[tuple[str, str, str]]:
    """Kind, colour and name of each entry of the legend."""
    kind = {3: "face", 2: "line", 1: "ball"}[groups.dim]
    entries = []
    for number, (name, corners) in enumerate(groups.facets.items()):
        told = [f"{len(corners)} facets", *([roles[name]] if name in roles else [])]
        entries.append((kind, _FACETS[number % len(_FACETS)], f"{name} ({', '.join(told)})"))
    if len(groups.cells) > 1:
        entries += [
            ("face", _CELLS[number % len(_CELLS)], f"cells {name}")
            for number, name in enumerate(groups.cells)
        ]
    if interface:
        gap = unit_for(interface.gap, "m")
        low, high = gap.factor * interface.gap.min(), gap.factor * interface.gap.max()
        gaps = f"{low:.4g}" if np.isclose(low, high) else f"{low:.4g} to {high:.4g}"
        entries.append(("ball", BLACK, f"{interface.count} contact points, gap {gaps} {gap.name}"))
    return entries


def _turned_to(groups: MeshGroups, camera: Camera) -> dict[str, float]:
    """How much of each group faces the viewer, away from the middle of the body."""
    inside = groups.nodes.mean(axis=0)
    found = {}
    for name, corners in groups.facets.items():
        places = groups.nodes[corners]
        outwards = places.mean(axis=1) - inside
        found[name] = float((outwards @ camera.frame[2]).sum()) if len(corners) else 0.0
    return found


def _middle(groups: MeshGroups, name: str) -> Array:
    """A place of a group near its middle: that of one of its facets."""
    centres: Array = groups.nodes[groups.facets[name]].mean(axis=1)
    return np.asarray(centres[np.linalg.norm(centres - centres.mean(axis=0), axis=1).argmin()])


def _name(axes: Axes, camera: Camera, places: Mapping[str, Array]) -> None:
    """Write the names of groups at their places, one above the other where they would meet."""
    taken: list[Array] = []
    for name, place in places.items():
        at = camera.seen(place[None])[0]
        dots = axes.transData.transform(at) * 72 / axes.figure.dpi
        up = 0.0
        while any(np.all(np.abs(dots - other) < _APART) for other in taken):
            up += _APART[1]
            dots[1] += _APART[1]
        taken.append(dots)
        axes.annotate(
            name,
            tuple(at),
            xytext=(0, up),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8,
            bbox=_BOX,
            arrowprops={"arrowstyle": "-", "lw": 0.5} if up else None,
        )
