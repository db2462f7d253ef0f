"""Numbers at the vertices of a mesh."""

from __future__ import annotations

import numpy as np
from dolfinx import mesh as dmesh

from fenics_nnm.arrays import Indices


def at_vertices(mesh: dmesh.Mesh, numbering: Indices) -> Indices:
    """Entry at each local vertex of a numbering by cells, of a space or of the geometry.

    Args:
        mesh: Mesh.
        numbering: One row of degrees of freedom, or nodes, for each local cell.

    Lagrange bases number the vertices of a cell before its edges.
    """
    topology = mesh.topology
    topology.create_connectivity(topology.dim, 0)
    corners = topology.connectivity(topology.dim, 0)
    vertices = corners.array.reshape(corners.num_nodes, -1)
    count = topology.index_map(0).size_local + topology.index_map(0).num_ghosts
    found = np.full(count, -1, dtype=np.int64)
    found[vertices] = numbering[:, : vertices.shape[1]]
    return found
