"""Groups of facets picked by where they lie: each condition holds for some facets of a surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.boundary import Boundary, boundary
from fenics_nnm.fem.mesh import TaggedMesh

#: Distance over the size of a facet within which its corners lie on a plane or cylinder.
TOLERANCE = 1e-3

Vector = tuple[float, ...]


class Condition(Protocol):
    """What facets must be like."""

    def holds(self, surface: Boundary, tolerance: Array) -> Any:
        """Where it holds, shape (n,); all corners of a facet within its tolerance in m."""

    def words(self, surface: Boundary) -> str:
        """The condition, and what of its kind the surface has, for messages."""


@dataclass(frozen=True, slots=True)
class Plane:
    """Facets in a plane through a point in m, with any normal."""

    point: Vector
    normal: Vector

    def _distance(self, surface: Boundary) -> Array:
        normal = _unit(self.normal, surface.dim, "normal")
        return (surface.corners - _fitted(self.point, surface.dim, "point")) @ normal

    def holds(self, surface: Boundary, tolerance: Array) -> Any:
        """Where all corners lie in the plane."""
        return np.abs(self._distance(surface)).max(axis=1) <= tolerance

    def words(self, surface: Boundary) -> str:
        """The plane, and how far from it the surface lies on both sides."""
        distance = self._distance(surface)
        return (
            f"plane through {_shown(self.point)}: the surface lies between "
            f"{distance.min():.6g} and {distance.max():.6g} m from it along {_shown(self.normal)}"
        )


@dataclass(frozen=True, slots=True)
class Level:
    """Facets at one value of x, y or z in m."""

    axis: int
    value: float

    def _of(self, surface: Boundary) -> Array:
        if self.axis >= surface.dim:
            raise MeshError(f"{'xyz'[self.axis]} = {self.value:g}: the mesh has no such axis")
        return surface.corners[:, :, self.axis]

    def holds(self, surface: Boundary, tolerance: Array) -> Any:
        """Where all corners have that value."""
        return np.abs(self._of(surface) - self.value).max(axis=1) <= tolerance

    def words(self, surface: Boundary) -> str:
        """The value, and the values that the surface has."""
        x, name = self._of(surface), "xyz"[self.axis]
        return f"{name} = {self.value:g}: {_range(name, x.min(), x.max())}"


@dataclass(frozen=True, slots=True)
class Radii:
    """Facets between two radii in m about an axis; on a cylinder if the two are equal."""

    axis: Vector
    origin: Vector
    low: float
    high: float

    def _apart(self, surface: Boundary, points: Array) -> Array:
        """Vectors from the axis to points of shape (..., dim)."""
        apart = points - _fitted(self.origin, surface.dim, "origin")
        if surface.dim == 3:
            axis = _unit(self.axis, 3, "axis")
            return np.asarray(apart - (apart @ axis)[..., None] * axis)
        if any(self.axis[: surface.dim]):
            raise MeshError(f"axis = {_shown(self.axis)}: must be normal to the mesh: [0, 0, 1]")
        return apart

    def _radius(self, surface: Boundary) -> Array:
        return np.asarray(np.linalg.norm(self._apart(surface, surface.corners), axis=2))

    def holds(self, surface: Boundary, tolerance: Array) -> Any:
        """Where all corners lie between the radii.

        Facets of a cylinder face its axis too: a flat end may have facets with all corners on it.
        """
        radius = self._radius(surface)
        inside = (radius.min(axis=1) >= self.low - tolerance) & (
            radius.max(axis=1) <= self.high + tolerance
        )
        if self.low < self.high:
            return inside
        apart = self._apart(surface, surface.centres)
        along = np.abs(np.sum(apart * surface.normals, axis=1))
        return inside & (along > np.linalg.norm(apart, axis=1) / 2)

    def words(self, surface: Boundary) -> str:
        """The radii, and those that the surface has."""
        radius = self._radius(surface)
        asked = f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"
        return f"radius {asked} m: {_range('the radius', radius.min(), radius.max())}"


@dataclass(frozen=True, slots=True)
class Box:
    """Facets inside a box with faces along the axes, its two corners in m."""

    low: Vector
    high: Vector

    def holds(self, surface: Boundary, tolerance: Array) -> Any:
        """Where all corners lie inside."""
        low, high = (_fitted(v, surface.dim, "from and to") for v in (self.low, self.high))
        inside = (surface.corners >= low - tolerance[:, None, None]) & (
            surface.corners <= high + tolerance[:, None, None]
        )
        return inside.all(axis=(1, 2))

    def words(self, surface: Boundary) -> str:
        """The box, and that of the surface."""
        low, high = (f(surface.corners.reshape(-1, surface.dim), axis=0) for f in (np.min, np.max))
        return (
            f"box from {_shown(self.low)} to {_shown(self.high)}: the surface is from "
            f"{_shown(low)} to {_shown(high)} m"
        )


@dataclass(frozen=True, slots=True)
class Facing:
    """Facets whose outward normal lies within an angle in degrees of a direction."""

    direction: Vector
    angle: float

    def _angles(self, surface: Boundary) -> Array:
        cosine = surface.normals @ _unit(self.direction, surface.dim, "direction")
        return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1, 1))))

    def holds(self, surface: Boundary, tolerance: Array) -> Any:
        """Where the normal is near the direction."""
        return self._angles(surface) <= self.angle

    def words(self, surface: Boundary) -> str:
        """The direction, and the nearest normal."""
        return (
            f"facing {_shown(self.direction)} within {self.angle:g} degrees: the nearest normal is "
            f"{self._angles(surface).min():.4g} degrees away"
        )


@dataclass(frozen=True, slots=True)
class Nearest:
    """The facet nearest to a point in m, and those joined to it without a sharp edge.

    Attributes:
        point: Point in m.
        angle: Largest angle in degrees between the normals of two neighbours of the group.
    """

    point: Vector
    angle: float

    def holds(self, surface: Boundary, tolerance: Array) -> Any:
        """Where facets belong to the patch of the nearest one."""
        first = int(np.argmin(_distances(surface, _fitted(self.point, surface.dim, "point"))))
        if surface.dim == 1:
            return np.arange(len(surface.local)) == first
        patch = smooth_patches(surface, self.angle)
        return patch == patch[first]

    def words(self, surface: Boundary) -> str:
        """The point."""
        return f"nearest to {_shown(self.point)}"


@dataclass(frozen=True, slots=True)
class Named:
    """Facets of groups that the mesh has; local facets of this rank."""

    names: tuple[str, ...]
    facets: Indices

    def holds(self, surface: Boundary, tolerance: Array) -> Any:
        """Where facets belong to the groups."""
        return surface.mask(self.facets) != 0

    def words(self, surface: Boundary) -> str:
        """The names."""
        return "facets of " + ", ".join(f'"{name}"' for name in self.names)


@dataclass(frozen=True, slots=True)
class Pick:
    """A group: all conditions hold.

    Attributes:
        conditions: At least one.
        tolerance: Distance in m, or None for `TOLERANCE` times the size of each facet.
    """

    conditions: Sequence[Condition]
    tolerance: float | None = None


def with_groups(tagged: TaggedMesh, picks: Mapping[str, Pick]) -> TaggedMesh:
    """A mesh with groups picked on its surface besides its own.

    Raises:
        MeshError: if a group picks nothing, its name is one of the mesh, or a condition does not
            fit the dimension of the mesh; the same on all ranks.
    """
    if not picks:
        return tagged
    surface = boundary(tagged.mesh)
    facets = dict(tagged.facets)
    for name, pick in picks.items():
        if name in tagged.facets:
            raise MeshError(f"groups.{name}: the mesh has a group of that name: must be another")
        try:
            facets[name] = surface.facets(_picked(surface, pick))
        except MeshError as error:
            raise MeshError(f"groups.{name}: {error}") from error
    return replace(tagged, facets=facets)


def _picked(surface: Boundary, pick: Pick) -> Indices:
    tolerance = TOLERANCE * surface.sizes
    if pick.tolerance is not None:
        tolerance = np.full(len(tolerance), pick.tolerance)
    masks = [condition.holds(surface, tolerance) for condition in pick.conditions]
    mask = np.logical_and.reduce(masks)
    if not mask.any():
        reasons = "; ".join(
            f"{condition.words(surface)} ({int(alone.sum())} facets by itself)"
            for condition, alone in zip(pick.conditions, masks, strict=True)
        )
        raise MeshError(f"picks no facet of the surface: {reasons}")
    return mask.astype(np.int64)


def smooth_patches(surface: Boundary, angle: float) -> Indices:
    """Number of the patch of each facet; sharp edges, by their angle in degrees, divide patches."""
    width = surface.vertices.shape[1]
    ring = np.stack([surface.vertices, np.roll(surface.vertices, -1, axis=1)], axis=2)
    if width == 4:  # dolfinx numbers the corners of a quadrangle like the bits of 0 to 3
        turned = surface.vertices[:, [0, 1, 3, 2]]
        ring = np.stack([turned, np.roll(turned, -1, axis=1)], axis=2)
    if width == 2:
        ring = surface.vertices[:, :, None]
    edges = np.sort(ring.reshape(-1, ring.shape[2]), axis=1)
    owner = np.repeat(np.arange(len(surface.vertices)), ring.shape[1])
    order = np.lexsort(edges.T)
    edges, owner = edges[order], owner[order]
    same = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    one, other = owner[same], owner[same + 1]
    smooth = np.sum(surface.normals[one] * surface.normals[other], axis=1) >= np.cos(
        np.radians(angle)
    )
    count = len(surface.vertices)
    joined = coo_array((np.ones(smooth.sum()), (one[smooth], other[smooth])), shape=(count, count))
    return np.asarray(connected_components(joined, directed=False)[1])


def _distances(surface: Boundary, point: Array) -> Array:
    """Distances of facets from a point: to the nearest place of the triangles of their corners."""
    if surface.corners.shape[1] < 3:
        start, end = surface.corners[:, 0], surface.corners[:, -1]
        return _to_segments(point, start, end)
    fans = [[0, 1, 2]] if surface.corners.shape[1] == 3 else [[0, 1, 3], [0, 3, 2]]
    return np.min([_to_triangles(point, surface.corners[:, fan]) for fan in fans], axis=0)


def _to_segments(point: Array, start: Array, end: Array) -> Array:
    along = end - start
    length = np.maximum(np.sum(along**2, axis=1), 1e-300)
    share = np.clip(np.sum((point - start) * along, axis=1) / length, 0, 1)
    return np.asarray(np.linalg.norm(point - start - share[:, None] * along, axis=1))


def _to_triangles(point: Array, corners: Array) -> Array:
    """Distance to the plane where the foot lies inside, else to the nearest side."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    sides = ((a, b), (b, c), (c, a))
    inside = np.all(
        [np.sum(np.cross(q - p, point - p) * normal, axis=1) >= 0 for p, q in sides], axis=0
    )
    height = np.abs(np.sum((point - a) * normal, axis=1))
    rim = np.min([_to_segments(point, p, q) for p, q in sides], axis=0)
    return np.where(inside, height, rim)


def _fitted(vector: Sequence[float], dim: int, name: str) -> Array:
    """A vector with as many components as the mesh has dimensions."""
    if len(vector) < dim or any(vector[dim:]):
        raise MeshError(f"{name} = {_shown(vector)}: must have {dim} components as the mesh has")
    return np.asarray(vector[:dim], dtype=float)


def _unit(vector: Sequence[float], dim: int, name: str) -> Array:
    fitted = _fitted(vector, dim, name)
    return np.asarray(fitted / np.linalg.norm(fitted))


def _shown(vector: Sequence[float] | Array) -> str:
    return "[" + ", ".join(f"{x:.6g}" for x in vector) + "]"


def _range(name: str, low: float, high: float) -> str:
    return f"{name} of the surface runs from {low:.6g} to {high:.6g} m"
