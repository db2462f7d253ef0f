"""Mesh and fields of a body on rank 0, numbered alike on any number of ranks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from dolfinx.plot import vtk_mesh
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.blocks import Blocks, Data
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.elasticity import elasticity_at, region_of_cells
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.reference_cell import reference_cell
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.state_stress import state_stress_at
from fenics_nnm.fem.vertices import at_vertices
from fenics_nnm.fem.warming import Warming

#: Elasticities that differ by less than this part of the largest are the same.
_SAME_ELASTICITY = 1e-12


@dataclass(frozen=True, slots=True)
class Gathering:
    """The way to rank 0; all methods are to be called on all ranks.

    Cells are in the order of the input mesh, and nodes in the order in which these cells name
    them.

    Attributes:
        solid: Body.
        cell_type: VTK's number of the cells.
        cells: Nodes of the cells of this rank in VTK's order, by their numbers in the space.
        input_cell: Number of these cells in the input mesh.
        number: Number of each node of the space, on rank 0; empty on the others.
    """

    solid: Solid
    cell_type: int
    cells: Indices
    input_cell: Indices
    number: Indices

    @property
    def comm(self) -> MPI.Comm:
        """Communicator of the body."""
        return self.solid.tagged.mesh.comm

    def nodal(self, columns: Array) -> Array:
        """Fields on rank 0, shape (k, nodes, dim), of columns of owned unknowns (n_owned, k)."""
        dim = self.solid.tagged.dim
        return self.of_nodes(columns.reshape(-1, dim, columns.shape[1])).transpose(2, 0, 1)

    def blocks(self, columns: Array) -> Blocks:
        """The same fields as `nodal`, some at a time."""
        solid = self.solid
        nodes = solid.space.dofmap.index_map.size_global
        shape = (columns.shape[1], nodes, solid.tagged.dim)
        return Blocks(shape, lambda few: self.nodal(columns[:, few]))

    def of_nodes(self, owned: Array) -> Array:
        """Values of all nodes on rank 0, of those that each rank owns, shape (nodes, ...)."""
        whole = _gathered(self.comm, owned)
        found = np.empty_like(whole)
        found[self.number] = whole[: len(self.number)]
        return found

    def of_cells(self, owned: Any) -> Any:
        """Values of all cells on rank 0, of those of each rank, shape (cells, ...)."""
        whole, order = (_gathered(self.comm, part) for part in (owned, self.input_cell))
        return whole[np.argsort(order)]

    def mesh(self) -> tuple[Array, Indices]:
        """Places of the nodes in m, shape (nodes, 3), and nodes of the cells, on rank 0."""
        space = self.solid.space
        places = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
        return self.of_nodes(places), self.numbered(self.of_cells(self.cells))

    def numbered(self, nodes: Indices) -> Indices:
        """On rank 0 the file's numbers of nodes of the space."""
        return self.number[nodes] if self.comm.rank == 0 else nodes


def gathering(solid: Solid) -> Gathering:
    """Prepare the gathering of a body; to be called on all ranks."""
    mesh = solid.tagged.mesh
    listed, types, _ = vtk_mesh(solid.space)
    width = solid.space.dofmap.dof_layout.num_dofs
    local = listed.reshape(-1, width + 1)[:, 1:].astype(np.int32)
    cell_type = int(mesh.comm.allreduce(types.max(initial=0), op=MPI.MAX))
    numbered = solid.space.dofmap.index_map.local_to_global(local.ravel()).reshape(local.shape)
    input_cell = np.asarray(mesh.topology.original_cell_index[: len(local)], dtype=np.int64)
    whole, order = (_gathered(mesh.comm, part) for part in (numbered, input_cell))
    number: Indices = np.empty(0, dtype=np.int64)
    if mesh.comm.rank == 0:
        _, first = np.unique(whole[np.argsort(order)].ravel(), return_index=True)
        number = np.argsort(np.argsort(first))
    return Gathering(solid, cell_type, numbered, input_cell, number)


def gathered_basis(analysis: LinearAnalysis) -> Data:
    """What branch.h5 keeps of the mesh, its elasticity and the shapes.

    The shapes are blocks on all ranks, the others are on rank 0 alone.
    """
    reduction = analysis.reduction
    shapes = {"shapes": reduction.shapes, "residual_shapes": reduction.residual_shapes}
    if reduction.bent_shapes.size:
        shapes["bent_shapes"] = reduction.bent_shapes
    return gathered_shapes(analysis.solid, analysis.interface, shapes)


