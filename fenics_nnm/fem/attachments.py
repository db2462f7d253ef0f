"""Masses and springs attached to a body: at a vertex, or spread over facets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.compat import cell_nodes
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.stress import Expr
from fenics_nnm.fem.vertices import at_vertices


@dataclass(frozen=True, slots=True)
class Vertex:
    """A vertex of the mesh that something is attached to.

    Attributes:
        point: Coordinates in m, the same on all ranks, shape (dim,).
        block: Local block index in the displacement space on the rank that owns it, else -1.
    """

    point: Array
    block: int


def spread_form(
    space: fem.FunctionSpace,
    tagged: TaggedMesh,
    attachment: Attachment,
    clamped: Indices,
    extent: float,
) -> Expr:
    """Bilinear form of what is spread over facets.

    Args:
        space: Displacement space.
        tagged: Mesh.
        attachment: What is spread.
        clamped: Local indices of clamped degrees of freedom, unrolled.
        extent: Thickness of a plane body in m, cross-section of a rod in m^2, else 1.

    Raises:
        MeshError: if a group is unknown, has no facets, has some inside the body or is clamped.
    """
    mesh, what = tagged.mesh, f"{attachment.key}.facets"
    facets = tagged.facets_of(attachment.facets, what)
    tags = dmesh.meshtags(mesh, tagged.dim - 1, facets, np.ones(len(facets), dtype=np.int32))
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)(1)
    _assert_on_surface(tagged, facets, what)
    blocks = fem.locate_dofs_topological(space, tagged.dim - 1, facets)
    if not mesh.comm.allreduce(len(np.setdiff1d(blocks * tagged.dim, clamped))):
        raise MeshError(f"{what}: all are clamped: a {attachment.kind} there has no effect")
    size = mesh.comm.allreduce(fem.assemble_scalar(fem.form(fem.Constant(mesh, 1.0) * ds)))
    factor = extent if attachment.per_area else 1 / size
    values = fem.Constant(mesh, np.array(attachment.values) * factor)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    return sum(values[i] * u[i] * v[i] for i in range(tagged.dim)) * ds


def nearest_vertex(
    space: fem.FunctionSpace, tagged: TaggedMesh, attachment: Attachment, clamped: Indices
) -> Vertex:
    """The vertex nearest to the point of an attachment.

    Args:
        space: Displacement space.
        tagged: Mesh.
        attachment: What is attached at a point.
        clamped: Local indices of clamped degrees of freedom, unrolled.

    Raises:
        MeshError: if it is farther away than an element is large, or is clamped.
    """
    mesh, comm, where = tagged.mesh, tagged.mesh.comm, f"{attachment.key}.at"
    owned = np.arange(mesh.topology.index_map(0).size_local, dtype=np.int32)
    nodes = at_vertices(mesh, cell_nodes(mesh))[owned]
    points = mesh.geometry.x[nodes][:, : tagged.dim]
    distances = np.linalg.norm(points - np.array(attachment.point), axis=1)
    best = (np.inf, np.iinfo(np.int64).max, comm.rank)
    if len(owned):
        numbers = np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)[nodes]
        first = int(np.lexsort((numbers, distances))[0])
        best = (float(distances[first]), int(numbers[first]), comm.rank)
    distance, _, rank = min(comm.allgather(best))
    found = None
    if rank == comm.rank:
        block = int(at_vertices(mesh, space.dofmap.list)[owned[first]])
        held = bool(np.isin(block * tagged.dim + np.arange(tagged.dim), clamped).all())
        found = points[first], _size_around(mesh, int(owned[first])), held
    point, size, held = comm.bcast(found, root=rank)
    if distance > size:
        raise MeshError(
            f"{where} = {list(attachment.point)}: the nearest vertex, {_place(point)}, is "
            f"{distance:.4g} m away, and elements there are {size:.4g} m large: must be on the body"
        )
    if held:
        raise MeshError(
            f"{where} = {list(attachment.point)}: the nearest vertex, {_place(point)}, is "
            f"clamped: a {attachment.kind} there has no effect"
        )
    return Vertex(np.asarray(point), block if rank == comm.rank else -1)


def add_at_vertex(
    matrix: PETSc.Mat,
    space: fem.FunctionSpace,
    vertex: Vertex,
    values: tuple[float, ...],
    clamped: Indices,
) -> None:
    """Add values along the free axes to the diagonal of an assembled matrix; all ranks call this.

    Args:
        matrix: K or M.
        space: Displacement space.
        vertex: Vertex.
        values: Value along each axis.
        clamped: Local indices of clamped degrees of freedom, unrolled.
    """
    if vertex.block >= 0:
        size = space.dofmap.index_map_bs
        first = (space.dofmap.index_map.local_range[0] + vertex.block) * size
        held = np.isin(vertex.block * size + np.arange(size), clamped)
        for axis, value in enumerate(values):
            if held[axis]:
                continue
            matrix.setValue(first + axis, first + axis, value, PETSc.InsertMode.ADD_VALUES)
    matrix.assemble()


def add_spread_mass(matrix: PETSc.Mat, spread: PETSc.Mat) -> None:
    """Add mass that is spread over facets, and not assembled yet, to M; all ranks call this.

    Its pattern has entries between axes, which M has not by itself.
    """
    spread.assemble()
    matrix.axpy(1.0, spread, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    spread.destroy()


def _size_around(mesh: dmesh.Mesh, vertex: int) -> float:
    """Largest diameter of the cells at a local vertex in m."""
    dim = mesh.topology.dim
    mesh.topology.create_connectivity(0, dim)
    return float(mesh.h(dim, mesh.topology.connectivity(0, dim).links(vertex)).max())


def _assert_on_surface(tagged: TaggedMesh, facets: Indices, what: str) -> None:
    topology = tagged.mesh.topology
    owned = facets[facets < topology.index_map(tagged.dim - 1).size_local]
    inside = len(np.setdiff1d(owned, dmesh.exterior_facet_indices(topology)))
    found, inside = (tagged.mesh.comm.allreduce(n, op=MPI.SUM) for n in (len(owned), inside))
    if inside or not found:
        problem = f"{inside} facets lie inside the body" if inside else "there are no facets"
        raise MeshError(f"{what}: {problem}: must be on its surface")


def _place(point: Array) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ") m"
