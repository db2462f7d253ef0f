"""One contact patch: its points, their obstacle, and the pressure that their forces make."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.averaged_rows import averaged_entries
from fenics_nnm.fem.deformed import deformed
from fenics_nnm.fem.facing import Counterparts, counterparts
from fenics_nnm.fem.patch_sites import Patch, PatchSites, opposite_vertices, vertex_entries
from fenics_nnm.fem.patch_vertices import PatchVertices
from fenics_nnm.fem.rows import owned_rows
from fenics_nnm.fem.solid import Solid


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


def patch_points(solid: Solid, sites: PatchSites, chosen: Indices) -> PatchPoints:
    """Contact points of a patch.

    Args:
        solid: Assembled body.
        sites: Vertices of the patch.
        chosen: Which of them become contact points, ascending.

    Raises:
        MeshError: as `contact_interface`.
        ModelError: as `contact_interface`.
        GeometryError: as `contact_interface`.
    """
    patch, vertices = sites.patch, sites.vertices
    points, directions = vertices.points[chosen], sites.directions[chosen]
    places = sites.places[chosen]
    nearest = nearest_of(vertices.points, points)
    if patch.averaged:
        entries = averaged_entries(solid, patch.facets, vertices, nearest)
    else:
        entries = vertex_entries(vertices, chosen)
    owned = solid.tagged.mesh.topology.index_map(0).size_local
    pressures = _pressures(vertices, nearest, len(chosen), owned)
    gap = None if patch.gap is None else patch.gaps(points, places, directions)
    if patch.opposite is not None:
        with deformed(solid):
            across = counterparts(solid, patch.opposite.facets, places, directions)
            entries = entries.minus(across.entries)
            pressures = pressures + _opposite_pressures(
                solid, patch, across, places + across.distance[:, None] * directions
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
        left_out=sites.left_out,
    )


def nearest_of(points: Array, centres: Array) -> Indices:
    """The nearest of some centres to each point."""
    distances = np.linalg.norm(points[:, None, :] - centres[None, :, :], axis=2)
    return np.argmin(distances, axis=1)


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
    every = opposite_vertices(solid, patch)
    vertices = every.chosen(np.flatnonzero(np.isin(every.numbers, across.corners)))
    owned = solid.tagged.mesh.topology.index_map(0).size_local
    count, point = len(places), nearest_of(vertices.points, places)
    pressures = _pressures(vertices, point, count, owned)
    alone = np.setdiff1d(np.arange(count), point)
    at = nearest_of(places[alone], vertices.points)
    mine = vertices.local[at] >= 0
    single = (1 / vertices.areas[at[mine]], (vertices.local[at[mine]], alone[mine]))
    return csr_array(pressures + coo_array(single, shape=(owned, count)))