def gathered_shapes(solid: Solid, interface: ContactInterface, shapes: Mapping[str, Array]) -> Data:
    """The mesh of a body, its elasticity and shapes of it, as `gathered_basis`.

    Args:
        solid: Body.
        interface: Its contact points.
        shapes: Columns of owned unknowns, shape (n_owned, k), by their names.
    """
    way = gathering(solid)
    nodes, cells = way.mesh()
    elasticity, row = _elasticity(way)
    arrays = {
        "mesh/points": nodes,
        "mesh/cells": cells,
        "mesh/cell_type": np.array(way.cell_type),
        "mesh/region": way.of_cells(region_of_cells(solid)),
        "material/elasticity": elasticity,
        "material/row": row,
        **_contact(way, interface),
        **_static_state(way),
    }
    return Data(arrays, {f"basis/{name}": way.blocks(own) for name, own in shapes.items()})


def _static_state(way: Gathering) -> dict[str, Any]:
    """Displacement and stress of a body under steady loads, on rank 0; nothing without loads."""
    solid = way.solid
    if solid.state is None:
        return {}
    moved = way.nodal(solid.state.owned(solid.owned)[:, None])
    stress = state_stress_at(solid, reference_cell(way.cell_type).samples)
    return {
        "state/displacement": moved[0] if len(moved) else moved,
        "state/stress": way.of_cells(stress),
        **_warming(way, solid.state.loads.warming),
    }


def _warming(way: Gathering, warming: Warming) -> dict[str, Any]:
    """Warming of the nodes of a body in K on rank 0, where it changes from place to place."""
    low, high = warming.span
    if low == high:
        return {}
    return {"state/warming": way.of_nodes(warming.at_nodes(way.solid.space))}


def _elasticity(way: Gathering) -> tuple[Array, Indices]:
    """The elasticities there are, (rows, 6, strains), and the row at each sample of each cell.

    On rank 0; each rank tells those of its own cells apart first, so that no rank has all cells'.
    """
    order = np.argsort(way.input_cell)
    own = elasticity_at(way.solid, reference_cell(way.cell_type).samples)[order]
    resolution = _SAME_ELASTICITY * way.comm.allreduce(np.abs(own).max(initial=0.0), op=MPI.MAX)
    different, found = _different(own.reshape(-1, *own.shape[2:]), resolution)
    row = np.empty(own.shape[:2], dtype=np.int64)
    before = sum(way.comm.allgather(len(different))[: way.comm.rank])
    row[order] = found.reshape(row.shape) + before
    rows, renumbered = _different(_gathered(way.comm, different), resolution)
    whole = way.of_cells(row)
    return rows, renumbered[whole]


def _different(elasticity: Array, resolution: float) -> tuple[Array, Indices]:
    """Elasticities that differ by more than a resolution in Pa, and which each of some is."""
    rounded = np.round(elasticity / resolution)
    _, first, which = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return elasticity[first], which.reshape(len(elasticity))


def _contact(way: Gathering, interface: ContactInterface) -> dict[str, Any]:
    """Contact facets and what pressure unit forces make, on rank 0."""
    found = [
        (_facets(way, local), patch, side)
        for patch, sides in enumerate(interface.sides)
        for side, local in enumerate(sides)
    ]
    counts = [len(rows) for rows, _, _ in found]
    return {
        "contact/facets": way.numbered(np.concatenate([rows for rows, _, _ in found])),
        "contact/facet_patch": np.repeat([patch for _, patch, _ in found], counts),
        "contact/facet_side": np.repeat([side for _, _, side in found], counts),
        "contact/pressures": _pressures(way, interface),
    }


def _facets(way: Gathering, local: Indices) -> Indices:
    """Nodes of facets in VTK's order, on rank 0, by their numbers in the space."""
    topology = way.solid.tagged.mesh.topology
    topology.create_connectivity(topology.dim, topology.dim - 1)
    of_cells = topology.connectivity(topology.dim, topology.dim - 1)
    around = of_cells.array.reshape(of_cells.num_nodes, -1)[: len(way.cells)]
    cell, place = np.nonzero(np.isin(around, local))
    nodes = reference_cell(way.cell_type).facets[place]
    rows = way.cells[cell[:, None], nodes]
    whole, owner = (_gathered(way.comm, part) for part in (rows, way.input_cell[cell]))
    return np.asarray(whole[np.argsort(owner, kind="stable")])


def _pressures(way: Gathering, interface: ContactInterface) -> Array:
    """Node, contact point and pressure in Pa under a unit force there: three rows, on rank 0."""
    mesh, space = way.solid.tagged.mesh, way.solid.space
    entries = interface.pressures.tocoo()
    blocks = at_vertices(mesh, space.dofmap.list)[entries.row].astype(np.int32)
    own = (space.dofmap.index_map.local_to_global(blocks), entries.col, entries.data)
    node, point, value = (_gathered(way.comm, part) for part in own)
    node = way.numbered(node)
    order = np.lexsort((point, node))
    return np.array([node[order], point[order], value[order]], dtype=float)


def _gathered(comm: MPI.Comm, own: Any) -> Any:
    """Parts of all ranks one after the other on rank 0; nothing elsewhere."""
    pieces = comm.gather(own, root=0)
    return np.concatenate(pieces) if pieces is not None else own[:0]
