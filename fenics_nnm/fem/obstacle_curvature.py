"""How obstacles curve at contact points: second derivatives of the gap by the place of a point."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.contact_sites import Chosen, ContactSites
from fenics_nnm.fem.patch_sites import PatchSites

#: Steps of central differences, over the size of the patches' places.
_STEP = 1e-4


class Moved(Protocol):
    """Places of a body."""

    def displacements(self, local: Array) -> Array:
        """Displacements along the axes, as `ContactInterface.displacements`."""


def obstacle_closing(places: Moved, sites: ContactSites, chosen: Chosen, shapes: Array) -> Array:
    """Second derivatives of the closing by amounts of shapes, of the obstacle alone.

    The gap of a point at x + u is g(x + u), so the closing has the second derivative -u'' of it:
    for a cylinder of radius r about its axis t_i t_j / r, with the tangential displacements t.
    Facets of the body as obstacles are taken as flat.

    Args:
        places: Contact points.
        sites: Vertices of the patches.
        chosen: Which of them they are.
        shapes: Displacements at the owned degrees of freedom, shape (n_owned, k).

    Returns:
        Shape (n_c, k, k), the same on all ranks.
    """
    moved = places.displacements(shapes)
    parts = zip(sites.parts, chosen, strict=True)
    second = np.concatenate([_second_derivatives(part, some) for part, some in parts])
    return np.asarray(-np.einsum("cai,cab,cbj->cij", moved, second, moved))


def _second_derivatives(part: PatchSites, chosen: Indices) -> Array:
    """Hessians of the gap in 1/m at some vertices of a patch, shape (n, dim, dim).

    The direction towards the obstacle is found anew at each place. What is along the direction at
    the point itself is left out: a gap is linear there.
    """
    places, directions = part.places[chosen], part.directions[chosen]
    count, dim = places.shape
    if part.patch.gap is None or part.patch.opposite is not None:
        return np.zeros((count, dim, dim))
    step = _STEP * max(float(np.ptp(part.places, axis=0).max()), float(np.abs(places).max()))
    normals, points = part.vertices.normals[chosen], part.points[chosen]

    def gap(offset: Array) -> Array:
        moved = places + offset
        return part.patch.gaps(points, moved, part.patch.direction(moved, normals))

    axes = step * np.eye(dim)
    found = np.empty((count, dim, dim))
    for i in range(dim):
        for j in range(i, dim):
            signs = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
            values = [a * b * gap(a * axes[i] + b * axes[j]) for a, b in signs]
            found[:, i, j] = found[:, j, i] = sum(values) / (4 * step**2)
    tangential = np.eye(dim) - directions[:, :, None] * directions[:, None, :]
    return tangential @ found @ tangential
