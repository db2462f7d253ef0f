r"""Third derivative of the internal force of a body along masters, from gradients at points.

With the strains eta_ab = sym(grad a^T grad b) St. Venant and Kirchhoff's law C gives exactly

    f'''[a, b, c] . d = int eta_ab C eta_cd + eta_ac C eta_bd + eta_bc C eta_ad dx,

whatever the state: one Gram matrix of all pairs of masters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import basix
import numpy as np
from dolfinx import fem

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.compat import cell_nodes, coordinate_element
from fenics_nnm.fem.loaded_form import points_of_large_deflection
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.stress import STRAINS_OF, constant_law
from fenics_nnm.mechanics.pairs import Pairs

#: Quadrature points that are dealt with at once, so that what belongs to them stays in the cache.
_AT_ONCE = 2000


@dataclass(frozen=True, slots=True)
class _Cells:
    """Some cells of one material.

    Attributes:
        nodes: Blocks of degrees of freedom, shape (cells, nodes).
        inverse: Derivative of reference coordinate A by x_i, shape (A, i, q, 1, cells).
        weight: Weight of the points times the extent of the body, shape (q, 1, cells).
        law: Stress by strain, with engineering shear strains, Pa, shape (m, m).
    """

    nodes: Indices
    inverse: Array
    weight: Array
    law: Array


class PointDeflection:
    """The derivative of a body whose materials do not turn from point to point."""

    def __init__(self, solid: Solid) -> None:
        """Prepare for a body."""
        self._solid = solid
        mesh, degree = solid.tagged.mesh, solid.body.degree
        cell = mesh.basix_cell()
        points, self._weights = basix.make_quadrature(cell, points_of_large_deflection(solid))
        self._slopes = _slopes(cell, degree, points)
        self._map = _slopes(cell, coordinate_element(mesh).degree, points)

    def third(self, phi: Array) -> Array:
        """phi_i . f'''[phi_j, phi_k, phi_l] of shapes (n_owned, k), (k, k, k, k); on all ranks."""
        pairs, local = Pairs.of(phi.shape[1]), self._local(phi)
        whole = np.zeros((len(pairs.first),) * 2)
        for cells in self._chunks():
            slope = self._gradients(cells, local)
            strain = _strains(slope[..., pairs.first, :], slope[..., pairs.second, :])
            stress = (cells.law @ strain.reshape(len(strain), -1)).reshape(strain.shape)
            columns = (
                each.transpose(2, 0, 1, 3).reshape(len(whole), -1)
                for each in (strain * cells.weight, stress)
            )
            one, other = columns
            whole += one @ other.T
        whole = np.asarray(self._solid.tagged.mesh.comm.allreduce(whole))
        both = whole[pairs.place[:, :, None, None], pairs.place]
        return np.asarray(both + both.transpose(0, 2, 1, 3) + both.transpose(0, 3, 2, 1))

    def _gradients(self, cells: _Cells, local: Array) -> Array:
        """Gradients of the masters, d u_i / d x_j, shape (i, j, q, k, cells)."""
        moved = local[cells.nodes].transpose(1, 2, 3, 0)  # nodes, components, masters, cells
        nodes, dim, count, c = moved.shape
        reference = (self._slopes @ moved.reshape(nodes, -1)).reshape(dim, -1, dim, count, c)
        return np.einsum("aqikc,ajqlc->ijqkc", reference, cells.inverse)

    def _local(self, phi: Array) -> Array:
        """Masters at all local degrees of freedom, shape (blocks, dim, k)."""
        solid, dim = self._solid, self._solid.tagged.dim
        function, columns = fem.Function(solid.space), []
        for column in phi.T:
            function.x.array[: solid.owned] = column
            function.x.scatter_forward()
            columns.append(function.x.array.copy())
        return np.stack(columns, axis=1).reshape(-1, dim, len(columns))

    def _chunks(self) -> Iterator[_Cells]:
        """All owned cells, some at a time."""
        solid, theory = self._solid, self._solid.body.theory
        owned = solid.tagged.mesh.topology.index_map(solid.tagged.dim).size_local
        at_once = max(1, _AT_ONCE // len(self._weights))
        for material, cells in solid.regions.parts:
            mine, law = cells[cells < owned], constant_law(material, theory)
            for first in range(0, len(mine), at_once):
                yield self._cells(mine[first : first + at_once], law)

    def _cells(self, cells: Indices, law: Array) -> _Cells:
        solid, dim = self._solid, self._solid.tagged.dim
        mesh = solid.tagged.mesh
        x = mesh.geometry.x[cell_nodes(mesh)[cells]][:, :, :dim].transpose(1, 2, 0)
        J = (self._map @ x.reshape(len(x), -1)).reshape(dim, -1, dim, len(cells))
        J = J.transpose(1, 3, 2, 0)  # q, cells, i, A
        weight = self._weights[:, None] * np.abs(np.linalg.det(J)) * solid.body.extent
        inverse = np.ascontiguousarray(np.linalg.inv(J).transpose(2, 3, 0, 1)[:, :, :, None])
        return _Cells(solid.space.dofmap.list[cells], inverse, weight[:, None, :], law)


def _slopes(cell: basix.CellType, degree: int, points: Array) -> Array:
    """Derivatives of Lagrange's basis at reference points, shape (dim * q, nodes)."""
    element = basix.create_element(
        basix.ElementFamily.P, cell, degree, basix.LagrangeVariant.gll_warped
    )
    table = element.tabulate(1, points)[1:, :, :, 0]
    return np.ascontiguousarray(table.reshape(-1, table.shape[2]))


def _strains(one: Array, other: Array) -> Array:
    """sym(one^T other) with engineering shear strains, shape (m, q, tensors, cells)."""

    def product(i: int, j: int) -> Array:
        return np.einsum("mqpc,mqpc->qpc", one[:, i], other[:, j])

    return np.stack(
        [
            product(i, j) if i == j else product(i, j) + product(j, i)
            for i, j in STRAINS_OF[len(one)]
        ]
    )
