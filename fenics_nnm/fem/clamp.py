"""Degrees of freedom that a clamp holds: of facets or nodes, in all directions or some."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from dolfinx import fem

from fenics_nnm.arrays import Indices, Mask
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.compat import cell_nodes, coordinate_element
from fenics_nnm.fem.constraints import LinearConstraints
from fenics_nnm.fem.mesh import TaggedMesh


@dataclass(frozen=True, slots=True)
class Clamp:
    """Facets and nodes whose displacement is zero along some axes.

    Attributes:
        key: The study's section, for messages.
        facets: Names of groups of facets.
        nodes: Names of sets of nodes.
        axes: Axes along which they do not move, ascending.
        turns: Whether points of sets that have rotations may turn about these axes.
    """

    key: str
    facets: tuple[str, ...]
    nodes: tuple[str, ...]
    axes: tuple[int, ...]
    turns: bool = True


def held_blocks(space: fem.FunctionSpace, tagged: TaggedMesh, clamp: Clamp) -> Indices:
    """Local displacement blocks of the facets and nodes of a clamp, ghosts included.

    Raises:
        MeshError: if a group is unknown or empty, or a direction is not one of the mesh.
    """
    beyond = [axis for axis in clamp.axes if axis >= tagged.dim]
    if beyond:
        raise MeshError(
            f'{clamp.key}.directions: "{"xyz"[beyond[0]]}" is no direction of a mesh of dimension '
            f"{tagged.dim}"
        )
    found: list[Indices] = [np.empty(0, dtype=np.int32)]
    if clamp.facets:
        facets = tagged.facets_of(clamp.facets, f"{clamp.key}.facets")
        found.append(fem.locate_dofs_topological(space, tagged.dim - 1, facets))
    if clamp.nodes:
        found.append(blocks_of_nodes(space, tagged, _nodes(tagged, clamp)))
    return np.unique(np.concatenate(found)).astype(np.int32)


def held_points(tagged: TaggedMesh, clamps: Sequence[Clamp]) -> LinearConstraints:
    """Constraints of a mesh, with the points that clamps of sets of nodes hold."""
    found = tagged.constraints
    for clamp in clamps:
        turned = () if clamp.turns else (3, 4, 5)
        found = found.holding(clamp.nodes, (*clamp.axes, *turned))
    return found


def _nodes(tagged: TaggedMesh, clamp: Clamp) -> Mask:
    """Which local nodes of the geometry are in the named sets."""
    chosen = np.zeros(len(tagged.mesh.geometry.x), dtype=bool)
    for name in clamp.nodes:
        points = {known for each in tagged.constraints.references for known in each.names}
        known = ", ".join(f'"{known}"' for known in sorted({*tagged.nodes, *points})) or "none"
        if name not in {*tagged.nodes, *points}:
            raise MeshError(
                f'{clamp.key}.nodes = "{name}": the mesh has no such set of nodes; it has {known}'
            )
        own = tagged.nodes.get(name, np.empty(0, dtype=np.int64))
        if name not in points and not tagged.mesh.comm.allreduce(len(own)):
            raise MeshError(f'{clamp.key}.nodes = "{name}": no element has a node of the set')
        chosen[own] = True
    return chosen


def blocks_of_nodes(space: fem.FunctionSpace, tagged: TaggedMesh, chosen: Mask) -> Indices:
    """Blocks at chosen nodes, and at the middles of edges, faces and cells of chosen nodes alone.

    Where the geometry has a middle node on an edge, it must be chosen for the block there.
    """
    layout, own = coordinate_element(tagged.mesh).create_dof_layout(), space.dofmap.dof_layout
    inside = chosen[cell_nodes(tagged.mesh)]
    blocks = space.dofmap.list
    found = [np.empty(0, dtype=np.int32)]
    for dim in range(tagged.dim + 1):
        for entity in range(_entities(tagged.mesh.topology.cell_name(), dim)):
            dofs = own.entity_dofs(dim, entity)
            middle = layout.entity_dofs(dim, entity)
            around = layout.entity_closure_dofs(dim, entity)
            wanted = middle if dim <= 1 and len(middle) else np.setdiff1d(around, middle)
            if len(dofs):
                found.append(blocks[inside[:, wanted].all(axis=1)][:, dofs].ravel())
    return np.concatenate(found)


def _entities(cell: str, of: int) -> int:
    """Number of vertices, edges, faces or cells of a cell."""
    counts = {
        "interval": (2, 1),
        "triangle": (3, 3, 1),
        "quadrilateral": (4, 4, 1),
        "tetrahedron": (4, 6, 4, 1),
        "hexahedron": (8, 12, 6, 1),
    }
    return counts[cell][of]
