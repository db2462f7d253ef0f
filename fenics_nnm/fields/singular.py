"""Nodes where the stress of linear elasticity has no bound: it grows as the mesh gets finer.

These are the nodes of all cells that have a vertex

* that is a contact point, which carries a concentrated force;
* on the edge of the clamp, where held facets meet free ones;
* on a re-entrant edge of the surface that turns by more than 45 degrees, with no fillet that the
  mesh resolves.

A corner of the surface in the plane is a vertex; a rod has neither edges nor corners.
"""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.backbone.extremes import CLAMP_EDGE, CONTACT, CORNER, KINDS
from fenics_nnm.fem.reference_cell import ReferenceCell
from fenics_nnm.fields.recovery import FieldMesh
from fenics_nnm.results.stored_branch import StoredBranch

#: Facets that turn inwards by more than this angle make a sharp corner.
_SHARP = np.deg2rad(45.0)


def singular_kinds(branch: StoredBranch, mesh: FieldMesh) -> Indices:
    """Number in `KINDS` of each node of the field mesh, shape (n,)."""
    found = np.zeros(len(mesh.nodes), dtype=np.int64)
    corners, edges = singular_corners(branch, mesh.cell)
    for kind, vertices in (
        (CORNER, corners),
        (CLAMP_EDGE, edges),
        (CONTACT, _contact_vertices(branch, mesh.cell)),
    ):
        near = np.zeros(len(branch.nodes), dtype=bool)
        near[vertices] = True
        cells = near[branch.cells[:, : mesh.cell.corners]].any(axis=1)
        found[mesh.cells[cells]] = KINDS.index(kind)
    return found


def _contact_vertices(branch: StoredBranch, cell: ReferenceCell) -> Indices:
    """Vertices with a contact point; a rod has no edges there, and bears its force evenly."""
    nodes = branch.contact_pressures[0].astype(np.int64)
    return nodes if cell.dim > 1 else nodes[:0]


def singular_corners(branch: StoredBranch, cell: ReferenceCell) -> tuple[Indices, Indices]:
    """Vertices of sharp re-entrant edges, and of the edges of what is held."""
    if cell.dim < 2:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    facets, normals = _surface(branch, cell)
    centres = branch.nodes[facets].mean(axis=1)
    pairs, vertices = _neighbours(facets)
    first, second = pairs.T
    cosine = np.sum(normals[first] * normals[second], axis=1)
    inwards = np.sum(normals[first] * (centres[second] - centres[first]), axis=1) > 0
    sharp = inwards & (cosine < np.cos(_SHARP))
    still = np.all(_held(branch)[facets], axis=1)
    return np.unique(vertices[sharp]), np.unique(vertices[still[first] != still[second]])


def _held(branch: StoredBranch) -> Mask:
    """Whether a component of each node stays where it is in all modes, shape (n,)."""
    moving: Mask = np.any(branch.shapes != 0, axis=0)
    return np.asarray(~np.all(moving, axis=1))


def _surface(branch: StoredBranch, cell: ReferenceCell) -> tuple[Indices, Array]:
    """Vertices of the facets of one cell alone, (facets, v), and their outward unit normals."""
    local = np.array([facet[facet < cell.corners] for facet in cell.facets])
    corners = branch.cells[:, : cell.corners]
    facets = corners[:, local].reshape(-1, local.shape[1])
    owner = np.repeat(np.arange(len(corners)), len(local))
    _, first, count = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = first[count == 1]
    facets, owner = facets[outer], owner[outer]
    places = branch.nodes[facets]
    along = places[:, 1] - places[:, 0]
    other = places[:, -1] - places[:, 0] if cell.dim > 2 else np.array([0.0, 0.0, 1.0])
    normal = np.cross(along, other)
    inside = branch.nodes[corners[owner]].mean(axis=1) - places.mean(axis=1)
    normal *= -np.sign(np.sum(normal * inside, axis=1, keepdims=True))
    return facets, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _neighbours(facets: Indices) -> tuple[Indices, Indices]:
    """Facets that share an edge, (pairs, 2), and the vertices of these edges, (pairs, 1 or 2)."""
    ring = np.roll(facets, -1, axis=1)
    shared = facets[:, :, None] if facets.shape[1] == 2 else np.stack([facets, ring], axis=2)
    edges = np.sort(shared.reshape(-1, shared.shape[2]), axis=1)
    owner = np.repeat(np.arange(len(facets)), shared.shape[1])
    order = np.lexsort(edges.T)
    edges, owner = edges[order], owner[order]
    same = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    return np.stack([owner[same], owner[same + 1]], axis=1), edges[same]
