"""The surface of a mesh and its named groups, gathered on one rank to be shown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from dolfinx import mesh as dmesh
from dolfinx.cpp.mesh import cell_entity_type, cell_num_vertices

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.compat import cell_nodes
from fenics_nnm.fem.mesh import TaggedMesh

#: Corners of a quadrangle around it, in dolfinx's numbering.
_AROUND = [0, 1, 3, 2]


@dataclass(frozen=True, slots=True)
class MeshGroups:
    """A mesh as it is seen from outside.

    Attributes:
        dim: Dimension of the body.
        nodes: Places of all nodes in m, shape (n, 3).
        faces: Corners of the outer facets of a solid, outwards by the right-hand rule, or of the
            cells of a plane body or a rod, shape (f, 2 to 4).
        facets: Corners of the facets of each named group, shape (number, 1 to 4).
        cells: The rows of `faces` that belong to the cells of each named group.
    """

    dim: int
    nodes: Array
    faces: Indices
    facets: dict[str, Indices]
    cells: dict[str, Indices]


def gathered_groups(tagged: TaggedMesh) -> MeshGroups | None:
    """Surface and groups of a whole mesh on rank 0, None on the others; to be called on all."""
    mesh, dim = tagged.mesh, tagged.dim
    seen = _seen(mesh)
    groups = {name: _owned(mesh, dim - 1, facets) for name, facets in tagged.facets.items()}
    parts = {
        "faces": _outwards(mesh, _corners(mesh, min(dim, 2), seen), seen),
        **{f"facets {name}": _corners(mesh, dim - 1, facets) for name, facets in groups.items()},
        **{
            f"cells {name}": np.isin(_cells_of(mesh, seen), cells)
            for name, cells in tagged.cells.items()
        },
        "nodes": mesh.geometry.x[: mesh.geometry.index_map().size_local],
    }
    whole = {}
    for name, part in parts.items():
        everywhere = mesh.comm.gather(part, root=0)
        if mesh.comm.rank == 0:
            whole[name] = np.concatenate(everywhere)
    if mesh.comm.rank > 0:
        return None
    return MeshGroups(
        dim=dim,
        nodes=whole["nodes"],
        faces=whole["faces"],
        facets={name: whole[f"facets {name}"] for name in tagged.facets},
        cells={name: np.flatnonzero(whole[f"cells {name}"]) for name in tagged.cells},
    )


def _seen(mesh: dmesh.Mesh) -> Indices:
    """Outer facets of a solid, or cells of another body, that this rank owns."""
    topology = mesh.topology
    if topology.dim == 3:
        return _owned(mesh, 2, dmesh.exterior_facet_indices(topology))
    return np.arange(topology.index_map(topology.dim).size_local, dtype=np.int32)


def _cells_of(mesh: dmesh.Mesh, seen: Indices) -> Indices:
    """The cell that each seen facet, or cell, belongs to."""
    if mesh.topology.dim < 3:
        return seen
    cells = mesh.topology.connectivity(2, 3)
    return np.array([cells.links(facet)[0] for facet in seen], dtype=np.int32)


def _outwards(mesh: dmesh.Mesh, corners: Indices, seen: Indices) -> Indices:
    """Corners of outer facets turned so that their normals point away from their cells."""
    if mesh.topology.dim < 3:
        return corners
    nodes = mesh.geometry.x
    cells = nodes[cell_nodes(mesh)[_cells_of(mesh, seen)]].mean(axis=1)
    places = nodes[_local(mesh, 2, seen)]
    normals = np.cross(places[:, 1] - places[:, 0], places[:, -1] - places[:, 0])
    inwards = np.sum(normals * (places.mean(axis=1) - cells), axis=1) < 0
    return np.where(inwards[:, None], corners[:, ::-1], corners)


def _owned(mesh: dmesh.Mesh, dim: int, entities: Indices) -> Indices:
    return entities[entities < mesh.topology.index_map(dim).size_local].astype(np.int32)


def _corners(mesh: dmesh.Mesh, dim: int, entities: Indices) -> Indices:
    """Global nodes at the corners of local entities, in order around each."""
    local = _local(mesh, dim, entities)
    numbers = mesh.geometry.index_map().local_to_global(local.ravel().astype(np.int32))
    return np.asarray(numbers.reshape(local.shape))


def _local(mesh: dmesh.Mesh, dim: int, entities: Indices) -> Indices:
    """Local nodes at the corners of local entities, in order around each."""
    topology = mesh.topology
    for other in (dim, topology.dim):
        topology.create_connectivity(dim, other)
        topology.create_connectivity(other, dim)
    corners = cell_num_vertices(cell_entity_type(topology.cell_type, dim, 0))
    if not len(entities):  # dolfinx divides by their number
        return np.empty((0, corners), dtype=np.int32)
    local = dmesh.entities_to_geometry(mesh, dim, entities)[:, :corners]  # then middle nodes
    return np.asarray(local[:, _AROUND] if corners == 4 else local)
