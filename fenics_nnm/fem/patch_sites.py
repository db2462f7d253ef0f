"""Where a patch can touch: its vertices, with directions, gaps and rows of displacement."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array, Complex, Indices, Mask
from fenics_nnm.errors import GeometryError, MeshError, ModelError
from fenics_nnm.fem.deformed import deformed
from fenics_nnm.fem.facing import Counterparts, counterparts
from fenics_nnm.fem.patch_vertices import PatchVertices
from fenics_nnm.fem.rows import Entries
from fenics_nnm.fem.solid import Solid

Field = Callable[[Array, Array], Array]
Nearing = Callable[[Array, Array, Array], Array]
Passed = Callable[[Array, Array], Mapping[int, Complex]]


def standing(points: Array, directions: Array) -> Mapping[int, Complex]:
    """Gaps to an obstacle that turns with the body do not move."""
    return {}


#: Part of a contact direction along free axes below which a vertex cannot move along it.
_ALONG = 1e-9

#: Directions whose cosine differs from 1 by less are along the same line.
_SAME_LINE = 1e-9


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
        nearing: How much nearer in m steady loads bring points to their obstacle, of points
            before, points after and unit vectors (n, dim), where the gap is that before; None where
            it is a distance, which is measured after.
        passing: How gaps move as the body turns past its obstacle: complex amplitudes in m of
            harmonics of the speed, (n,) each, of points and unit vectors (n, 3).
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
    nearing: Nearing | None = None
    passing: Passed = standing

    def gaps(self, points: Array, places: Array, directions: Array) -> Array:
        """Gaps in m along unit vectors of points that steady loads move to places, (n, dim) each.

        Raises:
            GeometryError: if a direction does not meet the obstacle.
        """
        assert self.gap is not None
        if self.nearing is None:
            return self.gap(places, directions)
        return self.gap(points, directions) - self.nearing(points, places, directions)


@dataclass(frozen=True, slots=True)
class PatchSites:
    """Vertices of a patch that can become contact points, the same on all ranks.

    Attributes:
        patch: What is asked of the patch.
        vertices: Its vertices; with facets opposite, those that have a counterpart.
        places: Where steady loads move them, in m, shape (n, dim).
        directions: Unit vectors towards the obstacle, shape (n, dim).
        gap: Initial gaps in m, infinite where there is nothing to be met, shape (n,).
        entries: Of this rank: weights of displacement blocks in the displacement of each vertex,
            relative to that of its counterpart if it has one.
        left_out: Number of vertices without a counterpart.
    """

    patch: Patch
    vertices: PatchVertices
    places: Array
    directions: Array
    gap: Array
    entries: Entries
    left_out: int

    @property
    def points(self) -> Array:
        """Coordinates in m, shape (n, dim)."""
        return self.vertices.points

    @property
    def count(self) -> int:
        """Number of contact points that are asked for."""
        return len(self.gap) if self.patch.count is None else self.patch.count

    def shared_with(self, other: PatchSites, some: Indices) -> Mask:
        """Which vertices are among some of those of another patch, with the same line there."""
        _, own, theirs = np.intersect1d(
            self.vertices.numbers, other.vertices.numbers[some], return_indices=True
        )
        cosines = np.sum(self.directions[own] * other.directions[some[theirs]], axis=1)
        shared = np.zeros(len(self.gap), dtype=bool)
        shared[own] = np.abs(cosines) > 1 - _SAME_LINE
        return shared


def patch_sites(solid: Solid, patch: Patch) -> PatchSites:
    """Vertices of a patch that can become contact points; called on all ranks.

    Raises:
        MeshError: as `contact_interface`.
        ModelError: as `contact_interface`.
    """
    vertices = PatchVertices.of(solid, patch.facets, f"{patch.key}.facets", patch.what)
    _refuse_clamped(vertices, vertices.held.all(axis=1), patch)
    moved = _moved(solid, patch, vertices)
    directions = patch.direction(moved.points, moved.normals)
    _refuse_clamped(vertices, ~(np.abs(directions) * ~vertices.held > _ALONG).any(axis=1), patch)
    with deformed(solid):
        across = _across(solid, patch, moved, directions)
    left_out = int(np.count_nonzero(~across.met))
    vertices, directions = vertices.chosen(np.flatnonzero(across.met)), directions[across.met]
    places = moved.points[across.met]
    _refuse_few(patch, len(directions))
    return PatchSites(
        patch=patch,
        vertices=vertices,
        places=places,
        directions=directions,
        gap=_gaps(patch, vertices.points, places, directions, across.distance[across.met]),
        entries=vertex_entries(vertices, np.arange(len(directions))).minus(_rows_met(across)),
        left_out=left_out,
    )


def _moved(solid: Solid, patch: Patch, vertices: PatchVertices) -> PatchVertices:
    """The vertices where steady loads move them."""
    if solid.state is None:
        return vertices
    with deformed(solid):
        return PatchVertices.of(solid, patch.facets, f"{patch.key}.facets", patch.what)


def opposite_vertices(solid: Solid, patch: Patch) -> PatchVertices:
    """Vertices of the facets opposite to a patch that has such facets; called on all ranks."""
    assert patch.opposite is not None
    key = f"{patch.key}.against"
    return PatchVertices.of(solid, patch.opposite.facets, key, patch.opposite.what)


def vertex_entries(vertices: PatchVertices, chosen: Indices) -> Entries:
    """Weight 1 of each of some vertices, on the rank that owns it."""
    mine = np.flatnonzero(vertices.local[chosen] >= 0)
    return Entries(mine, vertices.blocks[chosen[mine]], np.ones(len(mine)))


def _refuse_clamped(vertices: PatchVertices, clamped: Any, patch: Patch) -> None:
    if clamped.any():
        place = ", ".join(f"{x:.6g}" for x in vertices.points[np.argmax(clamped)])
        raise MeshError(
            f"{patch.key}.facets = {patch.what}: {int(clamped.sum())} vertices are clamped too, "
            f"one at ({place}) m: contact facets must not touch the clamp"
        )


def _refuse_few(patch: Patch, found: int) -> None:
    if patch.count is not None and patch.count > found:
        raise MeshError(
            f"{patch.key}.points = {patch.count}: {patch.what} has only {found} vertices"
        )


def _across(solid: Solid, patch: Patch, vertices: PatchVertices, directions: Array) -> Counterparts:
    """Counterparts of the vertices; all of them are met where there is a rigid obstacle.

    A vertex that is its own counterpart has none.
    """
    if patch.opposite is None:
        every = np.ones(len(vertices.points), dtype=bool)
        nothing = np.empty(0, dtype=np.int64)
        return Counterparts(every, np.full(len(every), np.inf), nothing, Entries.joined([]))
    across = counterparts(solid, patch.opposite.facets, vertices.points, directions)
    met = across.met & ~np.isin(vertices.numbers, opposite_vertices(solid, patch).numbers)
    if not met.any():
        raise ModelError(
            f"{patch.key}.against = {patch.opposite.what}: is not met by any line from "
            f"{patch.what} along the contact direction: must lie opposite"
        )
    return replace(across, met=met)


def _rows_met(across: Counterparts) -> Entries:
    """Rows of the counterparts of the vertices that are met, which are counted anew."""
    entries = across.entries
    kept = across.met[entries.rows]
    number = np.cumsum(across.met) - 1
    return Entries(number[entries.rows[kept]], entries.blocks[kept], entries.values[kept])


def _gaps(patch: Patch, points: Array, places: Array, directions: Array, distance: Array) -> Array:
    """Gaps of vertices; a vertex without an obstacle in its way is never in contact."""
    if patch.gap is None:
        return distance
    try:
        return patch.gaps(points, places, directions)
    except GeometryError:
        rows = ([i] for i in range(len(points)))
        each = [_gap_of(patch, points[i], places[i], directions[i]) for i in rows]
        return np.concatenate(each)


def _gap_of(patch: Patch, point: Array, place: Array, direction: Array) -> Array:
    try:
        return patch.gaps(point, place, direction)
    except GeometryError:
        return np.array([np.inf])
