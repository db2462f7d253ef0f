"""Steady loads that no integral over the body has: forces, and attached masses that spin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from dolfinx.fem.petsc import assemble_matrix, assemble_vector
from petsc4py import PETSc

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.loads import Loads, Rotation
from fenics_nnm.fem.point_rows import force_row
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.stress import Expr


@dataclass(frozen=True, slots=True)
class PointLoads:
    """Forces f + D u at the owned degrees of freedom.

    Attributes:
        constant: f in N, shape (n_owned,).
        softening: D = Omega^2 m P of attached masses m, P normal to the axis, in N/m; empty
            without such masses.
    """

    constant: Array
    softening: tuple[PETSc.Mat, ...] = ()

    def forces(self, displacement: Array) -> Array:
        """F + D u in N, shape (n_owned,)."""
        found = self.constant.copy()
        for matrix in self.softening:
            right, left = matrix.createVecs()
            right.array[:] = displacement
            matrix.mult(right, left)
            found += left.array
            right.destroy()
            left.destroy()
        return found

    def add_slope(self, matrix: PETSc.Mat, factor: float) -> None:
        """Add a factor times D to a matrix of the body."""
        for each in self.softening:
            matrix.axpy(factor, each, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)


def point_loads(solid: Solid, loads: Loads) -> PointLoads:
    """Forces and spinning masses at a body under loads; called on all ranks.

    Raises:
        MeshError: if a force acts where there is no body, or on what is clamped.
        ModelError: if a mass that spins differs between directions.
    """
    forces = np.zeros(solid.owned)
    for force in loads.forces:
        forces += force_row(solid, force) * np.linalg.norm(force.values)
    masses = [each for each in solid.body.attachments if each.kind == "mass"]
    if loads.rotation is None or not loads.speed or not masses:
        return PointLoads(forces)
    _assert_alike(masses)
    softening, pull = _spread(solid, loads.rotation, [each for each in masses if each.facets])
    for each in masses:
        if each.point:
            _add_at_vertex(solid, loads.rotation, each, softening, pull)
    softening.assemble()
    pull[solid.clamped[solid.clamped < solid.owned]] = 0.0
    return PointLoads(forces + pull, (softening,))


def _assert_alike(masses: Sequence[Attachment]) -> None:
    for each in masses:
        if max(each.values) != min(each.values):
            raise ModelError(
                f"{each.key}: its mass differs between directions, which has no meaning where it "
                "rotates: must be the same in all"
            )


def _spread(
    solid: Solid, rotation: Rotation, masses: Sequence[Attachment]
) -> tuple[PETSc.Mat, Array]:
    """D and f of masses that are spread over facets."""
    dim, mesh = solid.tagged.dim, solid.tagged.mesh
    matrix, force = solid.stiffness.copy(), np.zeros(solid.owned)
    matrix.zeroEntries()
    P = fem.Constant(mesh, np.ascontiguousarray(rotation.normal[:dim, :dim]))
    u, v, x = ufl.TrialFunction(solid.space), ufl.TestFunction(solid.space), _place(solid, rotation)
    for each in masses:
        ds, size = _over(solid, each)
        factor = fem.Constant(mesh, each.values[0] * rotation.speed**2 / size)
        part = assemble_matrix(fem.form(factor * ufl.dot(P * u, v) * ds), solid.held, 0.0)
        part.assemble()
        matrix.axpy(1.0, part, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
        part.destroy()
        vector = assemble_vector(fem.form(factor * ufl.dot(P * x, v) * ds))
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        force += vector.array
        vector.destroy()
    return matrix, force


def _place(solid: Solid, rotation: Rotation) -> Expr:
    """X - o."""
    x = ufl.SpatialCoordinate(solid.tagged.mesh)
    return ufl.as_vector([x[i] - float(rotation.origin[i]) for i in range(solid.tagged.dim)])


def _over(solid: Solid, attachment: Attachment) -> tuple[ufl.Measure, float]:
    """Measure of the facets of an attachment, and their area in m^2 of the mesh."""
    tagged, mesh = solid.tagged, solid.tagged.mesh
    facets = tagged.facets_of(attachment.facets, f"{attachment.key}.facets")
    tags = dmesh.meshtags(mesh, tagged.dim - 1, facets, np.ones(len(facets), dtype=np.int32))
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)(1)
    size = mesh.comm.allreduce(fem.assemble_scalar(fem.form(fem.Constant(mesh, 1.0) * ds)))
    return ds, float(size)


def _add_at_vertex(
    solid: Solid, rotation: Rotation, mass: Attachment, softening: PETSc.Mat, force: Array
) -> None:
    """Add D and f of a mass at a vertex, on the rank that owns it."""
    dim, vertex = solid.tagged.dim, solid.vertices[mass.key]
    if vertex.block < 0:
        return
    size = solid.space.dofmap.index_map_bs
    first = (solid.space.dofmap.index_map.local_range[0] + vertex.block) * size
    factor = mass.values[0] * rotation.speed**2
    at = vertex.block * size + np.arange(dim)
    force[at] += factor * rotation.arm(in_space(vertex.point[None]))[0, :dim]
    P = rotation.normal[:dim, :dim] * ~np.isin(at, solid.clamped)
    P = P * ~np.isin(at, solid.clamped)[:, None]
    rows = np.arange(first, first + dim, dtype=np.int32)
    softening.setValues(rows, rows, factor * P, PETSc.InsertMode.ADD_VALUES)
