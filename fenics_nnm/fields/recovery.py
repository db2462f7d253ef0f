"""Stresses at nodes, recovered from those inside the cells.

Superconvergent patch recovery (Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng 33 (1992) 1331):
around each vertex a polynomial of the degree p of the displacement is fitted, by least squares,
to the stresses at the Gauss points of the cells there. It gives the stress at the vertex; a node
inside an edge, face or cell gets the mean of what the polynomials of its vertices give there.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from scipy import sparse

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.reference_cell import ReferenceCell, reference_cell

#: Weights that decide where a patch is too thin for its polynomial, by degree: the higher terms
#: vanish then. Their squares are the relative error where it is not.
_RESERVE = (0.0, 1e-9, 1e-5)

#: A patch with fewer points than this for each coefficient is enlarged by its neighbours; on a
#: line as many points as coefficients are never badly placed.
_POINTS_PER_COEFFICIENT = {1: 1, 2: 2, 3: 2}


@dataclass(frozen=True, slots=True)
class FieldMesh:
    """A mesh whose nodes are not shared between materials.

    Attributes:
        nodes: Places in m, shape (n, 3).
        cells: Nodes of each cell in VTK's order, shape (cells, nodes a cell).
        cell: Their reference cell.
        origin: Node of the body's mesh that each node is a copy of, shape (n,).
    """

    nodes: Array
    cells: Indices
    cell: ReferenceCell
    origin: Indices


def field_mesh(nodes: Array, cells: Indices, cell_type: int, region: Indices) -> FieldMesh:
    """The mesh of fields, from the mesh of a body whose cells belong to regions, shape (cells,)."""
    pairs = np.stack([cells, np.broadcast_to(region[:, None], cells.shape)], axis=-1)
    unique, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    origin = unique[:, 0]
    return FieldMesh(nodes[origin], number.reshape(cells.shape), reference_cell(cell_type), origin)


@dataclass(frozen=True, slots=True)
class StressRecovery:
    """From displacements to stresses at the nodes of a field mesh.

    Attributes:
        mesh: Mesh of the fields.
        slopes: Derivatives of the shape functions by x, y, z at the sampling points of each cell,
            shape (cells, s, nodes a cell, dim).
        elasticity: Stress in Pa (VTK's order) per strain there, shape (cells, s, 6, strains), with
            the strains xx; xx, yy, 2 xy; or xx, yy, zz, 2 xy, 2 yz, 2 xz.
        smoothing: Stresses at the sampling points of all cells to those at nodes, sparse.
    """

    mesh: FieldMesh
    slopes: Array
    elasticity: Array
    smoothing: sparse.csr_array

    def at_samples(self, displacement: Array) -> Array:
        """Stress in Pa of a displacement (n, dim) in m at the sampling points, (cells, s, 6)."""
        of_cells = displacement[self.mesh.cells]
        gradient = np.einsum("csnj,cni->csij", self.slopes, of_cells, optimize=True)
        return np.einsum("csvk,csk->csv", self.elasticity, strains_of(gradient), optimize=True)

    def at_nodes(self, displacement: Array) -> Array:
        """Stress in Pa at the nodes of a displacement (n, dim) in m there, shape (n, 6)."""
        return np.asarray(self.smoothing @ self.at_samples(displacement).reshape(-1, 6))


def stress_recovery(mesh: FieldMesh, elasticity: Array) -> StressRecovery:
    """Prepare the recovery for one mesh; `elasticity` as in `StressRecovery`."""
    cell = mesh.cell
    places = mesh.nodes[mesh.cells]
    jacobian = np.einsum("snj,cni->csij", cell.slopes, places[:, :, : cell.dim], optimize=True)
    slopes = np.einsum("snk,cskj->csnj", cell.slopes, np.linalg.inv(jacobian), optimize=True)
    samples = np.einsum("sn,cni->csi", cell.values, places[:, :, : cell.dim], optimize=True)
    return StressRecovery(mesh, slopes, elasticity, _smoothing(mesh, samples))


def strains_of(gradient: Array) -> Array:
    """Strains of displacement gradients du_i/dx_j, shape (..., 1, 3 or 6), shears doubled."""
    dim = gradient.shape[-1]
    shears = {1: (), 2: ((0, 1),), 3: ((0, 1), (1, 2), (0, 2))}[dim]
    parts = [gradient[..., i, i] for i in range(dim)]
    parts += [gradient[..., i, j] + gradient[..., j, i] for i, j in shears]
    return np.stack(parts, axis=-1)


def _smoothing(mesh: FieldMesh, samples: Array) -> sparse.csr_array:
    """Weights of the samples of all cells at each node, shape (n, cells s)."""
    count, per_cell = len(mesh.nodes), samples.shape[1]
    powers = _monomials(mesh.cell.dim, mesh.cell.degree)
    patches = _patches(mesh, per_cell, _POINTS_PER_COEFFICIENT[mesh.cell.dim] * len(powers))
    node, vertex, weight = _pairs(mesh)
    start = np.searchsorted(vertex, np.arange(count + 1))
    flat = samples.reshape(-1, mesh.cell.dim)
    rows, columns, values = [], [], []
    for number in np.unique(vertex):
        wanted = slice(start[number], start[number + 1])
        cells = patches.indices[patches.indptr[number] : patches.indptr[number + 1]]
        points = (cells[:, None] * per_cell + np.arange(per_cell)).ravel()
        centre = mesh.nodes[number, : mesh.cell.dim]
        places = mesh.nodes[node[wanted], : mesh.cell.dim] - centre
        found = _fit(flat[points] - centre, places, powers) * weight[wanted, None]
        rows.append(np.repeat(node[wanted], len(points)))
        columns.append(np.tile(points, len(found)))
        values.append(found.ravel())
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.coo_array(triplets, shape=(count, len(flat))).tocsr()


def _fit(points: Array, places: Array, powers: Indices) -> Array:
    """Weights of values at points in their least-squares polynomial at places, (places, points)."""
    size = np.abs(points).max()
    matrix = _evaluated(points / size, powers)
    reserve = np.diag(np.array(_RESERVE)[powers.sum(axis=1)])
    Q, R = np.linalg.qr(np.vstack([matrix, reserve]))
    rows = np.linalg.solve(R.T, np.asarray(_evaluated(places / size, powers).T, dtype=float))
    return np.asarray(rows.T @ Q[: len(points)].T)


def _monomials(dim: int, degree: int) -> Indices:
    """Exponents of all monomials up to a degree, shape (monomials, dim)."""
    factors = [c for d in range(degree + 1) for c in combinations_with_replacement(range(dim), d)]
    return np.array([[factor.count(axis) for axis in range(dim)] for factor in factors])


def _evaluated(points: Array, powers: Indices) -> Array:
    return np.asarray(np.prod(points[:, None, :] ** powers, axis=2))


def _patches(mesh: FieldMesh, per_cell: int, wanted: int) -> sparse.csr_array:
    """Cells around each vertex, and around their vertices where these are too few."""
    corners = mesh.cells[:, : mesh.cell.corners]
    cell = np.repeat(np.arange(len(corners)), corners.shape[1])
    shape = (len(mesh.nodes), len(corners))
    around = sparse.coo_array((np.ones(len(cell)), (corners.ravel(), cell)), shape=shape).tocsr()
    few = around.sum(axis=1) * per_cell < wanted
    enlarged = around @ (around.T @ around)
    chosen = sparse.diags_array(few.astype(float)) @ enlarged + around
    return chosen.tocsr()


def _pairs(mesh: FieldMesh) -> tuple[Indices, Indices, Array]:
    """Node, vertex whose polynomial is evaluated there, and its weight; by ascending vertex."""
    found = [
        np.stack([mesh.cells[:, node], mesh.cells[:, parent]])
        for node, parents in enumerate(mesh.cell.parents)
        for parent in parents
    ]
    node, vertex = np.unique(np.concatenate(found, axis=1)[::-1], axis=1)[::-1]
    return node, vertex, 1.0 / np.bincount(node)[node]
