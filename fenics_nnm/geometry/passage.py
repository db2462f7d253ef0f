"""A blade cut by the walls of its passage, and a sector of the disk below it."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.parameters import GmshModel
from fenics_nnm.geometry.section_lines import SectionLines
from fenics_nnm.geometry.walls import Wall

_BEYOND = 2e-3  # of the span: what a section must be beyond a wall to be cut cleanly
_FARTHEST = 0.25  # of the span: largest extension of the last section
_ROOM = 0.1  # of the size of a blade: what a cutting volume is larger
_ON_WALL = 1e-7  # of the radius


def reaching(
    lines: Sequence[SectionLines], hub: Wall | None, casing: Wall | None
) -> list[SectionLines]:
    """Sections from the last one inside the hub to the first one outside the casing.

    Where the table ends before a wall, one more section continues its last two in a straight
    line.

    Raises:
        GeometryError: The table ends too far from a wall.
    """
    lines = list(lines)
    if casing is not None:
        lines = _crossing(lines, casing, +1, "casing")
    if hub is not None:
        lines = _crossing(lines[::-1], hub, -1, "hub")[::-1]
    return lines


def _crossing(
    lines: list[SectionLines], wall: Wall, outwards: int, name: str
) -> list[SectionLines]:
    """Sections up to the first one that lies beyond the wall with all its points."""
    span = abs(_radius(lines[-1].sides).mean() - _radius(lines[0].sides).mean())
    beyond = (
        [outwards * _height(line.sides, wall).min() > _BEYOND * span for line in lines]
        if (outwards > 0)
        else [_height(line.sides, wall).max() < -_BEYOND * span for line in lines]
    )
    if beyond[0]:
        raise GeometryError(f"mesh.{name}: all sections of the blade lie beyond it")
    if any(beyond):
        return lines[: beyond.index(True) + 1]
    last, before = lines[-1], lines[-2]
    for share in (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0):
        step = share * (last.sides - before.sides)
        if np.abs(step).max() > _FARTHEST * span:
            break
        sides = last.sides + step
        if (outwards * _height(sides, wall)).min() > _BEYOND * span:
            return [*lines, SectionLines(last.parameter, sides)]
    gap = (-outwards * _height(last.sides, wall)).max()
    raise GeometryError(
        f"mesh.{name}: lies up to {gap:.4g} beyond the last section there, further than "
        f"{_FARTHEST:.0%} of the span: give sections up to it"
    )


def _radius(points: np.ndarray) -> np.ndarray:
    return np.asarray(np.hypot(points[..., 1], points[..., 2]))


def _height(points: np.ndarray, wall: Wall) -> np.ndarray:
    """Radial distance of points outside a wall."""
    return _radius(points) - wall.at(points[..., 0])


def extent(lines: Iterable[SectionLines]) -> tuple[tuple[float, float], tuple[float, float]]:
    """First and last x, first and last angle of sections."""
    points = np.concatenate([line.sides.reshape(-1, 3) for line in lines])
    theta = np.arctan2(points[:, 1], points[:, 2])
    return (points[:, 0].min(), points[:, 0].max()), (theta.min(), theta.max())


def add_ring(
    occ: GmshModel,
    lower: Wall,
    upper: Wall,
    axial: tuple[float, float],
    theta: tuple[float, float],
) -> int:
    """Add the volume between two walls, two planes in x and two through the axis."""
    inner = lower.between(*axial).add_curve(occ, theta[0])
    outer = upper.between(*axial).add_curve(occ, theta[0])
    ends = [occ.addLine(inner[end], outer[end]) for end in (0, 1)]
    face = occ.addPlaneSurface([occ.addCurveLoop([inner[2], ends[1], -outer[2], -ends[0]])])
    swept = occ.revolve([(2, face)], 0, 0, 0, 1, 0, 0, theta[0] - theta[1])
    return next(tag for dim, tag in swept if dim == 3)


def cut_between(
    gmsh_model: GmshModel,
    volume: int,
    lines: Sequence[SectionLines],
    walls: Sequence[Wall | None],
) -> list[int]:
    """Cut a blade by walls; its parts between each and the next.

    Args:
        gmsh_model: The model.
        volume: The blade, which is used up.
        lines: Sections of the blade, for the room that it takes.
        walls: From the inside outwards; None, as first or last, stands for no cut.
    """
    occ = gmsh_model.occ
    (x0, x1), (t0, t1) = extent(lines)
    radii = _radius(np.concatenate([line.sides for line in lines], axis=1))
    room = _ROOM * max(x1 - x0, np.ptp(radii))
    axial, theta = (x0 - room, x1 + room), (t0 - room / radii.min(), t1 + room / radii.min())
    ends = (radii.min() - room, radii.max() + room)
    inner, outer = (Wall(np.array(axial), np.full(2, r), np.zeros(2)) for r in ends)
    bounds = [walls[0] or inner, *walls[1:-1], walls[-1] or outer]
    parts = []
    for lower, upper in pairwise([wall for wall in bounds if wall is not None]):
        ring = add_ring(occ, lower, upper, axial, theta)
        cut, _ = occ.intersect([(3, volume)], [(3, ring)], removeObject=False)
        if len(cut) != 1:
            raise GeometryError(f"the walls cut the blade into {len(cut)} pieces: must be one")
        parts.append(cut[0][1])
    occ.remove([(3, volume)], recursive=True)
    return parts


def joined(gmsh_model: GmshModel, volumes: Sequence[int]) -> list[int]:
    """Make touching volumes share their faces; their new tags, in order."""
    occ = gmsh_model.occ
    if len(volumes) > 1:
        _, (*fragments,) = occ.fragment([(3, volumes[0])], [(3, tag) for tag in volumes[1:]])
        if any(len(pieces) != 1 for pieces in fragments):
            raise GeometryError("blade, fillet and block do not join in one face each")
        volumes = [pieces[0][1] for pieces in fragments]
    occ.synchronize()
    return list(volumes)


def outer_faces(gmsh_model: GmshModel, volume: int, all_volumes: Sequence[int]) -> list[int]:
    """Faces of a volume that no other volume shares."""
    whole = [(3, tag) for tag in all_volumes]
    skin = {tag for _, tag in gmsh_model.getBoundary(whole, combined=True, oriented=False)}
    own = gmsh_model.getBoundary([(3, volume)], oriented=False)
    return [tag for _, tag in own if tag in skin]


def samples(gmsh_model: GmshModel, face: int) -> np.ndarray:
    """Nine points of the surface that a face is part of, shape (9, 3)."""
    low, high = gmsh_model.getParametrizationBounds(2, face)
    grid = [low[i] + (high[i] - low[i]) * np.array([0.2, 0.5, 0.8]) for i in range(2)]
    parameters = np.stack(np.meshgrid(*grid), axis=-1)
    return np.asarray(gmsh_model.getValue(2, face, parameters.ravel())).reshape(-1, 3)


def lies_on(wall: Wall, points: np.ndarray) -> bool:
    """Whether all points lie on a wall."""
    return bool(np.abs(_height(points, wall)).max() < _ON_WALL * _radius(points).max())
