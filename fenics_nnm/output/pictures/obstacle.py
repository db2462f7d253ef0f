"""The obstacle that a body meets, beside its motion: its contact patches moved on by their gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array, Indices, in_space
from fenics_nnm.output.pictures.casing_sheet import CASING
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.scene import Faces, Layer, Lines
from fenics_nnm.output.pictures.unrolled import Unrolling
from fenics_nnm.results.stored_branch import StoredBranch

#: How much of a sheet hides what is behind it, and how wide it is at least, over the body's size.
OPACITY, _WIDTH = 0.35, 0.06

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
    return [_sheet(results, body, patch, own) for patch, own in facets.items() if len(own)]


def _sheet(results: Results, body: StoredBranch, patch: int, facets: Indices) -> Sheet:
    """The facets of a patch where its points end when their gaps are closed."""
    corners = _corners(facets, body.shapes.shape[2])
    nodes, rows = np.unique(facets[:, :corners], return_inverse=True)
    own = np.flatnonzero(body.contact_patches == patch)
    nearest = own[KDTree(body.contact_points[own]).query(body.nodes[nodes])[1]]
    gaps = in_space(body.contact_directions)[nearest] * results.model.gap[nearest][:, None]
    places = body.nodes[nodes] if corners == 2 else _widened(body.nodes[nodes], body.nodes)
    return Sheet(places, gaps, rows.reshape(-1, corners))


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
