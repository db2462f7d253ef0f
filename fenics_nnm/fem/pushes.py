"""What drives a body, as unit columns at the degrees of freedom with their sizes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from dolfinx.fem.petsc import assemble_vector
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.gyroscopic import inertia_of_free_body
from fenics_nnm.fem.loads import Pressure
from fenics_nnm.fem.point_rows import force_row
from fenics_nnm.fem.solid import Solid


class Push(Protocol):
    """Something that drives a body."""

    def column(self, solid: Solid) -> tuple[Array, float]:
        """Unit forces, shape (n_owned,), and their size in N; to be called on all ranks.

        The displacement that goes with unit forces is that of the place: of facets their mean.

        Raises:
            MeshError: if it acts where there is no body, or on what is clamped.
        """


@dataclass(frozen=True, slots=True)
class Force:
    """A force at a point, or spread evenly over facets.

    Attributes:
        attachment: The force.
    """

    attachment: Attachment

    def column(self, solid: Solid) -> tuple[Array, float]:
        """Unit forces and their size."""
        return force_row(solid, self.attachment), float(np.linalg.norm(self.attachment.values))


@dataclass(frozen=True, slots=True)
class FacetPressure:
    """A pressure on facets, along the normals of the body at rest.

    Attributes:
        pressure: The pressure.
    """

    pressure: Pressure

    def column(self, solid: Solid) -> tuple[Array, float]:
        """Unit forces into the body, and the pressure times the area."""
        tagged, mesh, key = solid.tagged, solid.tagged.mesh, self.pressure.key
        facets = tagged.facets_of(self.pressure.facets, f"{key}.facets")
        tags = dmesh.meshtags(mesh, tagged.dim - 1, facets, np.ones(len(facets), dtype=np.int32))
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)(1)
        area = mesh.comm.allreduce(fem.assemble_scalar(fem.form(fem.Constant(mesh, 1.0) * ds)))
        if not area:
            raise MeshError(f"{key}.facets: lie inside the body: must be on its surface")
        test, normal = ufl.TestFunction(solid.space), ufl.FacetNormal(mesh)
        inwards = fem.Constant(mesh, -1.0 / area) * ufl.inner(normal, test)
        vector = assemble_vector(fem.form(inwards * ds))
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        row = np.array(vector.array[: solid.owned])
        vector.destroy()
        row[solid.clamped[solid.clamped < solid.owned]] = 0.0
        if not mesh.comm.allreduce(int(row.any())):
            raise MeshError(f"{key}: acts on what is clamped: a pressure there has no effect")
        return row, float(self.pressure.value * area * solid.body.extent)


@dataclass(frozen=True, slots=True)
class ShakenBase:
    """Acceleration of what holds the body; displacements are those against it.

    Attributes:
        acceleration: Along each axis in m/s^2, shape (dim,).
    """

    acceleration: tuple[float, ...]

    def column(self, solid: Solid) -> tuple[Array, float]:
        """Forces M d over the mass, and minus the mass times the acceleration."""
        size, dim = float(np.linalg.norm(self.acceleration)), solid.tagged.dim
        direction = np.tile(np.array(self.acceleration) / size, solid.owned // dim)
        inertia = inertia_of_free_body(solid, direction[:, None])[:, 0]
        mass = float(solid.tagged.mesh.comm.allreduce(direction @ inertia))
        row = inertia / mass
        row[solid.clamped[solid.clamped < solid.owned]] = 0.0
        return row, -mass * size
