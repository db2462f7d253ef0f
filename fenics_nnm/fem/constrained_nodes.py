"""Places and numbers of the displacements of constrained nodes, the same on all ranks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from dolfinx import fem

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.clamp import blocks_of_nodes
from fenics_nnm.fem.compat import cell_nodes
from fenics_nnm.fem.constraints import Coupling
from fenics_nnm.fem.mesh import TaggedMesh

#: Places are rounded to this part of the body where they only serve to put blocks in order.
_SAME_PLACE = 1e-9


@dataclass(frozen=True, slots=True)
class NodeBlocks:
    """Displacement blocks of nodes, the same on all ranks.

    Attributes:
        blocks: Global block of each.
        points: Coordinates in m, shape (n, 3).
    """

    blocks: Indices
    points: Array


def blocks_of_coupling(
    space: fem.FunctionSpace, tagged: TaggedMesh, coupling: Coupling
) -> NodeBlocks:
    """Blocks of all nodes of a rigid coupling, in the order of their places; all ranks call this.

    Blocks at the middles of edges and faces whose nodes all belong to it are in it, too.

    Raises:
        MeshError: if a group of facets is unknown or empty.
    """
    numbers = np.asarray(tagged.mesh.geometry.input_global_indices, dtype=np.int64)
    chosen = np.isin(numbers, coupling.nodes)
    found = [blocks_of_nodes(space, tagged, chosen)]
    if coupling.facets:
        facets = tagged.facets_of(coupling.facets, f"{coupling.key}.facets")
        found.append(fem.locate_dofs_topological(space, tagged.dim - 1, facets))
    local = np.unique(np.concatenate(found))
    blocks = space.dofmap.index_map.local_to_global(local.astype(np.int32))
    points = space.tabulate_dof_coordinates()[local]
    blocks, points = (np.concatenate(tagged.mesh.comm.allgather(x)) for x in (blocks, points))
    blocks, first = np.unique(blocks, return_index=True)
    points = points[first]
    size = float(np.ptp(points, axis=0).max()) if len(points) else 1.0
    order = np.lexsort(np.round(points / (_SAME_PLACE * size or 1.0)).T)
    return NodeBlocks(blocks[order], points[order])


def assert_no_others(
    space: fem.FunctionSpace, tagged: TaggedMesh, numbers: Indices, known: Indices, key: str
) -> None:
    """Refuse equations on whole edges or faces that have values besides those at their nodes.

    Args:
        space: Displacement space.
        tagged: Mesh.
        numbers: Numbers of the nodes in equations.
        known: Their global blocks.
        key: The first equation, for messages.

    Raises:
        MeshError: if there are such values; all ranks call this.
    """
    chosen = np.isin(np.asarray(tagged.mesh.geometry.input_global_indices), numbers)
    local = blocks_of_nodes(space, tagged, chosen)
    found = space.dofmap.index_map.local_to_global(np.unique(local).astype(np.int32))
    others = len(np.setdiff1d(found, known))
    if tagged.mesh.comm.allreduce(others):
        raise MeshError(
            f"{key} cannot be followed: equations join whole edges or faces, which have values "
            "between the nodes of the file: must be elements of order 1 with degree = 1, or "
            "tetrahedra of order 2 with degree = 2",
            code=Code.DEGREE,
        )


def blocks_at_nodes(space: fem.FunctionSpace, tagged: TaggedMesh, numbers: Indices) -> NodeBlocks:
    """Block of each of some nodes, by their numbers in the input; all ranks call this.

    Raises:
        MeshError: if the displacement has no values at one of them.
    """
    mesh = tagged.mesh
    nodes, blocks = cell_nodes(mesh), space.dofmap.list
    width = nodes.shape[1]
    if width != blocks.shape[1]:
        mesh.topology.create_connectivity(tagged.dim, 0)
        width = len(mesh.topology.connectivity(tagged.dim, 0).links(0)) if len(nodes) else 0
    local, place = np.unique(nodes[:, :width].ravel(), return_index=True)
    known = np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)[local]
    wanted = np.isin(known, numbers)
    own = blocks[:, :width].ravel()[place[wanted]]
    parts = (
        known[wanted],
        space.dofmap.index_map.local_to_global(own.astype(np.int32)),
        mesh.geometry.x[local[wanted]],
    )
    number, block, points = (np.concatenate(mesh.comm.allgather(part)) for part in parts)
    number, first = np.unique(number, return_index=True)
    row = np.minimum(np.searchsorted(number, numbers), max(len(number) - 1, 0))
    if not len(number) or (number[row] != numbers).any():
        raise MeshError(
            "constraints act on middle nodes of elements, where the displacement has no values: "
            "must have degree = 2",
            code=Code.DEGREE,
        )
    return NodeBlocks(block[first][row], points[first][row])
