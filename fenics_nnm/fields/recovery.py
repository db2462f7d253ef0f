"""Stresses at nodes, recovered from those inside the cells.

Superconvergent patch recovery (Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng 33 (1992) 1331):
around each vertex a polynomial of the degree p of the displacement is fitted, by least squares,
to the stresses at the Gauss points of the cells there. It gives the stress at the vertex; a node
inside an edge, face or cell gets the mean of what the polynomials of its vertices give there.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np
from scipy import sparse

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.fem.reference_cell import ReferenceCell, reference_cell
from fenics_nnm.fields.patch_fit import fitted

#: A patch with fewer points than this for each coefficient is enlarged by its neighbours; on a
#: line as many points as coefficients are never badly placed.
_POINTS_PER_COEFFICIENT = {1: 1, 2: 2, 3: 2}

#: Patches that are fitted at once.
_AT_ONCE = 256


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
    there = np.zeros((len(nodes), int(region.max()) + 1), dtype=bool)
    there[cells, region[:, None]] = True
    number = np.cumsum(there).reshape(there.shape) - 1
    origin = np.nonzero(there)[0]
    own = number[cells, region[:, None]]
    return FieldMesh(nodes[origin], own, reference_cell(cell_type), origin)


@dataclass(frozen=True, slots=True)
class StressRecovery:
    """From displacements to stresses at some nodes of a field mesh.

    Attributes:
        mesh: Mesh of the fields.
        nodes: Nodes of it whose displacements matter, shape (n,).
        cells: The cells that do, by the places of their nodes in `nodes`.
        slopes: Derivatives of the shape functions by x, y, z at the sampling points of these cells,
            shape (cells, s, dim, nodes a cell).
        elasticity: Stresses in Pa (VTK's order) per strain that there are, shape (rows, 6,
            strains), with the strains xx; xx, yy, 2 xy; or xx, yy, zz, 2 xy, 2 yz, 2 xz.
        row: Row of it at each of these points, shape (cells, s).
        smoothing: Stresses at the sampling points of these cells to those at the nodes wanted,
            sparse.
        used: Numbers of these cells in the mesh.
    """

    mesh: FieldMesh
    nodes: Indices
    cells: Indices
    slopes: Array
    elasticity: Array
    row: Indices
    smoothing: sparse.csr_array
    used: Indices

    def of_samples(self, sampled: Array) -> Array:
        """Stress in Pa at the nodes wanted, (wanted, 6), of that at all samples, (cells, s, 6)."""
        own = sampled[self.used]
        return np.asarray(self.smoothing @ own.reshape(-1, own.shape[-1]))

    def at_samples(self, displacements: Array) -> Array:
        """Stress in Pa at the sampling points, shape (cells, s, k, 6), of k displacements in m.

        Args:
            displacements: Displacements at `nodes`, shape (k, n, dim).
        """
        return self._stresses(self._gradients(displacements))

    def _gradients(self, displacements: Array) -> Array:
        """Gradients du_i/dx_j at the sampling points, shape (cells, s, k, dim, dim)."""
        count, _, dim = displacements.shape
        cells, samples, _, nodes = self.slopes.shape
        of_cells = displacements[:, self.cells].transpose(1, 2, 0, 3)
        slopes = self.slopes.reshape(cells, samples * dim, nodes)
        gradient = slopes @ of_cells.reshape(cells, nodes, count * dim)
        return gradient.reshape(cells, samples, dim, count, dim).transpose(0, 1, 3, 4, 2)

    def _stresses(self, gradients: Array) -> Array:
        """Stresses of gradients, shape (cells, s, k, 6)."""
        strains = strains_of(gradients)
        if len(self.elasticity) == 1:
            return np.tensordot(strains, self.elasticity[0], (-1, 1))
        return np.asarray(strains @ self.elasticity[self.row].swapaxes(-1, -2))

    def at_nodes(self, displacement: Array) -> Array:
        """Stress in Pa at the nodes wanted of a displacement (n, dim) in m, shape (wanted, 6)."""
        return self.at_nodes_of_each(displacement[None])[0]

    def at_nodes_of_each(self, displacements: Array) -> Array:
        """The same of k displacements, shape (k, n, dim), in one go: shape (k, wanted, 6)."""
        return self._smoothed(self.at_samples(displacements))

    def at_nodes_of_pairs(self, first: Array, second: Array) -> Array:
        """Stress of the strains sym(grad a^T grad b) of k pairs of displacements a, b.

        Args:
            first: Displacements a at `nodes`, shape (k, n, dim).
            second: Displacements b.

        Returns:
            Stress in Pa at the nodes wanted, shape (k, wanted, 6).
        """
        one, other = self._gradients(first), self._gradients(second)
        return self._smoothed(self._stresses(one.swapaxes(-1, -2) @ other))

    def _smoothed(self, sampled: Array) -> Array:
        """Stresses at the nodes wanted of those at the sampling points, shape (k, wanted, 6)."""
        columns = sampled.reshape(len(self.slopes) * self.slopes.shape[1], -1)
        nodal = self.smoothing @ columns
        return np.asarray(nodal.reshape(len(nodal), -1, 6).swapaxes(0, 1))


def stress_recovery(
    mesh: FieldMesh, elasticity: Array, row: Indices, wanted: Indices | None = None
) -> StressRecovery:
    """Prepare the recovery at some nodes of a mesh.

    Args:
        mesh: Mesh of the fields.
        elasticity: The elasticities there are, as in `StressRecovery`, shape (rows, 6, strains).
        row: Row of it at each sampling point of each cell, shape (cells, s).
        wanted: Nodes, ascending; all of them if not given.
    """
    nodes = np.arange(len(mesh.nodes)) if wanted is None else wanted
    node, vertex, weight = _pairs(mesh, nodes)
    patches = _patches(mesh, np.unique(vertex))
    used = np.unique(patches.indices)
    around, numbered = np.unique(mesh.cells[used], return_inverse=True)
    places = mesh.nodes[mesh.cells[used], : mesh.cell.dim]
    columns = (patches.data, np.searchsorted(used, patches.indices), patches.indptr)
    patches = sparse.csr_array(columns, shape=(len(mesh.nodes), len(used)))
    samples = np.einsum("sn,cni->csi", mesh.cell.values, places, optimize=True)
    smoothing = _smoothing(mesh, samples, patches, (node, vertex, weight))
    cells = numbered.reshape(places.shape[:2])
    slopes = _slopes(mesh.cell, places)
    return StressRecovery(
        mesh, around, cells, slopes, elasticity, row[used], smoothing[nodes], used
    )


def _slopes(cell: ReferenceCell, places: Array) -> Array:
    """Derivatives of the shape functions of cells with nodes at places (cells, nodes, dim)."""
    jacobian = np.einsum("snj,cni->csij", cell.slopes, places, optimize=True)
    slopes = np.einsum("snk,cskj->csjn", cell.slopes, np.linalg.inv(jacobian), optimize=True)
    return np.ascontiguousarray(slopes)


def strains_of(gradient: Array) -> Array:
    """Strains of displacement gradients du_i/dx_j, shape (..., 1, 3 or 6), shears doubled."""
    dim = gradient.shape[-1]
    shears = {1: (), 2: ((0, 1),), 3: ((0, 1), (1, 2), (0, 2))}[dim]
    parts = [gradient[..., i, i] for i in range(dim)]
    parts += [gradient[..., i, j] + gradient[..., j, i] for i, j in shears]
    return np.stack(parts, axis=-1)


def _smoothing(
    mesh: FieldMesh,
    samples: Array,
    patches: sparse.csr_array,
    pairs: tuple[Indices, Indices, Array],
) -> sparse.csr_array:
    """Weights of the samples of cells at each node, shape (n, cells s).

    Args:
        mesh: Mesh of the fields.
        samples: Places of the samples of each cell, shape (cells, s, dim).
        patches: Cells of the patch of each vertex.
        pairs: As of `_pairs`.
    """
    node, vertex, weight = pairs
    per_cell, size = samples.shape[1], np.diff(patches.indptr)[vertex]
    rows, columns, values = [], [], []
    for count in np.unique(size):
        listed = np.flatnonzero(size == count)
        _, first = np.unique(vertex[listed], return_index=True)
        for chosen in np.split(listed, first[_AT_ONCE::_AT_ONCE]):
            few, patch = np.unique(vertex[chosen], return_inverse=True)
            cells = patches.indices[patches.indptr[few][:, None] + np.arange(count)]
            points = (cells[:, :, None] * per_cell + np.arange(per_cell)).reshape(len(few), -1)
            centre = mesh.nodes[few, None, : mesh.cell.dim]
            places = mesh.nodes[node[chosen], : mesh.cell.dim] - centre[patch, 0]
            own = samples.reshape(-1, mesh.cell.dim)[points] - centre
            found = fitted(own, places, patch, mesh.cell.degree) * weight[chosen, None]
            rows.append(np.repeat(node[chosen], points.shape[1]))
            columns.append(points[patch].ravel())
            values.append(found.ravel())
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.coo_array(triplets, shape=(len(mesh.nodes), samples[..., 0].size)).tocsr()


def _patches(mesh: FieldMesh, vertices: Indices) -> sparse.csr_array:
    """Cells around some vertices, and around their vertices where these are too few.

    Rows of other nodes are empty.
    """
    dim, degree = mesh.cell.dim, mesh.cell.degree
    wanted = _POINTS_PER_COEFFICIENT[dim] * comb(dim + degree, degree)
    corners = mesh.cells[:, : mesh.cell.corners]
    needed = np.zeros(len(mesh.nodes), dtype=bool)
    needed[vertices] = True
    nearest = _incidence(corners, needed)
    few = needed & (nearest.sum(axis=1) * len(mesh.cell.samples) < wanted)
    next_ones = few | (nearest @ (nearest.T @ few) > 0)
    around = _incidence(corners, needed | next_ones)
    enlarged = _rows(few) @ around @ around.T @ around
    chosen = (enlarged + _rows(needed) @ around).tocsr()
    chosen.sort_indices()
    return chosen


def _incidence(corners: Indices, near: Mask) -> sparse.csr_array:
    """Ones for each corner of the cells that have one of some nodes, shape (nodes, cells)."""
    cells = np.flatnonzero(near[corners].any(axis=1))
    entries = (corners[cells].ravel(), np.repeat(cells, corners.shape[1]))
    shape = (len(near), len(corners))
    return sparse.coo_array((np.ones(len(entries[0])), entries), shape=shape).tocsr()


def _rows(chosen: Mask) -> sparse.csr_array:
    """The matrix that keeps some rows of another one, and makes the others empty."""
    number = np.flatnonzero(chosen)
    shape = (len(chosen), len(chosen))
    return sparse.coo_array((np.ones(len(number)), (number, number)), shape=shape).tocsr()


def _pairs(mesh: FieldMesh, wanted: Indices) -> tuple[Indices, Indices, Array]:
    """Node, vertex whose polynomial is evaluated there, and its weight; by ascending vertex."""
    count = len(mesh.nodes)
    chosen = np.zeros(count, dtype=bool)
    chosen[wanted] = True
    cells = mesh.cells[chosen[mesh.cells].any(axis=1)]
    keys = [
        (cells[:, parent] * count + cells[:, node])[chosen[cells[:, node]]]
        for node, parents in enumerate(mesh.cell.parents)
        for parent in parents
    ]
    vertex, node = np.divmod(np.unique(np.concatenate(keys)), count)
    return node, vertex, 1.0 / np.bincount(node)[node]
