"""What one rank reads of a mesh, and how it is spread over the ranks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from dolfinx import mesh as dmesh
from dolfinx.graph import adjacencylist
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.compat import distribute_entity_data, ufl_mesh
from fenics_nnm.fem.parallel import on_root


@dataclass(frozen=True, slots=True)
class RawMesh:
    """A mesh of one cell type as rank 0 reads it; empty on the other ranks.

    Attributes:
        cell_type: gmsh's number of the element type.
        dim: Dimension of the body.
        points: Coordinates in the unit of the input, shape (nodes, dim).
        cells: Rows of `points` of each cell in dolfinx's order, shape (cells, nodes a cell).
        facets: Nodes of each facet of a named group, in dolfinx's order of the facet.
        groups: Rows of `cells` of each named group.
        nodes: Rows of `points` of each named set of nodes.
        attached: Masses and springs, in the units of the file, which must be SI units.
        notes: What was left out or changed on reading, a line each.
    """

    cell_type: int
    dim: int
    points: Array
    cells: Indices
    facets: Mapping[str, Indices]
    groups: Mapping[str, Indices]
    nodes: Mapping[str, Indices] = field(default_factory=dict)
    attached: tuple[Attachment, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SpreadMesh:
    """A mesh that is spread over the ranks.

    Attributes:
        mesh: Mesh in metres.
        facets: Local facets of each named group.
        cells: Local cells, ghosts included, of each named group.
        nodes: Local nodes of the geometry, ghosts included, of each named set of nodes.
        attached: Those of `RawMesh`, with as many components as the mesh has dimensions.
        notes: Those of `RawMesh`.
    """

    mesh: dmesh.Mesh
    facets: dict[str, Indices]
    cells: dict[str, Indices]
    nodes: dict[str, Indices]
    attached: tuple[Attachment, ...]
    notes: tuple[str, ...]


def distributed(read: Callable[[], RawMesh], metres: float, comm: MPI.Comm) -> SpreadMesh:
    """Spread the mesh that rank 0 reads over the ranks.

    Args:
        read: Called on rank 0 alone; what it raises is raised on all ranks.
        metres: Metres in one unit of the coordinates.
        comm: Communicator of the mesh.
    """
    raw = None

    def on_first() -> tuple[int, int, int, list[str], RawMesh]:
        nonlocal raw
        raw = read()
        none = np.empty((0, raw.dim))
        named = replace(raw, points=none, cells=none.astype(np.int64), facets={})
        return raw.cell_type, raw.dim, raw.cells.shape[1], list(raw.facets), named

    cell_type, dim, width, names, named = on_root(comm, on_first)
    if raw is None:
        no_cells = np.empty((0, width), dtype=np.int64)
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
        for name, rows in named.groups.items()
    }
    numbers = np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)
    nodes: dict[str, Indices] = {
        name: np.flatnonzero(np.isin(numbers, rows)) for name, rows in named.nodes.items()
    }
    return SpreadMesh(mesh, facets, cells, nodes, _attached(named, metres), named.notes)


def _attached(raw: RawMesh, metres: float) -> tuple[Attachment, ...]:
    if raw.attached and metres != 1:
        raise MeshError(
            f"{raw.attached[0].key} cannot be followed: the unit of its value is not known where "
            f"lengths are not in m: leave it out, and give it as [[{raw.attached[0].kind}]] of the "
            "study in SI units"
        )
    return tuple(
        replace(each, point=each.point[: raw.dim], values=each.values[: raw.dim])
        for each in raw.attached
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
