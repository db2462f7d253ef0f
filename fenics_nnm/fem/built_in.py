"""Built-in geometries, meshed here or, where OpenCASCADE makes them, in a process of their own."""

from __future__ import annotations

from fenics_nnm.fem.build_geometry import BuildGeometry
from fenics_nnm.fem.cached_mesh import kept_or_made
from fenics_nnm.fem.native import Limits, in_own_process
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.geometry import Geometry


def built_in(geometry: Geometry) -> RawMesh:
    """The mesh of a built-in geometry.

    Raises:
        GeometryError: if the geometry cannot be made.
        MeshError: if its mesh cannot be used.
    """
    job = BuildGeometry(geometry)
    if geometry.native:
        return kept_or_made(job, lambda: in_own_process(job, Limits()))
    from fenics_nnm.fem.gmsh_mesh import gmsh_session  # takes 0.15 s, of no use above

    with gmsh_session(job.errors.what):
        return job.mesh()
