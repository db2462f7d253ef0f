"""A contact patch laid flat: how far along it and how far across it its points lie.

The way along a patch is the length of a curve, a cubic through its points in the plane of their
two longest directions: of the tip of a blade the camber line, from one edge to the other. Across is
the distance from that curve. Points of a thin patch lie on both sides of it, in two rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: Fewest points that a curve of each degree is laid through.
_DEGREES = ((8, 3), (5, 2), (2, 1), (0, 0))

#: Steps of the curve that its length is summed over.
_STEPS = 400

#: Points are in two rows if they are this part of the largest distance from the curve in the mean,
#: and the patch is this much longer than wide.
_IN_ROWS, _SLENDER = 0.4, 4.0


@dataclass(frozen=True, slots=True)
class Unrolling:
    """The map from places of a patch in space to its plane.

    Attributes:
        middle: Middle of the points in m, shape (3,).
        frame: Unit vectors along, across, and normal, shape (3, 3).
        curve: Coefficients of the curve, that of the highest power first.
        ends: Ends of the points along the first vector, in m.
    """

    middle: Array
    frame: Array
    curve: Array
    ends: tuple[float, float]

    @classmethod
    def of(cls, places: Array) -> Unrolling:
        """The map that lays points of a patch, shape (n, 3) in m, flat."""
        middle = places.mean(axis=0)
        frame = np.linalg.svd(places - middle, full_matrices=True)[2]
        frame = frame * np.sign(frame[[0, 1, 2], np.abs(frame).argmax(axis=1)])[:, None]
        along, across = ((places - middle) @ frame[:2].T).T
        degree = next(degree for least, degree in _DEGREES if len(places) >= least)
        curve = _fitted(along, across, degree)
        return cls(middle, frame, curve, (float(along.min()), float(along.max())))

    def flat(self, places: Array) -> Array:
        """Way along and distance across of places (n, 3), in m, shape (n, 2)."""
        along, across = ((places - self.middle) @ self.frame[:2].T).T
        low, high = min(along.min(), self.ends[0]), max(along.max(), self.ends[1])
        grid = np.linspace(low, high, _STEPS)
        rises = np.polyval(np.polyder(self.curve), grid) if len(self.curve) > 1 else 0 * grid
        slope = np.sqrt(1 + rises**2)
        steps = np.diff(grid) * (slope[1:] + slope[:-1]) / 2
        way = np.concatenate([[0.0], np.cumsum(steps)])
        start = np.interp(self.ends[0], grid, way)
        distance = across - np.polyval(self.curve, along)
        return np.column_stack([np.interp(along, grid, way) - start, distance])


def _fitted(along: Array, across: Array, degree: int) -> Array:
    """Coefficients of a polynomial through points; the smallest ones where rows leave a choice."""
    size = float(np.abs(along).max()) or 1.0
    powers = np.arange(degree, -1, -1)
    scaled = np.linalg.lstsq((along[:, None] / size) ** powers, across, rcond=1e-9)[0]
    return np.asarray(scaled / size**powers)


@dataclass(frozen=True, slots=True)
class Ordered:
    """Contact points in the order of their places.

    Attributes:
        order: Numbers of the points.
        along: Way along its patch of each in this order, in m.
        breaks: How many points stand before another row, or another patch, begins.
        words: What the order is.
        label: Label of an axis with the points.
        factor: From `along` to what the axis says.
    """

    order: Indices
    along: Array
    breaks: tuple[int, ...]
    words: str
    label: str = "place  (mm)"
    factor: float = 1e3

    @property
    def shown(self) -> Array:
        """What axes say of each point."""
        return self.factor * self.along


def ordered(places: Array, patches: Indices) -> Ordered:
    """Contact points patch by patch, row by row, along each row.

    Args:
        places: Places in m, shape (n, 3).
        patches: Patch of each, shape (n,).
    """
    along, row = np.zeros(len(places)), np.zeros(len(places), dtype=np.int64)
    for patch in np.unique(patches):
        own = patches == patch
        flat = Unrolling.of(places[own]).flat(places[own])
        along[own], row[own] = flat[:, 0], _rows(flat)
    order = np.lexsort([along, row, patches])
    changes = np.flatnonzero(np.diff(patches[order]) | np.diff(row[order])) + 1
    words = "along the patch" + (", patch by patch" if np.ptp(patches) else "")
    words += ", one side of it after the other" if row.any() else ""
    return Ordered(order, along[order], tuple(int(n) for n in changes), words)


def _rows(flat: Array) -> Indices:
    """Row of each point, 0 or 1: which side of the curve it lies on, where there are two rows."""
    distance = np.abs(flat[:, 1])
    slender = np.ptp(flat[:, 0]) > _SLENDER * np.ptp(flat[:, 1])
    parted = distance.mean() > _IN_ROWS * distance.max()
    if not (slender and parted) or distance.max() < 1e-6 * np.ptp(flat[:, 0]):
        return np.zeros(len(flat), dtype=np.int64)
    return (flat[:, 1] > 0).astype(np.int64)
