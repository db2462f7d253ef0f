"""Lagrange cells in the order of VTK: their reference shapes, and what VTK calls them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import basix
import numpy as np
from dolfinx.cpp.io import perm_vtk
from dolfinx.mesh import to_type

from fenics_nnm.arrays import Array, Indices


class _Kind(NamedTuple):
    shape: str
    degree: int
    stored: int
    written: int


#: Shape, degree, VTK's number in branch.h5 (any degree) and VTK's number of that very degree.
_KINDS = (
    _Kind("interval", 1, 3, 3),
    _Kind("interval", 2, 68, 21),
    _Kind("triangle", 1, 5, 5),
    _Kind("triangle", 2, 69, 22),
    _Kind("quadrilateral", 1, 9, 9),
    _Kind("quadrilateral", 2, 70, 28),
    _Kind("tetrahedron", 1, 10, 10),
    _Kind("tetrahedron", 2, 71, 24),
    _Kind("hexahedron", 1, 12, 12),
    _Kind("hexahedron", 2, 72, 29),
)

#: Shapes of facets by their number of vertices; all facets of a cell are alike.
_FACET_SHAPES = {2: "interval", 3: "triangle", 4: "quadrilateral"}

#: VTK's number of a vertex, the facet of a line.
_VERTEX = 1

#: VTK's numbers of facets by dimension of the body, degree and number of nodes.
_FACETS = {
    **{(1, degree, 1): _VERTEX for degree in (1, 2)},
    (2, 1, 2): 3,
    (2, 2, 3): 21,
    (3, 1, 3): 5,
    (3, 2, 6): 22,
    (3, 1, 4): 9,
    (3, 2, 9): 28,
}


@dataclass(frozen=True, slots=True)
class ReferenceCell:
    """A Lagrange cell of degree 1 or 2 with its nodes in the order of VTK.

    Attributes:
        dim: Dimension of the cell.
        degree: 1 or 2.
        written: VTK's number of the cell of this degree: 24 for a quadratic tetrahedron.
        nodes: Places of the nodes in reference coordinates, shape (nodes, dim).
        corners: Number of vertices, which are the first nodes.
        parents: For each node the vertices of the vertex, edge, face or cell that it belongs to.
        facets: Nodes of each facet in VTK's order of the facet, shape (facets, nodes a facet).
        samples: Points in reference coordinates at which stress is best, shape (s, dim).
        values: Shape functions at these points, shape (s, nodes).
        slopes: Their derivatives by the reference coordinates, shape (s, nodes, dim).
    """

    dim: int
    degree: int
    written: int
    nodes: Array
    corners: int
    parents: tuple[Indices, ...]
    facets: Indices
    samples: Array
    values: Array
    slopes: Array


@cache
def reference_cell(stored: int) -> ReferenceCell:
    """The cell that branch.h5 calls by VTK's number `stored`.

    Stresses are sampled at the Gauss points of degree 2 (p - 1), where the derivatives of a finite
    element solution of degree p are best (Zienkiewicz and Zhu 1992, part 1).
    """
    kind = next(kind for kind in _KINDS if kind.stored == stored)
    cell = basix.CellType[kind.shape]
    element, order = _lagrange(kind)
    samples, _ = basix.make_quadrature(cell, 2 * (kind.degree - 1))
    table = element.tabulate(1, samples)[:, :, :, 0]
    nodes = element.points[order]
    return ReferenceCell(
        dim=nodes.shape[1],
        degree=kind.degree,
        written=kind.written,
        nodes=nodes,
        corners=len(basix.geometry(cell)),
        parents=_parents(cell, element, order),
        facets=_facets(cell, kind, nodes),
        samples=samples,
        values=table[0][:, order],
        slopes=np.moveaxis(table[1:], 0, -1)[:, order],
    )


def facet_type(dim: int, degree: int, nodes: int) -> int:
    """VTK's number of the facets of a body."""
    return _FACETS[dim, degree, nodes]


def facet_parents(written: int) -> tuple[Indices, ...]:
    """`ReferenceCell.parents` of a facet that VTK calls by the number `written`."""
    if written == _VERTEX:
        return (np.array([0]),)
    return reference_cell(next(kind.stored for kind in _KINDS if kind.written == written)).parents


def _lagrange(kind: _Kind) -> tuple[basix.finite_element.FiniteElement, Indices]:
    """Lagrange element, and its degree of freedom at each node in VTK's order."""
    shape, variant = basix.CellType[kind.shape], basix.LagrangeVariant.gll_warped
    element = basix.create_element(basix.ElementFamily.P, shape, kind.degree, variant)
    return element, np.argsort(perm_vtk(to_type(kind.shape), element.dim))


def _parents(
    cell: basix.CellType, element: basix.finite_element.FiniteElement, order: Indices
) -> tuple[Indices, ...]:
    node_of = np.argsort(order)
    found = [np.empty(0, dtype=np.int64)] * element.dim
    for dofs, corners in zip(element.entity_dofs, basix.topology(cell), strict=True):
        for inside, around in zip(dofs, corners, strict=True):
            for dof in inside:
                found[node_of[dof]] = node_of[np.array(around)]
    return tuple(found)


def _facets(cell: basix.CellType, kind: _Kind, nodes: Array) -> Indices:
    """Nodes of each facet, found by their places."""
    dim = nodes.shape[1]
    if dim == 1:
        return np.array([[0], [1]])
    facets = basix.topology(cell)[dim - 1]
    shape = _FACET_SHAPES[len(facets[0])]
    element, order = _lagrange(_Kind(shape, kind.degree, 0, 0))
    within, corners = element.points[order], basix.geometry(cell)
    rows = []
    for around in facets:
        base, tangents = corners[around[0]], corners[around[1:dim]] - corners[around[0]]
        places = base + within @ tangents
        rows.append(np.argmin(np.linalg.norm(nodes[None] - places[:, None], axis=2), axis=1))
    return np.array(rows)
