"""The obstacle that a body meets, beside its motion.

A casing is drawn as far as it is near its contact patch, as `casing_sheet` has it before a run; any
other obstacle is the contact patch, moved on by its gaps.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array, Indices, in_space
from fenics_nnm.casing import Surface
from fenics_nnm.errors import GeometryError, StudyError
from fenics_nnm.output.pictures.casing_sheet import CASING, cells_of, sheet_grid
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.scene import Faces, Layer, Lines, size_of
from fenics_nnm.output.pictures.unrolled import Unrolling
from fenics_nnm.results.stored_branch import StoredBranch
from fenics_nnm.study.reading import study_from

#: How much of a sheet hides what is behind it, and how wide it is at least, over the body's size.
OPACITY, _WIDTH = 0.35, 0.06

#: Gaps beside contact points are means of those of so many points.
_NEAR = 6

#: What pictures say of it.
WORDS = " Brown: the obstacle, its gap enlarged like the displacements."


@dataclass(frozen=True, slots=True)
class Sheet:
    """A part of the obstacle near the body.

    Attributes:
        places: Places where it would be without a gap in m, shape (p, 3).
        gaps: Vectors across the gap in m, shape (p, 3): enlarged as displacements are.
        corners: Nodes of each face, or of each line of a body in the plane, shape (f, 2 to 4).
    """

    places: Array
    gaps: Array
    corners: Indices

    def at(self, factor: float) -> Array:
        """Its places with the gap enlarged by a factor, shape (p, 3)."""
        return np.asarray(self.places + factor * self.gaps)

    def layer(self, factor: float) -> Layer:
        """The sheet as it is drawn, its gap enlarged by a factor."""
        places = self.at(factor)
        if self.corners.shape[1] == 2:
            return Lines(places[self.corners], CASING, 3.0)
        return Faces(places, self.corners, CASING, opacity=OPACITY)


def obstacle_layers(results: Results, body: StoredBranch, factor: float) -> list[Layer]:
    """The obstacle of each patch, its gap enlarged; none of facets that meet others of the body.

    Args:
        results: Results.
        body: The body.
        factor: How many times displacements, and so gaps, are enlarged.
    """
    return [sheet.layer(factor) for sheet in obstacle_sheets(results, body)]


def obstacle_sheets(results: Results, body: StoredBranch) -> list[Sheet]:
    """The obstacle of each patch; none of facets that meet others of the body."""
    if body.facet_side.any():
        return []
    facets = {
        int(patch): body.contact_facets[body.facet_patch == patch]
        for patch in np.unique(body.contact_patches)
    }
    casings = _casings(results)
    return [
        _of_casing(casings[patch], results, body, patch) or _of_patch(results, body, patch, own)
        if patch in casings
        else _of_patch(results, body, patch, own)
        for patch, own in facets.items()
        if len(own)
    ]


def _casings(results: Results) -> dict[int, Surface]:
    """Casings by the number of their patch; those whose table is not here any more are left out."""
    try:
        study = study_from(dict(results.header.values), Path("study.toml"))
    except StudyError:  # of files that are gone, or of an earlier version
        return {}
    found: dict[int, Surface] = {}
    for number, patch in enumerate(study.contact.patches.values()):
        if patch.casing is not None:
            with suppress(GeometryError):
                found[number] = patch.casing.surface()
    return found


def _of_casing(surface: Surface, results: Results, body: StoredBranch, patch: int) -> Sheet | None:
    """A casing about a patch: its distance from the body at rest is the gap of the points nearby.

    Steady loads change gaps, and so move it against the body as it is drawn. None if it is not met
    about the patch.
    """
    own = body.contact_patches == patch
    points, dim = body.contact_points[own], body.shapes.shape[2]
    ways = in_space(body.contact_directions[own])
    try:
        grid = sheet_grid(surface, points[:, :dim], size_of(body.nodes), dim)
        cold = surface.distance(points, ways)
    except GeometryError:
        return None
    places = grid.reshape(-1, 3)
    near = _means_of_near(places, points)
    unloaded, gaps = (near @ (size[:, None] * ways) for size in (cold, results.model.gap[own]))
    return Sheet(places - unloaded, gaps, cells_of(grid))


def _means_of_near(places: Array, points: Array) -> Array:
    """Weights of points at places, of the nearest ones alone, shape (places, points)."""
    count = min(_NEAR, len(points))
    distance, number = KDTree(points).query(places, k=[*range(1, count + 1)])
    weight = 1 / (distance + 0.1 * distance.mean() + np.finfo(float).tiny) ** 2
    weights = np.zeros((len(places), len(points)))
    np.put_along_axis(weights, number, weight / weight.sum(axis=1, keepdims=True), axis=1)
    return weights


def _of_patch(results: Results, body: StoredBranch, patch: int, facets: Indices) -> Sheet:
    """The facets of a patch where its points end when their gaps are closed."""
    corners = _corners(facets, body.shapes.shape[2])
    nodes, rows = np.unique(facets[:, :corners], return_inverse=True)
    own = np.flatnonzero(body.contact_patches == patch)
    nearest = own[KDTree(body.contact_points[own]).query(body.nodes[nodes])[1]]
    gaps = in_space(body.contact_directions)[nearest] * results.model.gap[nearest][:, None]
    if corners == 1:
        return _across(body.nodes[nodes], gaps, size_of(body.nodes))
    places = body.nodes[nodes] if corners == 2 else _widened(body.nodes[nodes], body.nodes)
    return Sheet(places, gaps, rows.reshape(-1, corners))


def _across(places: Array, gaps: Array, size: float) -> Sheet:
    """Lines across the ends of a rod, which is drawn as a strip."""
    half = _WIDTH * size * np.array([0.0, 1.0, 0.0])
    count = len(places)
    both = np.stack([np.arange(count), np.arange(count) + count], axis=1)
    return Sheet(np.vstack([places - half, places + half]), np.vstack([gaps, gaps]), both)


def _corners(facets: Indices, dim: int) -> int:
    if dim < 3:
        return min(2, facets.shape[1])
    return 4 if facets.shape[1] in (4, 8, 9) else 3


def _widened(places: Array, nodes: Array) -> Array:
    """Places of a thin sheet, wide enough to be seen: moved out across its middle line."""
    way = Unrolling.of(places)
    across = way.flat(places)[:, 1]
    least = _WIDTH * float(np.linalg.norm(np.ptp(nodes, axis=0)))
    more = np.where(across < 0, -1.0, 1.0) * np.maximum(0.0, least - np.abs(across))
    return np.asarray(places + more[:, None] * way.frame[1])
