"""The mesh of a study with its named groups, contact points and clamp, before it is run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from fenics_nnm.arrays import Array, Indices, in_space
from fenics_nnm.errors import OutputError
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.mesh_groups import MeshGroups, gathered_groups
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.output.pictures.body import BODY, contact_balls
from fenics_nnm.output.pictures.casing_sheet import CASING_TINT, casing_layers
from fenics_nnm.output.pictures.panels import height_over_width, legend_of, show
from fenics_nnm.output.pictures.renderer import Image, RenderError, render
from fenics_nnm.output.pictures.scene import (
    Arrows,
    Balls,
    Camera,
    Faces,
    Layer,
    Lines,
    Scene,
    View,
    size_of,
)
from fenics_nnm.output.pictures.sight import Sight
from fenics_nnm.output.pictures.skin import Skin, best_view, skin_around
from fenics_nnm.output.pictures.style import BLACK, OUTLINE, colours_of_parts, new_figure, unit_for
from fenics_nnm.results.durable import replacing
from fenics_nnm.study.casing import AnyCasing

#: Length of the arrows at contact points, as a part of the size of the body.
_ARROW = 0.09

#: Longer side of a panel in pixels, its width in inches, and dots per inch of the file.
_PIXELS, _WIDTH, _DOTS = 900, 4.6, 150

#: So many facets of a group, spread evenly, tell what of it is hidden.
_TRIED = 60

Entry = tuple[str, str, str]
"""Kind, colour and name of an entry of the legend."""

#: Names of groups stand so far apart, beside and above each other, in points, and in such boxes.
_APART = np.array([60.0, 13.0])
_BOX = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "0.5", "lw": 0.5, "alpha": 0.85}


def draw_groups(
    path: Path,
    tagged: TaggedMesh,
    roles: Mapping[str, str],
    interface: ContactInterface | None = None,
    casings: Mapping[int, AnyCasing] | None = None,
) -> None:
    """Draw a mesh with its groups, and with its contact points and casings if they are known.

    A solid is drawn from two opposite sides. To be called on all ranks.

    Args:
        path: Picture file to write.
        tagged: The mesh.
        roles: What named groups are there for.
        interface: Contact points.
        casings: Casings by the number of their patch; drawn if there are contact points.

    Raises:
        OutputError: if there is no renderer, or the file cannot be written.
    """
    groups = gathered_groups(tagged)

    def draw() -> None:
        assert groups is not None  # as this is rank 0
        try:
            _draw(path, groups, roles, interface, casings or {})
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
    casings: Mapping[int, AnyCasing],
) -> None:
    skin = skin_around(groups.nodes, groups.faces, groups.dim)
    directions = interface.directions if interface else np.empty((0, groups.dim))
    front = best_view(skin, directions)
    views = [front, front.opposite] if groups.dim == 3 else [front]
    layers = [*_body(groups, skin), *_facets(groups, skin, roles)]
    if interface:
        layers += _contact(interface, size_of(skin.places))
        layers += _casings(interface, casings, size_of(skin.places))
    places = np.vstack([skin.places, *(layer.reach for layer in layers)])
    cameras = [Camera.around(places, view, pixels=_PIXELS, slenderness=0.3) for view in views]
    images = render([Scene(layers, camera) for camera in cameras])
    entries = _entries(groups, roles, interface)
    entries += _casing_entries(interface, casings) if interface else []
    _compose(path, groups, entries, views, cameras, images)


def _compose(
    path: Path,
    groups: MeshGroups,
    entries: Sequence[Entry],
    views: Sequence[View],
    cameras: Sequence[Camera],
    images: Sequence[Image],
) -> None:
    """Panels beside each other, with names at the groups and a legend."""
    height = max(height_over_width(camera) for camera in cameras) * _WIDTH
    height = float(np.clip(height, 1.5, 7.5)) + 0.3 + 0.2 * -(-len(entries) // 3)
    figure = new_figure(height, _WIDTH * len(views))
    panels = figure.subplots(1, len(views), squeeze=False)[0]
    for axes, camera, image in zip(panels, cameras, images, strict=True):
        show(axes, image, camera)
    legend_of(figure, entries, columns=2 if len(views) == 1 else 4)
    figure.draw_without_rendering()
    named = _named_places(groups, cameras)
    for axes, camera, places in zip(panels, cameras, named, strict=True):
        _name(axes, camera, places)
    with replacing(path) as part:
        figure.savefig(part, format=path.suffix[1:], dpi=_DOTS)


def _named_places(groups: MeshGroups, cameras: Sequence[Camera]) -> list[dict[str, Array]]:
    """Names and places of the groups in each view: each group where more of it is seen."""
    found: list[dict[str, Array]] = [{} for _ in cameras]
    faces = groups.nodes[groups.faces] if groups.dim == 3 else np.empty((0, 3, 3))
    sights = [Sight.of(faces, camera.frame) for camera in cameras]
    for name, corners in groups.facets.items():
        if not len(corners):
            continue
        centres = groups.nodes[corners].mean(axis=1)
        turned = [seen_areas(groups, corners, camera) for camera in cameras]
        seen = [unhidden(*each, centres) for each in zip(sights, turned, strict=True)]
        hidden = not any(areas.any() for areas in seen)
        areas = turned if hidden else seen
        number = int(np.argmax([each.sum() for each in areas]))
        text = f"{name} (hidden)" if hidden else name
        found[number][text] = _middle(centres, areas[number])
    return found


def _body(groups: MeshGroups, skin: Skin) -> list[Layer]:
    """The faces, those of each group of cells alike, and the outline."""
    layers: list[Layer] = [Faces(skin.places, skin.faces, BODY, edges=True)]
    if len(groups.cells) > 1:
        colours = colours_of_parts(len(groups.cells), light=True)
        layers = [
            Faces(skin.places, skin.faces[rows], colour, edges=True)
            for colour, rows in zip(colours, groups.cells.values(), strict=True)
            if len(rows)
        ]
    return [*layers, Lines(skin.places[skin.edges], OUTLINE, 1.5)]


def _facets(groups: MeshGroups, skin: Skin, roles: Mapping[str, str]) -> list[Layer]:
    """Groups of facets: faces of a solid, edges of a plane body, ends of a rod.

    Those that are held or in contact come last, over others with the same facets.
    """
    layers: list[Layer] = []
    colours = dict(zip(groups.facets, colours_of_parts(len(groups.facets)), strict=True))
    for name in sorted(groups.facets, key=lambda name: name in roles):
        colour, corners = colours[name], groups.facets[name]
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


def _casings(
    interface: ContactInterface, casings: Mapping[int, AnyCasing], size: float
) -> list[Layer]:
    dim = interface.points.shape[1]
    return [
        layer
        for number, casing in casings.items()
        for layer in casing_layers(
            casing.surface(), interface.points[interface.patch == number], size, dim
        )
    ]


def _entries(
    groups: MeshGroups, roles: Mapping[str, str], interface: ContactInterface | None
) -> list[Entry]:
    """Groups and contact points in the legend."""
    kind = {3: "face", 2: "line", 1: "ball"}[groups.dim]
    entries = []
    colours = colours_of_parts(len(groups.facets))
    for colour, (name, corners) in zip(colours, groups.facets.items(), strict=True):
        notes = [f"{len(corners)} facets", roles.get(name) or _covered(groups, corners, roles)]
        entries.append((kind, colour, f"{name} ({', '.join(filter(None, notes))})"))
    if len(groups.cells) > 1:
        colours = colours_of_parts(len(groups.cells), light=True)
        entries += [
            ("face", colour, f"cells {name}")
            for colour, name in zip(colours, groups.cells, strict=True)
        ]
    if interface:
        gap = unit_for(interface.gap, "m")
        low, high = gap.factor * interface.gap.min(), gap.factor * interface.gap.max()
        gaps = f"{low:.4g}" if np.isclose(low, high) else f"{low:.4g} to {high:.4g}"
        entries.append(("ball", BLACK, f"{interface.count} contact points, gap {gaps} {gap.name}"))
    return entries


def _covered(groups: MeshGroups, corners: Indices, roles: Mapping[str, str]) -> str:
    """The groups with a role that are drawn over all of a group, or nothing."""
    over = {frozenset(f): name for name in roles for f in groups.facets.get(name, ())}
    found = {over.get(frozenset(facet), "") for facet in corners}
    return f"part of {', '.join(sorted(found))}" if found and "" not in found else ""


def _casing_entries(interface: ContactInterface, casings: Mapping[int, AnyCasing]) -> list[Entry]:
    """Casings in the legend, with the patch where there are several."""
    entries = []
    for number, casing in casings.items():
        of = f" of {interface.names[number]}" if len(interface.names) > 1 else ""
        entries.append(("face", CASING_TINT, f"{casing.word}{of} ({casing.shape})"))
    return entries


def seen_areas(groups: MeshGroups, corners: Indices, camera: Camera) -> Array:
    """Area of each facet as the viewer sees it, shape (f,), 0 if it is turned away.

    Args:
        groups: The mesh. Facets of a plane body or a rod all count 1.
        corners: Corners of the facets of a group, shape (f, 1 to 4).
        camera: Where it is seen from.
    """
    if groups.dim < 3:
        return np.ones(len(corners))
    outwards = {frozenset(face): face for face in groups.faces}
    turned = np.array([outwards.get(frozenset(facet), facet) for facet in corners])
    places = groups.nodes[turned]
    normals = np.cross(places[:, 1] - places[:, 0], places[:, -1] - places[:, 0])
    whole = 2 if corners.shape[1] == 3 else 1  # of the triangle, of the parallelogram
    return np.asarray(np.maximum(normals @ camera.frame[2], 0) / whole)


def unhidden(sight: Sight, areas: Array, centres: Array) -> Array:
    """Areas of the facets that nothing hides, of some of them if there are many, shape (f,).

    Args:
        sight: The whole surface as it is seen.
        areas: Of each facet as the viewer sees it, 0 if it is turned away.
        centres: Of the facets, m, shape (f, 3).
    """
    (turned,) = np.nonzero(areas)
    tried = turned[:: -(-len(turned) // _TRIED) or 1]
    rows = [row for row in tried if not sight.hides(centres[row])]
    found = np.zeros(len(areas))
    found[rows] = areas[rows] * len(turned) / max(1, len(tried))
    return found


def _middle(centres: Array, areas: Array) -> Array:
    """A place near the middle of what is seen of a group: the centre of one of its facets."""
    seen = areas > 0 if areas.any() else np.ones(len(areas), dtype=bool)
    centres = centres[seen]
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
