"""The job of making and meshing a built-in geometry, which a process of its own may do."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.fem.native_errors import GeometryErrors
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.geometry import Geometry


@dataclass(frozen=True, slots=True)
class BuildGeometry:
    """The job of making and meshing a built-in geometry.

    Attributes:
        geometry: The geometry.
    """

    geometry: Geometry

    @property
    def errors(self) -> GeometryErrors:
        """Errors of the geometry."""
        return GeometryErrors(self.geometry.model)

    @property
    def advice(self) -> str:
        """What to try."""
        return "try another element size, sections that change less, or a smaller fillet"

    @property
    def trusted(self) -> bool:
        """It needs no more than to read its tables."""
        return False

    def identity(self) -> str:
        """As `cached_mesh.Identified`; its tables count by their contents."""
        # not at the top: the process that makes the mesh has no use for all that they import
        from fenics_nnm.fem.cached_mesh import contents
        from fenics_nnm.study.leaves import leaves

        kind, values = type(self.geometry), self.geometry.model_dump()
        files = [value for _, value in leaves("mesh", values) if isinstance(value, Path)]
        return f"{kind.__module__}.{kind.__qualname__} {values!r} {[*map(contents, files)]!r}"

    def fault(self) -> str:
        """Nothing is known without OpenCASCADE."""
        return ""

    def __call__(self, folder: Path) -> RawMesh:
        """Make and mesh it.

        Raises:
            GeometryError: if the geometry cannot be made.
            MeshError: if its mesh cannot be used.
        """
        from fenics_nnm.fem.gmsh_mesh import gmsh_session  # as below

        with gmsh_session(self.errors.what, talks=True):
            return self.mesh()

    def mesh(self) -> RawMesh:
        """Make and mesh it in the current gmsh model."""
        # not at the top: takes 0.15 s, which the process that has the mesh made has no use for
        import gmsh

        from fenics_nnm.fem.gmsh_mesh import extracted

        self.geometry.build(gmsh.model)
        return extracted(self.errors.what)
