"""Vertices of tagged facets, gathered on all ranks: places, normals and tributary areas."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from dolfinx.fem.petsc import assemble_vector
from petsc4py import PETSc

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.compat import cell_nodes
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.vertices import at_vertices


@dataclass(frozen=True, slots=True)
class PatchVertices:
    """Vertices of some facets, the same on all ranks, in the order of the input mesh's nodes.

    Attributes:
        numbers: Node numbers of the input mesh, shape (n,).
        local: Local vertex number on the rank that owns it, -1 on others.
        blocks: Global block index in the displacement space.
        points: Coordinates in m, shape (n, dim).
        normals: Outward normals times area, shape (n, dim).
        areas: Tributary areas in m^2, shape (n,).
        held: Whether the displacement is held along each axis, shape (n, dim).
    """

    numbers: Indices
    local: Indices
    blocks: Indices
    points: Array
    normals: Array
    areas: Array
    held: Mask

    @classmethod
    def of(cls, solid: Solid, facets: Indices, key: str, what: str) -> PatchVertices:
        """Gather the vertices of local facets.

        Args:
            solid: Assembled body.
            facets: Local facets.
            key: The study's key of the facets, for messages.
            what: Names of the facets, for messages.

        Raises:
            MeshError: if there are no facets, or some lie inside the body.
        """
        comm = solid.tagged.mesh.comm
        _check_surface(solid, facets, key, what)
        found = _owned_vertices(solid, facets)
        owner = np.concatenate(comm.allgather(np.full(len(found["numbers"]), comm.rank)))
        whole = {name: np.concatenate(comm.allgather(part)) for name, part in sorted(found.items())}
        if not len(owner):
            raise MeshError(f"{key} = {what}: has no facets on the surface")
        whole["local"][owner != comm.rank] = -1
        order = np.argsort(whole["numbers"])
        return cls(**{name: part[order] for name, part in whole.items()})

    def chosen(self, places: Indices) -> PatchVertices:
        """Some of the vertices."""
        parts = {name: getattr(self, name)[places] for name in self.__dataclass_fields__}
        return PatchVertices(**parts)


def _check_surface(solid: Solid, facets: Indices, key: str, what: str) -> None:
    topology = solid.tagged.mesh.topology
    owned = facets[facets < topology.index_map(topology.dim - 1).size_local]
    inside = np.setdiff1d(owned, dmesh.exterior_facet_indices(topology))
    count = solid.tagged.mesh.comm.allreduce(len(inside))
    if count:
        raise MeshError(
            f"{key} = {what}: {count} facets lie inside the body: must be on its surface"
        )


def _owned_vertices(solid: Solid, facets: Indices) -> dict[str, Array | Indices | Mask]:
    """Attributes of `PatchVertices` for the vertices that this rank owns."""
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    normals, areas = _normals_and_areas(solid, facets)
    owned = np.arange(mesh.topology.index_map(0).size_local, dtype=np.int32)
    scalar = at_vertices(mesh, areas.function_space.dofmap.list)[owned]
    touched = areas.x.array[scalar] > 0
    vertices, scalar = owned[touched], scalar[touched]
    nodes = at_vertices(mesh, cell_nodes(mesh))[vertices]
    blocks = at_vertices(mesh, solid.space.dofmap.list)[vertices]
    to_global = solid.space.dofmap.index_map.local_to_global
    return {
        "numbers": np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)[nodes],
        "local": vertices.astype(np.int64),
        "blocks": to_global(blocks.astype(np.int32)).astype(np.int64),
        "points": mesh.geometry.x[nodes][:, :dim].copy(),
        "normals": normals.x.array.reshape(-1, dim)[scalar].copy(),
        "areas": areas.x.array[scalar].copy(),
        "held": np.isin(blocks[:, None] * dim + np.arange(dim), solid.clamped),
    }


def _normals_and_areas(solid: Solid, facets: Indices) -> tuple[fem.Function, fem.Function]:
    """Integrals of hat functions times the outward normal, and of hat functions, over facets."""
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    tags = dmesh.meshtags(mesh, dim - 1, np.sort(facets), np.ones(len(facets), dtype=np.int32))
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)(1)
    scalar = fem.functionspace(mesh, ("Lagrange", 1))
    vector = fem.functionspace(mesh, ("Lagrange", 1, (dim,)))
    extent = fem.Constant(mesh, float(solid.body.extent))
    normal = ufl.inner(ufl.FacetNormal(mesh), ufl.TestFunction(vector)) * ds
    area = extent * ufl.TestFunction(scalar) * ds
    return _assembled(normal, vector), _assembled(area, scalar)


def _assembled(form: ufl.Form, space: fem.FunctionSpace) -> fem.Function:
    vector = assemble_vector(fem.form(form))
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    vector.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
    function = fem.Function(space)
    with vector.localForm() as values:
        function.x.array[:] = values.array
    vector.destroy()
    return function
