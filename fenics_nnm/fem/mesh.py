"""A distributed mesh with named facets and cells, from a file or a built-in geometry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from dolfinx import mesh as dmesh
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.built_in import built_in
from fenics_nnm.fem.cached_mesh import kept_or_made
from fenics_nnm.fem.constraints import NO_CONSTRAINTS, LinearConstraints
from fenics_nnm.fem.kept_mesh import MeshAsRead, StoredMesh
from fenics_nnm.fem.mesh_file import ReadMesh, assert_file, seconds_to_read
from fenics_nnm.fem.native import Limits, in_own_process
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.fem.spreading import distributed
from fenics_nnm.geometry import Geometry
from fenics_nnm.geometry.lengths import METRES


@dataclass(frozen=True, slots=True)
class TaggedMesh:
    """A distributed mesh in metres, and its named facets and cells.

    Attributes:
        mesh: Mesh of one cell type, whose geometric and topological dimensions agree.
        facets: Local facet indices of each named group; the names are alike on all ranks.
        cells: Local cell indices, ghosts included, of each named group; names as above.
        nodes: Local nodes of the geometry, ghosts included, of each named set of nodes.
        attached: Masses and springs that the file has.
        constraints: Constraints that the file has; nodes by their numbers in the input mesh.
        notes: What was left out or changed on reading the file, a line each.
        as_read: The mesh before it was spread over the ranks, to be kept.
    """

    mesh: dmesh.Mesh
    facets: dict[str, Indices]
    cells: dict[str, Indices]
    nodes: dict[str, Indices] = field(default_factory=dict)
    attached: tuple[Attachment, ...] = ()
    constraints: LinearConstraints = NO_CONSTRAINTS
    notes: tuple[str, ...] = ()
    as_read: MeshAsRead = field(default_factory=MeshAsRead)

    @property
    def dim(self) -> int:
        """Dimension of the body: 1, 2 or 3."""
        return int(self.mesh.topology.dim)

    def bounds(self) -> Array:
        """Smallest and largest coordinates in m, shape (2, dim); all ranks call this."""
        x, comm = self.mesh.geometry.x[:, : self.dim], self.mesh.comm
        low = np.min(comm.allgather(x.min(axis=0, initial=np.inf)), axis=0)
        high = np.max(comm.allgather(x.max(axis=0, initial=-np.inf)), axis=0)
        return np.stack([low, high])

    def _box(self) -> str:
        """Ranges of the coordinates in m; all ranks call this."""
        return " x ".join(f"[{a:.5g}, {b:.5g}]" for a, b in self.bounds().T)

    def facets_of(self, names: tuple[str, ...], what: str) -> Indices:
        """Local facets of all the named groups together.

        Args:
            names: Names of groups.
            what: The study's key, for the message.

        Raises:
            MeshError: if a name is not in the mesh, or has no facets.
        """
        for name in names:
            if name not in self.facets:
                known = ", ".join(f'"{known}"' for known in sorted(self.facets)) or "none"
                raise MeshError(
                    f'{what} = "{name}": the mesh has no such group; it has {known}; groups can be '
                    f"picked by place in [groups.{name}]: the mesh lies in {self._box()} m"
                )
            if not self.mesh.comm.allreduce(len(self.facets[name])):
                raise MeshError(
                    f'{what} = "{name}": the group has no facets: a set of nodes has those whose '
                    "nodes all belong to it"
                )
        return np.unique(np.concatenate([self.facets[name] for name in names]))


def read_mesh(
    path: Path, length_unit: str, comm: MPI.Comm, limits: Limits | None = None
) -> TaggedMesh:
    """Read a mesh of gmsh or of another program with its named groups.

    Args:
        path: File with a mesh.
        length_unit: Unit of its coordinates, a key of `METRES`.
        comm: Communicator of the mesh.
        limits: What the reader may take.

    Raises:
        MeshError: if the file cannot be used; the message says why.
    """

    def read() -> RawMesh:
        assert_file(path)
        given = limits or Limits()
        time = seconds_to_read(path) if given.time is None else given.time
        job, bounds = ReadMesh(path), replace(given, time=time)
        return kept_or_made(job, lambda: in_own_process(job, bounds))

    return spread_mesh(read, METRES[length_unit], comm)


def generate_mesh(geometry: Geometry, comm: MPI.Comm) -> TaggedMesh:
    """Mesh a built-in geometry.

    Raises:
        GeometryError: if the geometry cannot be made.
        MeshError: if its mesh cannot be used.
    """
    return spread_mesh(lambda: built_in(geometry), METRES[geometry.length_unit], comm)


def stored_mesh(stored: StoredMesh, comm: MPI.Comm) -> TaggedMesh:
    """A mesh that an earlier run has kept, with the groups of its file or geometry."""
    return spread_mesh(stored.read, stored.metres, comm)


def spread_mesh(read: Callable[[], RawMesh], metres: float, comm: MPI.Comm) -> TaggedMesh:
    """Spread the mesh that rank 0 reads over the ranks.

    Args:
        read: Called on rank 0 alone; what it raises is raised on all ranks.
        metres: Metres in one unit of its coordinates.
        comm: Communicator of the mesh.
    """
    spread = distributed(read, metres, comm)
    return TaggedMesh(
        spread.mesh,
        spread.facets,
        spread.cells,
        spread.nodes,
        spread.attached,
        spread.constraints,
        spread.notes,
        spread.as_read,
    )
