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
from fenics_nnm.fem.loaded_form import SIMPLICES, points_of_large_deflection
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.stress import STRAINS_OF, constant_law
from fenics_nnm.mechanics.pairs import Pairs

#: Quadrature points that are dealt with at once, so that what belongs to them stays in the cache.
_AT_ONCE = 2000


@dataclass(frozen=True, slots=True)
class _Cells:
    """Some cells of one material, with all their points x.

    Attributes:
        nodes: Blocks of degrees of freedom, shape (cells, nodes).
        inverse: Derivative of reference coordinate A by x_i, shape (A, i, x).
        weight: Weight of the points times the extent of the body, shape (x,).
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
        geometry = coordinate_element(mesh).degree
        straight = geometry == 1 and mesh.topology.cell_name() in SIMPLICES
        # one point stands for all where the map of a cell is linear
        self._map = _slopes(cell, geometry, points[:1] if straight else points)

    def third(self, phi: Array) -> Array:
        """phi_i . f'''[phi_j, phi_k, phi_l] of shapes (n_owned, k), (k, k, k, k); on all ranks."""
        pairs, local = Pairs.of(phi.shape[1]), self._local(phi)
        count = len(pairs.first)
        whole = np.zeros((count, count))
        for cells in self._chunks():
            strain = _strains(self._gradients(cells, local))
            stress = cells.law @ (strain * cells.weight)
            whole += strain.reshape(count, -1) @ stress.reshape(count, -1).T
        whole = np.asarray(self._solid.tagged.mesh.comm.allreduce(whole))
        both = whole[pairs.place[:, :, None, None], pairs.place]
        return np.asarray(both + both.transpose(0, 2, 1, 3) + both.transpose(0, 3, 2, 1))

    def _gradients(self, cells: _Cells, local: Array) -> Array:
        """Gradients of the masters, d u_i / d x_j, shape (k, j, i, x)."""
        moved = local[:, cells.nodes].transpose(0, 3, 2, 1)  # masters, components, nodes, cells
        reference = self._slopes @ moved[:, :, None]  # (k, i, A, q, cells)
        flat = reference.reshape(*reference.shape[:3], -1)
        return np.einsum("kiax,ajx->kjix", flat, cells.inverse)

    def _local(self, phi: Array) -> Array:
        """Masters at all local degrees of freedom, shape (k, blocks, dim)."""
        solid, dim = self._solid, self._solid.tagged.dim
        function, columns = fem.Function(solid.space), []
        for column in phi.T:
            function.x.array[: solid.owned] = column
            function.x.scatter_forward()
            columns.append(function.x.array.copy())
        return np.stack(columns).reshape(len(columns), -1, dim)

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
        x = mesh.geometry.x[cell_nodes(mesh)[cells]][:, :, :dim].transpose(2, 1, 0)
        J = self._map @ x[:, None]  # (i, A, q or 1, cells)
        J = J.reshape(dim, dim, -1).transpose(2, 0, 1)
        repeats = len(self._weights) // self._map.shape[1]
        size = np.tile(np.abs(np.linalg.det(J)), repeats) * solid.body.extent
        inverse = np.tile(np.linalg.inv(J).transpose(1, 2, 0), repeats)
        weight = np.repeat(self._weights, len(cells)) * size
        return _Cells(solid.space.dofmap.list[cells], inverse, weight, law)


def _slopes(cell: basix.CellType, degree: int, points: Array) -> Array:
    """Derivatives of Lagrange's basis at reference points, shape (dim, q, nodes)."""
    element = basix.create_element(
        basix.ElementFamily.P, cell, degree, basix.LagrangeVariant.gll_warped
    )
    return np.ascontiguousarray(element.tabulate(1, points)[1:, :, :, 0])


def _strains(slope: Array) -> Array:
    """sym(grad a^T grad b) of all pairs, with engineering shear strains, shape (p, m, x).

    Args:
        slope: Gradients d u_i / d x_j, shape (k, j, i, x).
    """
    count, dim, _, points = slope.shape
    pairs, places = Pairs.of(count), STRAINS_OF[dim]
    found = np.empty((len(pairs.first), len(places), points))
    for one in range(count):
        rows = pairs.place[one, one:]
        for m, (i, j) in enumerate(places):
            own = found[rows[0] : rows[-1] + 1, m]
            np.einsum("ix,kix->kx", slope[one, i], slope[one:, j], out=own)
            if i != j:
                own += np.einsum("ix,kix->kx", slope[one, j], slope[one:, i])
    return found
