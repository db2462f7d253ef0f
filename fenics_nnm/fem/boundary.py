"""The surface of a body, facet by facet, the same on all ranks."""

from __future__ import annotations

from dataclasses import dataclass

import basix
import numpy as np
from dolfinx import mesh as dmesh
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.compat import cell_nodes, coordinate_element

#: Degree of the quadrature of areas and centres.
_DEGREE = 6


@dataclass(frozen=True, slots=True)
class Boundary:
    """Facets that belong to one cell alone, in an order that no number of ranks changes.

    Attributes:
        dim: Dimension of the body.
        local: Local number of each facet on the rank that owns it, -1 elsewhere.
        vertices: Node numbers of the input mesh at the corners, shape (n, corners).
        corners: Coordinates in m, shape (n, corners, dim).
        areas: Areas in m^2, lengths in m of a 2-D body, 1 for a 1-D one, shape (n,).
        centres: Centres of area in m, shape (n, dim).
        normals: Mean outward unit normals, shape (n, dim).
        comm: Communicator.
    """

    dim: int
    local: Indices
    vertices: Indices
    corners: Array
    areas: Array
    centres: Array
    normals: Array
    comm: MPI.Comm

    @property
    def sizes(self) -> Array:
        """Longest distance between two corners of each facet in m, shape (n,)."""
        if self.dim == 1:
            return np.full(len(self.local), float(np.ptp(self.corners)))
        apart = self.corners[:, :, None] - self.corners[:, None, :]
        return np.asarray(np.linalg.norm(apart, axis=3).max(axis=(1, 2)))

    def mask(self, facets: Indices) -> Indices:
        """Where local facets of all ranks together lie among these, as zeros and ones."""
        mine = np.isin(self.local, facets) & (self.local >= 0)
        return np.asarray(self.comm.allreduce(mine.astype(np.int64)))

    def facets(self, mask: Indices) -> Indices:
        """Local facets where a mask is not zero."""
        return np.sort(self.local[(mask != 0) & (self.local >= 0)]).astype(np.int32)


def boundary(mesh: dmesh.Mesh) -> Boundary:
    """Gather the surface of a mesh of one cell type."""
    topology, dim = mesh.topology, mesh.topology.dim
    topology.create_connectivity(dim - 1, dim)
    topology.create_connectivity(dim, dim - 1)
    facets = dmesh.exterior_facet_indices(topology)
    nodes, inner = _nodes(mesh, facets)
    x = mesh.geometry.x[:, :dim]
    areas, centres, normals = _measures(mesh, x[nodes], x[inner].mean(axis=1))
    corners = nodes[:, : _corner_count(mesh)]
    numbers = np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)[corners]
    owner = np.full(len(facets), mesh.comm.rank)
    parts = (owner, facets, numbers, x[corners], areas, centres, normals)
    gathered = [np.concatenate(mesh.comm.allgather(part)) for part in parts]
    order = np.lexsort(np.sort(gathered[2], axis=1).T)
    owner, facets, numbers, points, areas, centres, normals = (part[order] for part in gathered)
    local = np.where(owner == mesh.comm.rank, facets, -1)
    return Boundary(dim, local, numbers, points, areas, centres, normals, mesh.comm)


def _corner_count(mesh: dmesh.Mesh) -> int:
    kind = mesh.topology.cell_type
    return {"interval": 1, "triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 4}[
        kind.name
    ]


def _nodes(mesh: dmesh.Mesh, facets: Indices) -> tuple[Indices, Indices]:
    """Nodes of facets, corners first, and the corners of the cells behind them."""
    topology, dim = mesh.topology, mesh.topology.dim
    to_cell, to_facet = topology.connectivity(dim - 1, dim), topology.connectivity(dim, dim - 1)
    cells = np.array([to_cell.links(facet)[0] for facet in facets], dtype=np.int64)
    layout = coordinate_element(mesh).create_dof_layout()
    sides = to_facet.array.reshape(to_facet.num_nodes, -1)[cells]
    side = (sides == facets[:, None]).argmax(axis=1)
    closure = np.array([layout.entity_closure_dofs(dim - 1, i) for i in range(sides.shape[1])])
    dofs = cell_nodes(mesh)[cells]
    corners = dofs[:, : len(basix.geometry(_basix(topology.cell_type.name)))]
    return np.take_along_axis(dofs, closure[side], axis=1), corners


def _basix(name: str) -> basix.CellType:
    return getattr(basix.CellType, name)


def _measures(mesh: dmesh.Mesh, nodes: Array, behind: Array) -> tuple[Array, Array, Array]:
    """Areas, centres and outward normals of facets with nodes of shape (n, nodes, dim)."""
    dim = mesh.topology.dim
    if dim == 1:
        normals = np.sign(nodes[:, 0] - behind)
        return np.ones(len(nodes)), nodes[:, 0], normals
    shape = {2: "interval", 3: {3: "triangle", 4: "quadrilateral"}.get(_corner_count(mesh))}[dim]
    cell = _basix(str(shape))
    cmap = coordinate_element(mesh)
    element = basix.create_element(
        basix.ElementFamily.P, cell, cmap.degree, basix.LagrangeVariant(cmap.variant)
    )
    points, weights = basix.make_quadrature(cell, _DEGREE)
    table = element.tabulate(1, points)[:, :, :, 0]
    x, *tangents = np.einsum("aqn,fnd->afqd", table, nodes)
    if dim == 3:
        vectors = np.cross(tangents[0], tangents[1])
    else:
        vectors = np.stack([tangents[0][..., 1], -tangents[0][..., 0]], axis=-1)
    lengths = np.linalg.norm(vectors, axis=2) * weights
    areas = lengths.sum(axis=1)
    centres = np.einsum("fq,fqd->fd", lengths, x) / areas[:, None]
    normals = np.einsum("fqd,q->fd", vectors, weights)
    inward = np.sum(normals * (centres - behind), axis=1) < 0
    normals = np.where(inward[:, None], -normals, normals)
    return areas, centres, normals / np.linalg.norm(normals, axis=1, keepdims=True)
