"""Geometries of CAD programs, meshed by gmsh in a process of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fenics_nnm.fem.boundary import boundary
from fenics_nnm.fem.cached_mesh import kept_or_made
from fenics_nnm.fem.cad_model import Cad, MeshCad, Near
from fenics_nnm.fem.mesh import TaggedMesh, spread_mesh
from fenics_nnm.fem.mesh_file import assert_file
from fenics_nnm.fem.native import Limits, in_own_process
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.geometry.lengths import METRES

#: Most parts that the edge of a facet is divided into where distances from it are measured.
_MOST_PARTS = 30


@dataclass(frozen=True, slots=True)
class Refined:
    """Smaller elements near named facets; lengths in the unit of the file.

    Attributes:
        facets: Names of groups.
        size: Edge length at the facets.
        distance: Distance over which the edge length grows to that of the rest.
        key: What messages call the names.
    """

    facets: tuple[str, ...]
    size: float
    distance: float
    key: str = "refined facets"


def read_cad(
    cad: Cad,
    refined: tuple[Refined, ...],
    pick: Callable[[TaggedMesh], TaggedMesh],
    comm: MPI.Comm,
    limits: Limits,
) -> TaggedMesh:
    """Mesh a geometry.

    Groups of facets are the physical groups of a .geo file and "face N" of all CAD faces (of a
    plane body "edge N"), those of cells "body" and the names of the solids.

    Args:
        cad: File and sizes.
        refined: Where elements are smaller.
        pick: Adds groups that are picked by place to a mesh; they may be named by `refined`.
        comm: Communicator of the mesh.
        limits: What the mesher may take, each time of two if there is refinement.

    Raises:
        MeshError: if the file cannot be read or meshed; the message says why.
    """
    metres = METRES[cad.length_unit]

    def meshed(job: MeshCad) -> RawMesh:
        return kept_or_made(job, lambda: in_own_process(job, limits))

    def read() -> RawMesh:
        assert_file(cad.path)
        raw = meshed(MeshCad(cad))
        if not refined:
            return raw
        coarse = pick(spread_mesh(lambda: raw, metres, MPI.COMM_SELF))
        return meshed(MeshCad(cad, tuple(_near(coarse, part, metres) for part in refined)))

    return spread_mesh(read, metres, comm)


def _near(coarse: TaggedMesh, part: Refined, metres: float) -> Near:
    """Points all over the facets, at most about the edge length apart, in the unit of the file."""
    facets = coarse.facets_of(part.facets, part.key)
    surface = boundary(coarse.mesh)
    chosen = surface.mask(facets) != 0
    corners = surface.corners[chosen] / metres
    longest = float(surface.sizes.max()) / metres
    parts = int(np.ceil(min(longest / part.size, _MOST_PARTS)))
    grid = np.array(list(np.ndindex(*[parts + 1] * corners.shape[1])))
    weights = grid[grid.sum(axis=1) == parts] / parts
    points = np.einsum("wc,fcd->fwd", weights, corners).reshape(-1, corners.shape[2])
    area = float(surface.areas[chosen].sum()) / metres ** (coarse.dim - 1)
    return Near(points, area, part.size, part.distance)
