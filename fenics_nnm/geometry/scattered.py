"""Values given at scattered points: linear between them, and how far other points lie outside.

Between points in a plane or in space the values are linear on Delaunay's triangles or tetrahedra
(C. B. Barber et al., ACM Trans. Math. Software 22 (1996) 469). Outside, the value is that at the
nearest place of the convex hull of the points, found by projections on its faces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import ConvexHull, Delaunay, QhullError, cKDTree

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import GeometryError

#: A place is in the hull where it is outside by less than this part of its size.
_ROUND_OFF = 1e-10

#: Places that projections have put on the hull are moved inwards by this part of its size.
_INWARDS = 1e-8

#: Projections of a place at most, and entries of an array that are dealt with at once.
_MOST_PROJECTIONS, _AT_ONCE = 200, 4_000_000


@dataclass(frozen=True, slots=True)
class Hull:
    """Convex hull of points in d dimensions: all x with normals x <= offsets.

    Attributes:
        normals: Outward unit normals of its faces, shape (f, d).
        offsets: Shape (f,), in m.
        centre: A point inside, shape (d,).
        size: Its largest extent in m.
    """

    normals: Array
    offsets: Array
    centre: Array
    size: float

    @classmethod
    def of(cls, points: Array) -> Hull:
        """The hull of points (n, d) in m, which do not all lie on a line or in a plane."""
        centre, size = points.mean(axis=0), float(np.ptp(points, axis=0).max())
        if points.shape[1] == 1:
            ends = np.array([points.max(), -points.min()])
            return cls(np.array([[1.0], [-1.0]]), ends, centre, size)
        equations = ConvexHull(points).equations
        return cls(equations[:, :-1], -equations[:, -1], centre, size)

    def beyond(self, places: Array) -> Array:
        """How far places (m, d) are outside of the face that they are farthest from, in m, (m,)."""
        excess = self._worst(places)[1]
        return np.where(excess > _ROUND_OFF * self.size, excess, 0.0)

    def pulled(self, places: Array) -> Array:
        """Places (m, d) in the hull that are nearest to some outside of it."""
        found = places.copy()
        for _ in range(_MOST_PROJECTIONS):
            face, excess = self._worst(found)
            if np.all(excess <= _ROUND_OFF * self.size):
                break
            found -= np.maximum(excess, 0.0)[:, None] * self.normals[face]
        inwards = self.centre - found
        return np.asarray(found + _INWARDS * inwards)

    def _worst(self, places: Array) -> tuple[Indices, Array]:
        """The face that each place is farthest outside of, and by how much."""
        rows = max(1, _AT_ONCE // len(self.offsets))
        face: Indices = np.zeros(len(places), dtype=np.int64)
        excess: Array = np.zeros(len(places))
        for start in range(0, len(places), rows):
            part = slice(start, start + rows)
            outside = places[part] @ self.normals.T - self.offsets
            face[part] = outside.argmax(axis=1)
            excess[part] = outside.max(axis=1)
        return face, excess


@dataclass(frozen=True, slots=True)
class ScatteredValues:
    """Values at scattered points.

    Attributes:
        axes: Numbers of the coordinates that the values depend on, from 0.
        hull: Convex hull of the points in these.
        count: Number of points.
        between: Values at places (m, d) in the hull; not a number elsewhere.
        nearest: Values of the nearest points.
    """

    axes: tuple[int, ...]
    hull: Hull
    count: int
    between: Callable[[Array], Array]
    nearest: Callable[[Array], Array]

    @classmethod
    def of(cls, axes: tuple[int, ...], points: Array, values: Array) -> ScatteredValues:
        """Prepare.

        Args:
            axes: Numbers of the coordinates of the points, from 0.
            points: Shape (n, d), in m.
            values: Shape (n,).

        Raises:
            GeometryError: if points are given twice, are too few, or all lie on a line or in a
                plane.
        """
        given = len(points) - len(np.unique(points, axis=0))
        if given:
            raise GeometryError(f"{given} points are given again: must be different points")
        if len(points) <= len(axes):
            raise GeometryError(
                f"{len(points)} points: must be {len(axes) + 1} or more for {len(axes)} coordinates"
            )
        try:
            hull, between = Hull.of(points), _between(points, values)
        except QhullError as error:
            where = "on a line" if len(axes) == 2 else "in a plane"
            raise GeometryError(
                f"all points lie {where}: must not, or leave out the coordinate that the values "
                "do not depend on"
            ) from error
        tree = cKDTree(points)
        return cls(axes, hull, len(points), between, lambda at: values[tree.query(at)[1]])

    def at(self, places: Array) -> tuple[Array, Array]:
        """Values at places (m, 3), and how far these are outside of the points in m, each (m,)."""
        own = places[:, self.axes]
        beyond = self.hull.beyond(own)
        outside = np.flatnonzero(beyond)
        own[outside] = self.hull.pulled(own[outside])
        values = self.between(own)
        edge = np.flatnonzero(np.isnan(values))  # outside by round-off
        values[edge] = self.between(self.hull.pulled(own[edge]))
        missed = edge[np.isnan(values[edge])]
        values[missed] = self.nearest(own[missed])
        return values, beyond


def _between(points: Array, values: Array) -> Callable[[Array], Array]:
    """Linear interpolation; not a number outside."""
    if points.shape[1] > 1:
        return LinearNDInterpolator(Delaunay(points), values)
    order = np.argsort(points[:, 0])
    x, y = points[order, 0], values[order]
    return lambda at: np.interp(at[:, 0], x, y, left=np.nan, right=np.nan)
