"""A blade as a solid with named faces: between sections, in its passage, on a disk sector.

A bladed sector is three volumes that share faces: the block, the collar with the fillet, and the
blade above it. Their meshes fit, so together they are one body.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from pydantic import Field

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.collar import section_at, widened
from fenics_nnm.geometry.loft import loft, shared_curves
from fenics_nnm.geometry.parameters import GeometryRecord, GmshModel, Length
from fenics_nnm.geometry.passage import (
    add_ring,
    cut_between,
    extent,
    joined,
    lies_on,
    outer_faces,
    reaching,
    samples,
)
from fenics_nnm.geometry.section_lines import SectionLines
from fenics_nnm.geometry.walls import Wall

_FLAT = 1e-7  # of the size: tolerance for a plane face


class RootBlock(GeometryRecord):
    """Sector of a disk below the hub, and the fillet between it and the airfoil."""

    blades: Annotated[int, Field(ge=2, le=1000, strict=True)] = Field(
        description="blades of the row: the sector is 360 degrees over their number"
    )
    bore: Length = Field(description="inner radius of the disk, in length_unit")
    overhang: Length = Field(
        description="axial length of the block before and behind the airfoil, in length_unit"
    )
    fillet: Length | None = Field(
        default=None, description="fillet radius in length_unit; without it a sharp corner"
    )


@dataclass(frozen=True, slots=True)
class Part:
    """What of a gmsh model is a blade: tags of its volumes and named faces.

    Attributes:
        cells: Volumes of each named part.
        faces: Faces of each named group.
        edges: Spanwise curves along the leading and trailing edges.
        foot: Curves around the fillet; none without.
    """

    cells: dict[str, list[int]]
    faces: dict[str, list[int]]
    edges: list[int]
    foot: list[int] = field(default_factory=list)


def between_sections(gmsh_model: GmshModel, lines: list[SectionLines]) -> Part:
    """The blade between its first and its last section."""
    solid = loft(gmsh_model, lines)
    faces = {"root": [solid.root], "tip": [solid.tip], "surface": solid.surface}
    return Part({"blade": [solid.volume]}, faces, solid.edges)


def in_passage(
    gmsh_model: GmshModel,
    lines: list[SectionLines],
    hub: Wall | None,
    tip: Wall | None,
    block: RootBlock | None,
) -> Part:
    """The blade between two walls, one of which may be missing, on its block if it has one.

    Raises:
        GeometryError: The sections do not reach the walls, or the block is too small.
    """
    lines = reaching(lines, hub, tip)
    if hub is None or block is None:
        return _cut_blade(gmsh_model, lines, hub, tip)
    axial, theta = _block_room(lines, hub, block)
    walls: list[Wall | None] = [hub, tip]
    if block.fillet is not None:
        lines = widened(lines, hub, block.fillet)
        walls.insert(1, hub.raised(block.fillet))
    solid = loft(gmsh_model, lines)
    pieces = cut_between(gmsh_model, solid.volume, lines, walls)
    bore = Wall(np.array(axial), np.full(2, block.bore), np.zeros(2))
    pieces = [add_ring(gmsh_model.occ, bore, hub, axial, theta), *pieces]
    volumes = dict(zip(_names(len(pieces)), joined(gmsh_model, pieces), strict=True))
    return _named(gmsh_model, volumes, (bore, hub, tip), axial, theta)


def _names(count: int) -> tuple[str, ...]:
    return ("block", "blade") if count == 2 else ("block", "collar", "blade")


def _cut_blade(
    gmsh_model: GmshModel, lines: list[SectionLines], hub: Wall | None, tip: Wall | None
) -> Part:
    """The blade alone, cut by one or two walls."""
    solid = loft(gmsh_model, lines)
    volumes = joined(gmsh_model, cut_between(gmsh_model, solid.volume, lines, [hub, tip]))
    faces: dict[str, list[int]] = {"root": [], "tip": [], "surface": []}
    skin = outer_faces(gmsh_model, volumes[0], volumes)
    points = {face: samples(gmsh_model, face) for face in skin}
    radius = {face: float(np.hypot(*points[face][:, 1:].T).mean()) for face in skin}
    for name, wall, end in (("root", hub, min), ("tip", tip, max)):
        on = [face for face in skin if wall is not None and lies_on(wall, points[face])]
        faces[name] = on or [end(skin, key=lambda face: radius[face])]
    ends = faces["root"] + faces["tip"]
    faces["surface"] = [face for face in skin if face not in ends]
    return Part({"blade": volumes}, faces, shared_curves(gmsh_model, faces["surface"]))


def _block_room(
    lines: Sequence[SectionLines], hub: Wall, block: RootBlock
) -> tuple[tuple[float, float], tuple[float, float]]:
    """First and last x and angle of the block."""
    wide = block.fillet or 0.0
    if block.overhang <= wide:
        raise GeometryError(
            f"mesh.block.overhang = {block.overhang:g}: must be larger than fillet = {wide:g}"
        )
    (x0, x1), (t0, t1) = extent([section_at(lines, hub, 0.0, 0.0)])
    axial = (x0 - block.overhang, x1 + block.overhang)
    lowest = hub.at(np.linspace(*axial, 50)).min()
    t0, t1 = t0 - wide / lowest, t1 + wide / lowest
    sector, middle = 2 * np.pi / block.blades, (t0 + t1) / 2
    if t1 - t0 >= sector:
        raise GeometryError(
            f"mesh.block.blades = {block.blades}: a sector of {np.degrees(sector):.3g} degrees is "
            f"narrower than the foot of the blade, which takes {np.degrees(t1 - t0):.3g}: must be "
            f"{int(2 * np.pi / (t1 - t0))} or fewer"
        )
    if block.bore >= lowest:
        raise GeometryError(
            f"mesh.block.bore = {block.bore:g}: must be below the radius of the hub, {lowest:.4g}"
        )
    return axial, (middle - sector / 2, middle + sector / 2)


def _named(
    gmsh_model: GmshModel,
    volumes: dict[str, int],
    walls: tuple[Wall, Wall, Wall | None],
    axial: tuple[float, float],
    theta: tuple[float, float],
) -> Part:
    """Sort the outer faces of block, fillet and blade into groups."""
    bore, hub, tip = walls
    every = list(volumes.values())
    skin = {name: outer_faces(gmsh_model, tag, every) for name, tag in volumes.items()}
    points = {face: samples(gmsh_model, face) for faces in skin.values() for face in faces}
    faces: dict[str, list[int]] = {"root": [], "bore": [], "sides": [], "ends": [], "platform": []}
    for face in skin["block"]:
        faces[_block_group(points[face], bore, hub, axial)].append(face)
    faces["root"] = faces["bore"] + faces["sides"]
    faces["tip"] = [
        face for face in skin["blade"] if tip is not None and lies_on(tip, points[face])
    ]
    if tip is None:
        faces["tip"] = [
            max(skin["blade"], key=lambda face: np.hypot(*points[face][:, 1:].T).mean())
        ]
    faces["surface"] = [face for face in skin["blade"] if face not in faces["tip"]]
    edges = shared_curves(gmsh_model, faces["surface"])
    if "collar" not in volumes:
        return Part({name: [tag] for name, tag in volumes.items()}, faces, edges)
    faces["fillet"] = skin["collar"]
    around = [(2, face) for face in faces["fillet"]]
    foot = [tag for _, tag in gmsh_model.getBoundary(around, combined=False, oriented=False)]
    cells = {name: [tag] for name, tag in volumes.items()}
    return Part(cells, faces, edges, sorted(set(foot)))


def _block_group(points: np.ndarray, bore: Wall, hub: Wall, axial: tuple[float, float]) -> str:
    """Group of a face of the block."""
    if lies_on(hub, points):
        return "platform"
    if lies_on(bore, points):
        return "bore"
    return "ends" if np.ptp(points[:, 0]) < _FLAT * np.ptp(axial) else "sides"
