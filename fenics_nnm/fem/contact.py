"""Contact points: vertices of tagged facets, their directions, gaps and tributary areas."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from dolfinx.fem.petsc import assemble_vector
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError, ModelError
from fenics_nnm.fem.solid import Solid


@dataclass(frozen=True, slots=True)
class Direction:
    """Where the obstacle lies as seen from a contact point.

    Attributes:
        kind: "normal" (outward normal of the body), "radial" (away from an axis) or "vector".
        vector: Direction of the axis, or the direction itself; empty for "normal", and for an
            axis normal to the plane of a 2-D body.
        origin: A point on the axis in m.
    """

    kind: str
    vector: tuple[float, ...] = ()
    origin: tuple[float, ...] = ()

    def at(self, points: Array, normals: Array) -> Array:
        """Unit vectors at points of shape (n, dim) with outward normals of the same shape.

        Raises:
            ModelError: if a direction has no length there.
        """
        if self.kind == "normal":
            found = normals
        elif self.kind == "radial":
            found = points - np.asarray(self.origin)
            if self.vector:
                axis = np.asarray(self.vector) / np.linalg.norm(self.vector)
                found = found - np.outer(found @ axis, axis)
        else:
            found = np.broadcast_to(np.asarray(self.vector), points.shape)
        length = np.linalg.norm(found, axis=1)
        if len(length) and length.min() <= 1e-12 * max(1.0, float(length.max())):
            where = points[int(np.argmin(length))]
            place = ", ".join(f"{x:.6g}" for x in where)
            raise ModelError(
                f'contact.direction = "{self.kind}": is not defined at ({place}) m: must not '
                "meet the axis"
            )
        return np.asarray(found / length[:, None])


@dataclass(frozen=True, slots=True)
class ContactInterface:
    """Contact points, the same on all ranks, in the order of the input mesh's nodes.

    Attributes:
        points: Coordinates in m, shape (n_c, dim).
        directions: Unit vectors towards the obstacle, shape (n_c, dim).
        areas: Tributary areas in m^2, shape (n_c,).
        gap: Initial gaps in m, shape (n_c,).
        blocks: Local block index of each point on the rank that owns it, -1 elsewhere.
        patch: All contact vertices that this rank owns, by local number, and the contact point
            that stands for each: two rows.
        facets: Local contact facets, ghosts included.
        comm: Communicator.
    """

    points: Array
    directions: Array
    areas: Array
    gap: Array
    blocks: Indices
    patch: Indices
    facets: Indices
    comm: MPI.Comm

    @property
    def count(self) -> int:
        """Number of contact points n_c."""
        return len(self.gap)

    def displacement(self, local: Array) -> Array:
        """B u: displacements in the contact directions.

        Args:
            local: Columns of owned degrees of freedom, shape (n_owned, k).

        Returns:
            Shape (n_c, k), the same on all ranks.
        """
        dim = self.points.shape[1]
        found = np.zeros((self.count, local.shape[1]))
        mine = np.flatnonzero(self.blocks >= 0)
        rows = self.blocks[mine, None] * dim + np.arange(dim)
        found[mine] = np.einsum("cd,cdk->ck", self.directions[mine], local[rows])
        return np.asarray(self.comm.allreduce(found))

    def unit_forces(self, owned: int) -> Array:
        """B^T: a unit force in the contact direction at each point, shape (n_owned, n_c)."""
        return self._forces(owned, self.directions[:, :, None])

    def unit_forces_all_directions(self, owned: int) -> Array:
        """A unit force along each axis at each point, shape (n_owned, n_c dim)."""
        dim = self.points.shape[1]
        return self._forces(owned, np.broadcast_to(np.eye(dim), (self.count, dim, dim)))

    def _forces(self, owned: int, vectors: Array) -> Array:
        """Columns of forces at the points: vectors of shape (n_c, dim, columns a point)."""
        dim, width = vectors.shape[1:]
        forces = np.zeros((owned, self.count * width))
        for point in np.flatnonzero(self.blocks >= 0):
            start = self.blocks[point] * dim
            forces[start : start + dim, point * width : (point + 1) * width] = vectors[point]
        return forces


@dataclass(frozen=True, slots=True)
class _Vertices:
    """Owned contact vertices of this rank, or those of all ranks together.

    Attributes:
        local: Local vertex number, -1 on other ranks.
        numbers: Node numbers of the input mesh.
        blocks: Local block index in the displacement space, -1 on other ranks.
        points: Coordinates in m.
        normals: Outward normals times area.
        areas: Tributary areas in m^2.
    """

    local: Indices
    numbers: Indices
    blocks: Indices
    points: Array
    normals: Array
    areas: Array


def contact_interface(
    solid: Solid,
    facets: Indices,
    direction: Direction,
    *,
    gap: float,
    count: int | None,
    what: str,
) -> ContactInterface:
    """Make contact points of the vertices of local facets.

    Args:
        solid: Assembled body.
        facets: Local contact facets.
        direction: Direction of the obstacle.
        gap: Initial gap in m at every point.
        count: Number of points to spread evenly over the vertices, or None for all vertices.
        what: Name of the facets, for messages.

    Raises:
        MeshError: if the facets are empty, inside the body or touch the clamp, or have fewer
            vertices than `count`.
    """
    comm = solid.tagged.mesh.comm
    _check_surface(solid, facets, what)
    local = _owned_vertices(solid, facets)
    owner = np.concatenate(comm.allgather(np.full(len(local.numbers), comm.rank)))
    everywhere = [comm.allgather(part) for part in (local.numbers, local.points, local.normals)]
    numbers, points, normals = (np.concatenate(parts) for parts in everywhere)
    areas = np.concatenate(comm.allgather(local.areas))
    blocks, mine = np.full(len(owner), -1), np.full(len(owner), -1)
    blocks[owner == comm.rank] = local.blocks
    mine[owner == comm.rank] = local.local
    parts = (mine, numbers, blocks, points, normals, areas)
    vertices = _Vertices(*(part[np.argsort(numbers)] for part in parts))
    _check_vertices(solid, vertices, count, what, comm)
    chosen = np.arange(len(numbers)) if count is None else spread(vertices.points, count)
    nearest = _nearest(vertices.points, vertices.points[chosen])
    owned = vertices.local >= 0
    return ContactInterface(
        points=vertices.points[chosen],
        directions=direction.at(vertices.points[chosen], vertices.normals[chosen]),
        areas=np.bincount(nearest, weights=vertices.areas, minlength=len(chosen)).astype(float),
        gap=np.full(len(chosen), gap),
        blocks=vertices.blocks[chosen],
        patch=np.array([vertices.local[owned], nearest[owned]]),
        facets=facets,
        comm=comm,
    )


def spread(points: Array, count: int) -> Indices:
    """Indices of `count` points that lie far from each other, ascending.

    Starts with the point farthest from the centre and adds the one farthest from all chosen.
    """
    centre = points.mean(axis=0)
    chosen = [int(np.argmax(np.linalg.norm(points - centre, axis=1)))]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.sort(np.array(chosen, dtype=np.int64))


def _nearest(points: Array, centres: Array) -> Indices:
    distances = np.linalg.norm(points[:, None, :] - centres[None, :, :], axis=2)
    return np.argmin(distances, axis=1)


def _check_surface(solid: Solid, facets: Indices, what: str) -> None:
    topology = solid.tagged.mesh.topology
    owned = facets[facets < topology.index_map(topology.dim - 1).size_local]
    inside = np.setdiff1d(owned, dmesh.exterior_facet_indices(topology))
    count = solid.tagged.mesh.comm.allreduce(len(inside))
    if count:
        raise MeshError(
            f"contact.facets = {what}: {count} facets lie inside the body: must be on its surface"
        )


def _check_vertices(
    solid: Solid, vertices: _Vertices, count: int | None, what: str, comm: MPI.Comm
) -> None:
    found = len(vertices.numbers)
    if not found:
        raise MeshError(f"contact.facets = {what}: has no facets on the surface")
    if count is not None and count > found:
        raise MeshError(f"contact.points = {count}: {what} has only {found} vertices")
    dim = solid.tagged.dim
    clamped = np.isin(vertices.blocks * dim, solid.clamped) & (vertices.blocks >= 0)
    clamped = comm.allreduce(clamped.astype(np.int64)) > 0
    if clamped.any():
        place = ", ".join(f"{x:.6g}" for x in vertices.points[np.argmax(clamped)])
        raise MeshError(
            f"contact.facets = {what}: {int(clamped.sum())} vertices are clamped too, "
            f"one at ({place}) m: contact facets must not touch the clamp"
        )


def _owned_vertices(solid: Solid, facets: Indices) -> _Vertices:
    """Contact vertices owned by this rank, with averaged normals and tributary areas."""
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    normals, areas = _normals_and_areas(solid, facets)
    owned = np.arange(mesh.topology.index_map(0).size_local, dtype=np.int32)
    scalar = at_vertices(mesh, areas.function_space.dofmap.list)[owned]
    touched = areas.x.array[scalar] > 0
    vertices, scalar = owned[touched], scalar[touched]
    nodes = at_vertices(mesh, mesh.geometry.dofmap)[vertices]
    return _Vertices(
        local=vertices.astype(np.int64),
        numbers=np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)[nodes],
        blocks=at_vertices(mesh, solid.space.dofmap.list)[vertices],
        points=mesh.geometry.x[nodes][:, :dim].copy(),
        normals=normals.x.array.reshape(-1, dim)[scalar].copy(),
        areas=areas.x.array[scalar].copy(),
    )


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
