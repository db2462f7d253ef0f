"""Where lines meet facets with curved edges, from where they meet the straight ones."""

from __future__ import annotations

from functools import cache

import basix
import numpy as np

from fenics_nnm.arrays import Array

#: Steps of Newton's method, and the change of reference coordinates that ends it.
_STEPS, _ENOUGH = 20, 1e-13

#: A line may meet a facet beyond its edges by this part: there it goes on smoothly.
_BEYOND = 0.1

#: A line whose volume with the tangents is below this part of their lengths runs along the facet.
_FLAT = 1e-8

#: Of order 2 all variants have their nodes in the middle of edges.
_VARIANT = basix.LagrangeVariant.gll_warped

#: Cells of facets by their number of nodes and the dimension of space.
_CELLS: dict[tuple[int, ...], basix.CellType] = {
    (3, 2): basix.CellType.interval,
    (6, 3): basix.CellType.triangle,
    (9, 3): basix.CellType.quadrilateral,
}


def is_curved(nodes: Array) -> bool:
    """Whether facets with nodes of shape (m, k, dim) are of order 2."""
    return nodes.shape[1:] in _CELLS


def met_curved(
    nodes: Array, reference: Array, distance: float, point: Array, direction: Array
) -> float:
    """Distance along a line to a facet of order 2, from that to the straight one.

    Newton's method solves x(xi) = p + t d for the reference coordinates xi and the distance t.

    Args:
        nodes: Nodes of the facet in m, in the order of dolfinx, shape (k, dim).
        reference: Reference coordinates where the straight facet is met, shape (dim - 1,).
        distance: Distance to it in m.
        point: Point p in m, shape (dim,).
        direction: Unit vector d, shape (dim,).

    Returns:
        Distance in m; that of the straight facet where the curved one is not met near it.
    """
    element = _element(_CELLS[nodes.shape])
    xi, t = reference.copy(), distance
    for _ in range(_STEPS):
        values = element.tabulate(1, xi[None, :])[:, 0, :, 0]
        place, tangents = values[0] @ nodes, values[1:] @ nodes
        matrix = np.column_stack([*tangents, -direction])
        if abs(np.linalg.det(matrix)) <= _FLAT * np.prod(np.linalg.norm(matrix, axis=0)):
            return distance
        step = np.linalg.solve(matrix, point + t * direction - place)
        xi, t = xi + step[:-1], t + step[-1]
        if np.abs(xi - reference).max() > 1:
            return distance
        if np.abs(step[:-1]).max() < _ENOUGH:
            break
    simplex = len(nodes) != 9
    outside = max(-xi.min(), (xi.sum() if simplex else xi.max()) - 1)
    return float(t) if outside <= _BEYOND else distance


@cache
def _element(cell: basix.CellType) -> basix.finite_element.FiniteElement:
    """The element of a facet; lines from many points meet facets of one kind."""
    return basix.create_element(basix.ElementFamily.P, cell, 2, _VARIANT)
