"""Stresses at nodes, recovered from those inside the cells.

Superconvergent patch recovery (Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng 33 (1992) 1331):
around each vertex a polynomial of the degree p of the displacement is fitted, by least squares,
to the stresses at the Gauss points of the cells there. It gives the stress at the vertex; a node
inside an edge, face or cell gets the mean of what the polynomials of its vertices give there.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement
from math import comb

import numpy as np
from scipy import sparse

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.reference_cell import ReferenceCell, reference_cell

#: A patch whose points lie in a plane, or on a line, to this part of its size does not settle how
#: stress changes across.
_FLAT = 1e-6

#: A combination of quadratic terms that is smaller than this part of the largest one at the points
#: of a patch, once constant and linear terms are taken out, is not settled by them and left out:
#: with two layers of points across a thin body, the square of the coordinate across.
_SETTLED = 1e-3

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
            shape (cells, s, dim, nodes a cell).
        elasticity: Stress in Pa (VTK's order) per strain there, shape (cells, s, 6, strains), with
            the strains xx; xx, yy, 2 xy; or xx, yy, zz, 2 xy, 2 yz, 2 xz.
        smoothing: Stresses at the sampling points of all cells to those at nodes, sparse.
    """

    mesh: FieldMesh
    slopes: Array
    elasticity: Array
    smoothing: sparse.csr_array

    def at_samples(self, displacements: Array) -> Array:
        """Stress in Pa at the sampling points, shape (cells, s, 6, k), of k displacements in m.

        Args:
            displacements: Displacements at the nodes, shape (k, n, dim).
        """
        count, _, dim = displacements.shape
        cells, samples, _, nodes = self.slopes.shape
        of_cells = displacements[:, self.mesh.cells].transpose(1, 2, 0, 3)
        slopes = self.slopes.reshape(cells, samples * dim, nodes)
        gradient = slopes @ of_cells.reshape(cells, nodes, count * dim)
        gradient = gradient.reshape(cells, samples, dim, count, dim)
        strains = strains_of(gradient.transpose(0, 1, 3, 4, 2))
        return np.asarray(self.elasticity @ strains.transpose(0, 1, 3, 2))

    def at_nodes(self, displacement: Array) -> Array:
        """Stress in Pa at the nodes of a displacement (n, dim) in m there, shape (n, 6)."""
        return self.at_nodes_of_each(displacement[None])[0]

    def at_nodes_of_each(self, displacements: Array) -> Array:
        """The same of k displacements, shape (k, n, dim), in one go: shape (k, n, 6)."""
        sampled = self.at_samples(displacements)
        columns = sampled.reshape(len(self.slopes) * self.slopes.shape[1], -1)
        nodal = self.smoothing @ columns
        return np.asarray(nodal.reshape(len(nodal), 6, -1).transpose(2, 0, 1))


def stress_recovery(mesh: FieldMesh, elasticity: Array) -> StressRecovery:
    """Prepare the recovery for one mesh; `elasticity` as in `StressRecovery`."""
    cell = mesh.cell
    places = mesh.nodes[mesh.cells]
    jacobian = np.einsum("snj,cni->csij", cell.slopes, places[:, :, : cell.dim], optimize=True)
    slopes = np.einsum("snk,cskj->csjn", cell.slopes, np.linalg.inv(jacobian), optimize=True)
    slopes = np.ascontiguousarray(slopes)
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
    dim, degree = mesh.cell.dim, mesh.cell.degree
    wanted = _POINTS_PER_COEFFICIENT[dim] * comb(dim + degree, degree)
    patches = _patches(mesh, per_cell, wanted)
    node, vertex, weight = _pairs(mesh)
    start = np.searchsorted(vertex, np.arange(count + 1))
    flat = samples.reshape(-1, mesh.cell.dim)
    rows, columns, values = [], [], []
    for number in np.unique(vertex):
        listed = slice(start[number], start[number + 1])
        cells = patches.indices[patches.indptr[number] : patches.indptr[number + 1]]
        points = (cells[:, None] * per_cell + np.arange(per_cell)).ravel()
        centre = mesh.nodes[number, : mesh.cell.dim]
        places = mesh.nodes[node[listed], : mesh.cell.dim] - centre
        found = _fit(flat[points] - centre, places, degree) * weight[listed, None]
        rows.append(np.repeat(node[listed], len(points)))
        columns.append(np.tile(points, len(found)))
        values.append(found.ravel())
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.coo_array(triplets, shape=(count, len(flat))).tocsr()


def _fit(points: Array, places: Array, degree: int) -> Array:
    """Weights of values at points in their least-squares polynomial at places, (places, points).

    In coordinates in which the points have no mean and unit covariance, constant and linear terms
    L are orthogonal: L^T L = n. With quadratic terms Q the fit c of values b is

        c_Q = (Q - L P)^+ b,    c_L = L^T b / n - P c_Q,    P = L^T Q / n.

    The pseudoinverse leaves out what the points do not settle. What remains depends neither on
    the axes nor on the size of the patch.
    """
    mean = points.mean(axis=0)
    scaling = _whitening(points - mean)
    (L, Q), (L_at, Q_at) = (_terms((x - mean) @ scaling, degree) for x in (points, places))
    weights = L_at @ L.T / len(points)
    if degree > 1:
        P = L.T @ Q / len(points)
        weights = weights + (Q_at - L_at @ P) @ np.linalg.pinv(Q - L @ P, rcond=_SETTLED)
    return np.asarray(weights)


def _whitening(points: Array) -> Array:
    """The symmetric matrix that gives points without mean unit covariance, zero across a plane."""
    variance, axes = np.linalg.eigh(points.T @ points / len(points))
    spread = variance > _FLAT**2 * variance[-1]
    return np.asarray((axes[:, spread] / np.sqrt(variance[spread])) @ axes[:, spread].T)


def _terms(x: Array, degree: int) -> tuple[Array, Array]:
    """Constant and linear terms at points, and quadratic ones whose norm no rotation changes."""
    linear = np.column_stack([np.ones(len(x)), x])
    pairs = list(combinations_with_replacement(range(x.shape[1]), 2)) if degree > 1 else []
    size = {True: 1.0, False: np.sqrt(2.0)}
    quadratic = [size[i == j] * x[:, i] * x[:, j] for i, j in pairs]
    return linear, np.array(quadratic).reshape(len(pairs), len(x)).T


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
