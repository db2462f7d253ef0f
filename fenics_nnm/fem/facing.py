"""Where lines from contact points meet other facets of the same mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from dolfinx import fem
from dolfinx import mesh as dmesh

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.fem.compat import cell_nodes, coordinate_element
from fenics_nnm.fem.curved_facets import is_curved, met_curved
from fenics_nnm.fem.rows import Entries
from fenics_nnm.fem.solid import Solid

#: A line meets a facet if it misses it by this part of the facet's size at most.
_EDGE = 1e-6

#: A facet whose normal has a larger cosine to the line does not face the point.
_FACING = -1e-6

#: Weights of basis functions below this are round-off.
_ROUND_OFF = 1e-13


@dataclass(frozen=True, slots=True)
class Counterparts:
    """Counterparts of points on facets that face them, the same on all ranks.

    Attributes:
        met: Whether the line of each point meets the facets, shape (n,).
        distance: Distance in m along the line, shape (n,).
        corners: Node numbers of the input mesh at the facets met, ascending.
        entries: Of this rank: weights of displacement blocks in the displacement of each
            counterpart, by the exact trace of the finite elements.
    """

    met: Mask
    distance: Array
    corners: Indices
    entries: Entries


@dataclass(frozen=True, slots=True)
class _Simplices:
    """Facets of all ranks as points, segments or triangles with straight edges.

    Attributes:
        corners: Coordinates in m, shape (m, dim, dim).
        nodes: All nodes of the whole facet in m, shape (m, k, dim).
        reference: Reference coordinates of the corners on it, shape (m, dim, dim - 1).
        normals: Unit normals out of the body, shape (m, dim).
        numbers: Node numbers of the corners in the input mesh, shape (m, dim).
        owner: Rank of the cell, shape (m,).
        cells: Local cell on that rank, shape (m,).
    """

    corners: Array
    nodes: Array
    reference: Array
    normals: Array
    numbers: Indices
    owner: Indices
    cells: Indices


def counterparts(solid: Solid, facets: Indices, points: Array, directions: Array) -> Counterparts:
    """Follow the contact direction from each point to the facets that face it.

    Facets with straight edges are met, a quadrangle as two triangles; of several the nearest. If
    it is of order 2, the line is then followed to the curved facet.

    Args:
        solid: Assembled body.
        facets: Local facets of the other side.
        points: Points in m, the same on all ranks, shape (n, dim).
        directions: Unit vectors, shape (n, dim).
    """
    simplices = _gathered(solid, facets)
    facet, distance = _nearest_met(simplices, points, directions)
    met = facet >= 0
    corners = np.unique(simplices.numbers[facet[met]])
    places = points + np.where(met, distance, 0.0)[:, None] * directions
    mine = np.flatnonzero(met & (simplices.owner[facet] == solid.tagged.mesh.comm.rank))
    entries = _traces(solid, mine, simplices.cells[facet[mine]], places[mine])
    return Counterparts(met, distance, corners, entries)


def _nearest_met(simplices: _Simplices, points: Array, directions: Array) -> tuple[Indices, Array]:
    """The facet met by each line, -1 for none, and the distance to it.

    A line p + t d meets the facet x_0 + sum_k beta_k (x_k - x_0) where the linear equations for
    (beta, t) have a solution with beta_k >= 0, sum beta_k <= 1.
    """
    facet, distance = np.full(len(points), -1), np.full(len(points), np.nan)
    first = simplices.corners[:, 0]
    edges = np.moveaxis(simplices.corners[:, 1:] - first[:, None], 1, 2)
    for i in range(len(points)):
        point, direction = points[i], directions[i]
        facing = np.flatnonzero(simplices.normals @ direction < _FACING)
        line = np.broadcast_to(-direction[:, None], (len(facing), len(direction), 1))
        matrix = np.concatenate([edges[facing], line], axis=2)
        solution = np.linalg.solve(matrix, (point - first[facing])[:, :, None])[:, :, 0]
        beta, t = solution[:, :-1], solution[:, -1]
        inside = (beta.min(axis=1, initial=0.0) >= -_EDGE) & (beta.sum(axis=1) <= 1 + _EDGE)
        if inside.any():
            nearest = int(np.argmin(np.where(inside, np.abs(t), np.inf)))
            facet[i], distance[i] = facing[nearest], t[nearest]
            if is_curved(simplices.nodes):
                ray = point, direction
                distance[i] = _to_curved(simplices, facet[i], beta[nearest], t[nearest], ray)
    return facet, distance


def _to_curved(
    simplices: _Simplices, facet: int, beta: Array, t: float, ray: tuple[Array, Array]
) -> float:
    """Distance along a line, of a point and a direction, to a facet of order 2."""
    corners = simplices.reference[facet]
    reference = corners[0] + beta @ (corners[1:] - corners[0])
    return met_curved(simplices.nodes[facet], reference, t, *ray)


def _gathered(solid: Solid, facets: Indices) -> _Simplices:
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    comm, topology = mesh.comm, mesh.topology
    to_cells = topology.connectivity(dim - 1, dim)
    cells = np.array([to_cells.links(facet)[0] for facet in facets], dtype=np.int32)
    owned = cells < topology.index_map(dim).size_local
    facets, cells = np.asarray(facets[owned], dtype=np.int32), cells[owned]
    topology.create_connectivity(dim - 1, 0)
    nodes: Indices = np.empty((0, dim), dtype=np.int64)
    whole: Indices = np.empty((0, 0), dtype=np.int64)
    reference: Array = np.empty((0, dim, dim - 1))
    if len(facets):  # dolfinx divides by the number of facets
        given = dmesh.entities_to_geometry(mesh, dim - 1, facets).reshape(len(facets), -1)
        places, on_facet = _split(given.shape[1], dim)
        split = given[:, places]
        cells, nodes = np.repeat(cells, split.shape[1]), split.reshape(-1, dim)
        whole = np.repeat(given, split.shape[1], axis=0)
        reference = np.tile(on_facet, (len(given), 1, 1))
    corners = mesh.geometry.x[nodes][:, :, :dim]
    inner = dmesh.compute_midpoints(mesh, dim, cells)[:, :dim]
    parts = (
        corners,
        reference,
        _normals(corners, inner),
        np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)[nodes],
        np.full(len(cells), comm.rank),
        cells.astype(np.int64),
    )
    corners, *others = (np.concatenate(comm.allgather(part)) for part in parts)
    all_nodes = [part for part in comm.allgather(mesh.geometry.x[whole][..., :dim]) if len(part)]
    return _Simplices(corners, np.concatenate(all_nodes or [corners]), *others)


def _split(count: int, dim: int) -> tuple[Indices, Array]:
    """Simplices of a facet with so many nodes: places of their corners, and where these are on it.

    The corners of a quadrangle come in dolfinx's order: the last one is opposite to the first.

    Returns:
        Numbers among the nodes of the facet, shape (simplices, dim), and reference coordinates,
        shape (simplices, dim, dim - 1).
    """
    places = np.arange(dim)[None, :]
    if dim == 3 and count in (4, 9):  # quadrangles of order 1 and 2
        places = np.array([[0, 1, 2], [1, 3, 2]])
    corners = np.array([[0, 0], [1, 0], [0, 1], [1, 1]], dtype=float)[:, : dim - 1]
    return places, corners[places]


def _normals(corners: Array, inner: Array) -> Array:
    """Unit normals of simplices (m, dim, dim) that lead away from inner points (m, dim)."""
    outward = corners.mean(axis=1) - inner
    if corners.shape[1] == 3:
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    elif corners.shape[1] == 2:
        edge = corners[:, 1] - corners[:, 0]
        normal = np.column_stack([edge[:, 1], -edge[:, 0]])
    else:
        normal = np.ones_like(outward)
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    return np.asarray(normal * np.sign(np.sum(normal * outward, axis=1))[:, None])


def _traces(solid: Solid, rows: Indices, cells: Indices, places: Array) -> Entries:
    """Weights of the basis functions of local cells at places in them."""
    mesh, space = solid.tagged.mesh, solid.space
    element = fem.functionspace(mesh, ("Lagrange", solid.body.degree)).element.basix_element
    found: list[tuple[Indices, Indices, Array]] = []
    for i, (row, cell) in enumerate(zip(rows, cells, strict=True)):
        nodes = mesh.geometry.x[cell_nodes(mesh)[cell]][:, : solid.tagged.dim]
        reference = coordinate_element(mesh).pull_back(places[i : i + 1], nodes)
        weights = element.tabulate(0, reference)[0, 0, :, 0]
        kept = np.abs(weights) > _ROUND_OFF
        blocks = space.dofmap.index_map.local_to_global(space.dofmap.cell_dofs(cell)[kept])
        found.append((np.full(kept.sum(), row), blocks.astype(np.int64), weights[kept]))
    return Entries.joined(found)
