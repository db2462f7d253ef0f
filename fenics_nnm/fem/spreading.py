"""How a mesh that one rank has read is spread over the ranks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import basix
import numpy as np
from dolfinx import cpp
from dolfinx import mesh as dmesh
from dolfinx.cpp.mesh import cell_entity_type, to_type
from dolfinx.graph import adjacencylist
from mpi4py import MPI

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.compat import cell_permutation, distribute_entity_data, ufl_mesh
from fenics_nnm.fem.constraints import LinearConstraints
from fenics_nnm.fem.cutting import can_cut, cut, pairs_listed, sharing_facets
from fenics_nnm.fem.kept_mesh import MeshAsRead, mesh_as_read
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fem.raw_mesh import RawMesh

#: Parts of ranks may differ in size by this part, so that their border is small.
_IMBALANCE = 0.03


@dataclass(frozen=True, slots=True)
class SpreadMesh:
    """A mesh that is spread over the ranks.

    Attributes:
        mesh: Mesh in metres.
        facets: Local facets of each named group.
        cells: Local cells, ghosts included, of each named group.
        nodes: Local nodes of the geometry, ghosts included, of each named set of nodes.
        attached: Those of `RawMesh`, with as many components as the mesh has dimensions.
        constraints: Those of `RawMesh`, in SI units.
        notes: Those of `RawMesh`.
        as_read: The mesh before it was spread.
    """

    mesh: dmesh.Mesh
    facets: dict[str, Indices]
    cells: dict[str, Indices]
    nodes: dict[str, Indices]
    attached: tuple[Attachment, ...]
    constraints: LinearConstraints
    notes: tuple[str, ...]
    as_read: MeshAsRead


def distributed(read: Callable[[], RawMesh], metres: float, comm: MPI.Comm) -> SpreadMesh:
    """Spread the mesh that rank 0 reads over the ranks.

    Args:
        read: Called on rank 0 alone; what it raises is raised on all ranks.
        metres: Metres in one unit of the coordinates.
        comm: Communicator of the mesh.
    """
    raw, as_read = None, MeshAsRead()

    def on_first() -> tuple[int, int, int, list[str], RawMesh, str]:
        nonlocal raw, as_read
        given = read()
        as_read = mesh_as_read(given, metres)
        raw = _in_order_of_dolfinx(given)
        none = np.empty((0, raw.dim))
        named = replace(raw, points=none, cells=none.astype(np.int64), facets={})
        return raw.cell_type, raw.dim, raw.cells.shape[1], list(raw.facets), named, as_read.digest

    cell_type, dim, width, names, named, digest = on_root(comm, on_first)
    if raw is None:
        no_cells = np.empty((0, width), dtype=np.int64)
        raw = RawMesh(cell_type, dim, np.empty((0, dim)), no_cells, {}, {})
    # by name: dolfinx 0.10 exchanged the last two
    mesh = dmesh.create_mesh(
        comm,
        raw.cells,
        x=raw.points * metres,
        e=ufl_mesh(cell_type, dim, np.float64),
        partitioner=_by_first(raw) if comm.size > 1 and can_cut() else None,
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
    attached, constraints = _attached(named, metres), _constraints(named, metres)
    as_read = replace(as_read, digest=digest)
    return SpreadMesh(mesh, facets, cells, nodes, attached, constraints, named.notes, as_read)


def _by_first(raw: RawMesh) -> Callable[..., Any]:
    """How dolfinx is to spread cells that rank 0 has: cut there, with no messages, in the end.

    dolfinx's own way has all ranks exchange a graph of which one has all (benchmarks/README.md).
    """

    def ranks_of(comm: MPI.Comm, parts: int, *given: Any) -> Any:
        owners: Indices = np.empty(0, dtype=np.int32)
        if len(raw.cells):
            cell = _cell(raw.cell_type, raw.dim).name
            facets = basix.topology(basix.CellType[cell])[raw.dim - 1]
            pairs = sharing_facets(raw.cells, facets)
            owners = cut(pairs_listed(pairs, len(raw.cells)), parts, _IMBALANCE).astype(np.int32)
        return cpp.graph.AdjacencyList_int32(owners[:, None])

    return ranks_of


def _constraints(raw: RawMesh, metres: float) -> LinearConstraints:
    carrying = [each for each in raw.constraints.references if each.attached]
    if carrying and metres != 1:
        raise MeshError(
            f"{carrying[0].key}: its mass or springs cannot be followed: the unit of their values "
            "is not known where lengths are not in m: leave them out, and give them in [[rigid]] "
            "of the study in SI units"
        )
    return raw.constraints.scaled(metres)


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


def _cell(cell_type: int, dim: int) -> Any:
    """Type of a cell as dolfinx has it."""
    return to_type(str(ufl_mesh(cell_type, dim, np.float64).ufl_cell()))


def _in_order_of_dolfinx(raw: RawMesh) -> RawMesh:
    """The mesh with the nodes of its cells and facets in dolfinx's order."""
    cell = _cell(raw.cell_type, raw.dim)
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
