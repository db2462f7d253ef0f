"""One contact patch: its points, their obstacle, and the pressure that their forces make."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.errors import MeshError, ModelError
from fenics_nnm.fem.averaged_rows import averaged_entries
from fenics_nnm.fem.facing import Counterparts, counterparts
from fenics_nnm.fem.patch_vertices import PatchVertices
from fenics_nnm.fem.rows import Entries, owned_rows
from fenics_nnm.fem.solid import Solid

Field = Callable[[Array, Array], Array]

#: Distances that differ by less than this part of a patch's size are the same.
_TIE = 1e-9


#: Part of a contact direction along free axes below which a vertex cannot move along it.
_ALONG = 1e-9


@dataclass(frozen=True, slots=True)
class Opposite:
    """Facets of the same mesh that a patch can meet.

    Attributes:
        facets: Local facets.
        what: Names of the facets, for messages.
    """

    facets: Indices
    what: str


@dataclass(frozen=True, slots=True)
class Patch:
    """What is asked of a contact patch.

    Attributes:
        key: Place in the study file, for messages.
        name: Name of the patch.
        facets: Local facets.
        what: Names of the facets, for messages.
        direction: Unit vectors towards the obstacle, of points and outward normals (n, dim).
        gap: Initial gaps in m, of points and unit vectors (n, dim); None for the distance to the
            facets opposite.
        count: Number of points to spread evenly over the vertices, or None for all vertices.
        opposite: Facets that the patch can meet in place of a rigid obstacle.
        averaged: Whether contact points have the mean displacement of the area about them, in
            place of that of their vertex; not with facets opposite.
    """

    key: str
    name: str
    facets: Indices
    what: str
    direction: Field
    gap: Field | None
    count: int | None = None
    opposite: Opposite | None = None
    averaged: bool = False


@dataclass(frozen=True, slots=True)
class PatchPoints:
    """Contact points of a patch, as in `ContactInterface`.

    Attributes:
        points: Coordinates in m, shape (n, dim).
        directions: Unit vectors, shape (n, dim).
        areas: Tributary areas in m^2, shape (n,).
        gap: Initial gaps in m, shape (n,).
        weights: Weights of the owned displacement blocks, shape (n, owned blocks).
        pressures: Pressure at owned vertices under unit forces, shape (owned vertices, n).
        left_out: Number of vertices without a counterpart.
    """

    points: Array
    directions: Array
    areas: Array
    gap: Array
    weights: csr_array
    pressures: csr_array
    left_out: int


def patch_points(solid: Solid, patch: Patch) -> PatchPoints:
    """Contact points of a patch.

    Raises:
        MeshError: as `contact_interface`.
        ModelError: as `contact_interface`.
        GeometryError: as `contact_interface`.
    """
    vertices = PatchVertices.of(solid, patch.facets, f"{patch.key}.facets", patch.what)
    _refuse_clamped(vertices, vertices.held.all(axis=1), patch)
    directions = patch.direction(vertices.points, vertices.normals)
    _refuse_clamped(vertices, ~(np.abs(directions) * ~vertices.held > _ALONG).any(axis=1), patch)
    met = _met(solid, patch, vertices, directions)
    left_out = int(np.count_nonzero(~met))
    vertices, directions = vertices.chosen(np.flatnonzero(met)), directions[met]
    chosen = _chosen(patch, vertices)
    points, directions = vertices.points[chosen], directions[chosen]
    nearest = _nearest(vertices.points, points)
    if patch.averaged:
        entries = averaged_entries(solid, patch.facets, vertices, nearest)
    else:
        entries = _vertex_entries(vertices, chosen)
    owned = solid.tagged.mesh.topology.index_map(0).size_local
    pressures = _pressures(vertices, nearest, len(chosen), owned)
    gap = None if patch.gap is None else patch.gap(points, directions)
    if patch.opposite is not None:
        across = counterparts(solid, patch.opposite.facets, points, directions)
        entries = entries.minus(across.entries)
        pressures = pressures + _opposite_pressures(
            solid, patch, across, points + across.distance[:, None] * directions
        )
        gap = across.distance if gap is None else gap
    assert gap is not None
    return PatchPoints(
        points=points,
        directions=directions,
        areas=np.bincount(nearest, weights=vertices.areas, minlength=len(chosen)).astype(float),
        gap=gap,
        weights=owned_rows(solid, entries, len(chosen)),
        pressures=pressures,
        left_out=int(left_out),
    )


def spread(points: Array, count: int) -> Indices:
    """Indices of `count` points that lie far from each other, ascending.

    Starts with the point farthest from the centre and adds the one farthest from all chosen.
    """
    distance = np.linalg.norm(points - points.mean(axis=0), axis=1)
    tie = _TIE * float(distance.max())
    chosen = [_farthest(distance, tie)]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(_farthest(distance, tie))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.sort(np.array(chosen, dtype=np.int64))


def _farthest(distance: Array, tie: float) -> int:
    """The first of the largest distances, which may differ by round-off."""
    return int(np.argmax(distance >= distance.max() - tie))


def _refuse_clamped(vertices: PatchVertices, clamped: Any, patch: Patch) -> None:
    if clamped.any():
        place = ", ".join(f"{x:.6g}" for x in vertices.points[np.argmax(clamped)])
        raise MeshError(
            f"{patch.key}.facets = {patch.what}: {int(clamped.sum())} vertices are clamped too, "
            f"one at ({place}) m: contact facets must not touch the clamp"
        )


def _met(solid: Solid, patch: Patch, vertices: PatchVertices, directions: Array) -> Mask:
    """Which vertices have a counterpart other than themselves, if they need one."""
    if patch.opposite is None:
        return np.ones(len(vertices.points), dtype=bool)
    across = counterparts(solid, patch.opposite.facets, vertices.points, directions)
    met = across.met & ~np.isin(vertices.numbers, _opposite_vertices(solid, patch).numbers)
    if not met.any():
        raise ModelError(
            f"{patch.key}.against = {patch.opposite.what}: is not met by any line from "
            f"{patch.what} along the contact direction: must lie opposite"
        )
    return met


def _opposite_vertices(solid: Solid, patch: Patch) -> PatchVertices:
    assert patch.opposite is not None
    key = f"{patch.key}.against"
    return PatchVertices.of(solid, patch.opposite.facets, key, patch.opposite.what)


def _chosen(patch: Patch, vertices: PatchVertices) -> Indices:
    found = len(vertices.points)
    if patch.count is None:
        return np.arange(found)
    if patch.count > found:
        raise MeshError(
            f"{patch.key}.points = {patch.count}: {patch.what} has only {found} vertices"
        )
    return spread(vertices.points, patch.count)


def _nearest(points: Array, centres: Array) -> Indices:
    distances = np.linalg.norm(points[:, None, :] - centres[None, :, :], axis=2)
    return np.argmin(distances, axis=1)


def _vertex_entries(vertices: PatchVertices, chosen: Indices) -> Entries:
    """Weight 1 of the vertex of each contact point, on the rank that owns it."""
    mine = np.flatnonzero(vertices.local[chosen] >= 0)
    return Entries(mine, vertices.blocks[chosen[mine]], np.ones(len(mine)))


def _pressures(vertices: PatchVertices, point: Indices, count: int, owned: int) -> csr_array:
    """Force over tributary area at the owned vertices, each of which belongs to one point.

    Args:
        vertices: Vertices of the patch.
        point: Contact point of each vertex.
        count: Number of contact points.
        owned: Number of vertices that this rank owns.
    """
    area = np.bincount(point, weights=vertices.areas, minlength=count)
    mine = np.flatnonzero(vertices.local >= 0)
    at = (vertices.local[mine], point[mine])
    return csr_array(coo_array((1 / area[point[mine]], at), shape=(owned, count)))


def _opposite_pressures(
    solid: Solid, patch: Patch, across: Counterparts, places: Array
) -> csr_array:
    """Pressure on the facets opposite: the whole force of each point, spread over vertices there.

    A vertex of the facets that are met belongs to the counterpart nearest to it; a counterpart
    without vertices acts on the nearest one.

    Args:
        solid: Assembled body.
        patch: Patch with facets opposite.
        across: Counterparts of its contact points.
        places: Where they are in m, shape (n, dim).
    """
    every = _opposite_vertices(solid, patch)
    vertices = every.chosen(np.flatnonzero(np.isin(every.numbers, across.corners)))
    owned = solid.tagged.mesh.topology.index_map(0).size_local
    count, point = len(places), _nearest(vertices.points, places)
    pressures = _pressures(vertices, point, count, owned)
    alone = np.setdiff1d(np.arange(count), point)
    at = _nearest(places[alone], vertices.points)
    mine = vertices.local[at] >= 0
    single = (1 / vertices.areas[at[mine]], (vertices.local[at[mine]], alone[mine]))
    return csr_array(pressures + coo_array(single, shape=(owned, count)))
