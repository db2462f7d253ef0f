"""A mesh at the places to which a static state moves it, for as long as a context lasts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from dolfinx import fem

from fenics_nnm.fem.compat import cell_nodes, coordinate_element
from fenics_nnm.fem.solid import Solid


@contextmanager
def deformed(solid: Solid) -> Iterator[None]:
    """Move the nodes of the mesh by the static state of a body, and back again at the end."""
    if solid.state is None:
        yield
        return
    geometry, dim = solid.tagged.mesh.geometry, solid.tagged.dim
    before = geometry.x.copy()
    nodes, moved = _moved(solid)
    geometry.x[nodes, :dim] += moved
    try:
        yield
    finally:
        geometry.x[:] = before


def _moved(solid: Solid) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of the geometry on this rank and their displacements in m, (n,) and (n, dim)."""
    assert solid.state is not None
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    degree = coordinate_element(mesh).degree
    space = fem.functionspace(mesh, ("Lagrange", degree, (dim,)))
    at_nodes = fem.Function(space)
    at_nodes.interpolate(solid.state.displacement)
    at_nodes.x.scatter_forward()
    blocks = at_nodes.x.array.reshape(-1, dim)
    return cell_nodes(mesh).ravel(), blocks[space.dofmap.list].reshape(-1, dim)
