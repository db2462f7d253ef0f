"""How a mesh that one rank has read is spread over the ranks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from dolfinx import mesh as dmesh
from dolfinx.cpp.mesh import cell_entity_type, to_type
from dolfinx.graph import adjacencylist
from mpi4py import MPI

from fenics_nnm.arrays import Indices
from fenics_nnm.fem.compat import cell_permutation, distribute_entity_data, ufl_mesh
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fem.raw_mesh import RawMesh


def distributed(
    read: Callable[[], RawMesh], metres: float, comm: MPI.Comm
) -> tuple[dmesh.Mesh, dict[str, Indices], dict[str, Indices]]:
    """Spread the mesh that rank 0 reads over the ranks.

    Args:
        read: Called on rank 0 alone; what it raises is raised on all ranks.
        metres: Metres in one unit of the coordinates.
        comm: Communicator of the mesh.

    Returns:
        Mesh, local facets of each named group, local cells of each named group.
    """
    raw = None

    def on_first() -> tuple[int, int, int, list[str], dict[str, Indices]]:
        nonlocal raw
        raw = _in_order_of_dolfinx(read())
        return raw.cell_type, raw.dim, raw.cells.shape[1], list(raw.facets), dict(raw.groups)

    cell_type, dim, nodes, names, groups = on_root(comm, on_first)
    if raw is None:
        no_cells = np.empty((0, nodes), dtype=np.int64)
        raw = RawMesh(cell_type, dim, np.empty((0, dim)), no_cells, {}, {})
    # by name: dolfinx 0.10 exchanged the last two
    mesh = dmesh.create_mesh(
        comm, raw.cells, x=raw.points * metres, e=ufl_mesh(cell_type, dim, np.float64)
    )
    mesh.topology.create_connectivity(dim - 1, dim)
    mesh.topology.create_connectivity(dim, dim - 1)
    facets = {name: _local_facets(mesh, raw, name) for name in names}
    read_as = mesh.topology.original_cell_index
    cells: dict[str, Indices] = {
        name: np.flatnonzero(np.isin(read_as, rows)).astype(np.int32)
        for name, rows in groups.items()
    }
    return mesh, facets, cells


def _in_order_of_dolfinx(raw: RawMesh) -> RawMesh:
    """The mesh with the nodes of its cells and facets in dolfinx's order."""
    cell = to_type(str(ufl_mesh(raw.cell_type, raw.dim, np.float64).ufl_cell()))
    facet = cell_entity_type(cell, raw.dim - 1, 0)
    return replace(
        raw,
        cells=raw.cells[:, cell_permutation(cell, raw.cells.shape[1])],
        facets={
            name: nodes[:, cell_permutation(facet, nodes.shape[1])] if len(nodes) else nodes
            for name, nodes in raw.facets.items()
        },
    )


def _local_facets(mesh: dmesh.Mesh, raw: RawMesh, group: str) -> Indices:
    width = mesh.comm.bcast(raw.facets[group].shape[1] if mesh.comm.rank == 0 else 0, root=0)
    nodes = raw.facets.get(group, np.empty((0, width), dtype=np.int64))
    dim = raw.dim - 1
    entities, values = distribute_entity_data(
        mesh, dim, nodes, np.zeros(len(nodes), dtype=np.int32)
    )
    tags = dmesh.meshtags_from_entities(mesh, dim, adjacencylist(entities), values)
    return tags.indices
