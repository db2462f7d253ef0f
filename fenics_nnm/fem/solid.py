"""Stiffness and consistent mass of an elastic body in one, two or three dimensions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import assemble_matrix
from petsc4py import PETSc

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.attachments import (
    Vertex,
    add_at_vertex,
    add_spread_mass,
    nearest_vertex,
    spread_form,
)
from fenics_nnm.fem.clamp import Clamp, held_blocks, held_points
from fenics_nnm.fem.constrained import constrained
from fenics_nnm.fem.constraints import NO_CONSTRAINTS, LinearConstraints
from fenics_nnm.fem.mass import mass_matrix
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.regions import Region, Regions, regions_on
from fenics_nnm.fem.state import StaticState
from fenics_nnm.fem.stress import Expr, Theory, cauchy_stress, strain, stress
from fenics_nnm.fem.system import System
from fenics_nnm.fem.unrolled import owned_rows, unrolled

#: Dimension of the mesh that each theory needs.
THEORY_DIMENSION: dict[Theory, int] = {"rod": 1, "plane-stress": 2, "plane-strain": 2, "solid": 3}


@dataclass(frozen=True, slots=True)
class Body:
    """Theory and materials of a body, and what is attached to it, in SI units.

    Attributes:
        theory: "rod" (axial motion, E A and rho A), "plane-stress", "plane-strain" or "solid".
        regions: Materials and the cells that are of them.
        extent: What the mesh lacks: cross-section of a rod in m^2, thickness of a plane body in
            m, 1 for a solid.
        degree: Polynomial degree of the displacement, 1 or 2.
        attachments: Masses and springs.
        constraints: Constraints besides those of the mesh, of facets alone.
    """

    theory: Theory
    regions: tuple[Region, ...]
    extent: float = 1.0
    degree: int = 2
    attachments: tuple[Attachment, ...] = ()
    constraints: LinearConstraints = NO_CONSTRAINTS


@dataclass(frozen=True, slots=True)
class Solid:
    """Assembled body, clamped.

    K and M are those of all degrees of freedom; with constraints u = T v motion obeys those of
    `system`, T^T K T and T^T M T.

    Attributes:
        tagged: Mesh, named facets and cells.
        space: Displacement space.
        stiffness: K in N/m, unit diagonal on clamped rows.
        mass: Consistent M in kg, zero on clamped rows.
        clamped: Local indices of degrees of freedom that do not move, unrolled.
        body: Theory and materials.
        regions: Cells of each material.
        vertices: Vertex of each attachment at a point, by its key.
        system: What is solved.
        held: The clamp as conditions of dolfinx.
        state: Where it rests under steady loads, about which K is the tangent stiffness; None
            where nothing loads it.
    """

    tagged: TaggedMesh
    space: fem.FunctionSpace
    stiffness: PETSc.Mat
    mass: PETSc.Mat
    clamped: Indices
    body: Body
    regions: Regions
    vertices: dict[str, Vertex]
    system: System
    held: tuple[fem.DirichletBC, ...]
    state: StaticState | None = None

    @property
    def dofs(self) -> int:
        """Number of degrees of freedom, clamped ones included."""
        index_map = self.space.dofmap.index_map
        return int(index_map.size_global * self.space.dofmap.index_map_bs)

    @property
    def owned(self) -> int:
        """Number of degrees of freedom of this rank."""
        return int(self.space.dofmap.index_map.size_local * self.space.dofmap.index_map_bs)

    @property
    def free(self) -> int:
        """Number of free degrees of freedom, of all ranks."""
        clamped = int(np.count_nonzero(self.clamped < self.owned))
        held = int(self.tagged.mesh.comm.allreduce(clamped))
        return self.dofs - held - self.system.dependent


def assemble_solid(
    tagged: TaggedMesh, body: Body, clamped_facets: Indices, clamps: Sequence[Clamp] = ()
) -> Solid:
    """Assemble stiffness and mass, clamped on the given local facets, and by clamps besides.

    Raises:
        MeshError: if the dimension of the mesh is not that of the theory, not every cell has
            exactly one material, or something cannot be attached.
        ModelError: if the orientation of a material does not go with the theory.
    """
    body = replace(
        body,
        attachments=(*body.attachments, *tagged.attached),
        constraints=held_points(tagged, clamps).and_also(body.constraints),
    )
    expected = THEORY_DIMENSION[body.theory]
    if tagged.dim != expected:
        raise MeshError(
            f'theory "{body.theory}": needs a mesh of dimension {expected}, '
            f"this one has dimension {tagged.dim}",
            code=Code.THEORY,
        )
    regions = regions_on(tagged, body.regions)
    space = fem.functionspace(tagged.mesh, ("Lagrange", body.degree, (tagged.dim,)))
    clamp, fixed = _clamped(space, tagged, clamped_facets, clamps)
    joined = constrained(space, tagged, body.constraints, fixed)
    for axis in range(tagged.dim):
        clamp.append(_held_along(space, axis, joined.held[joined.held % tagged.dim == axis]))
    fixed = np.union1d(fixed, joined.held).astype(np.int32)
    K = assemble_matrix(fem.form(_strain_energy(space, body, regions)), clamp, 1.0)
    M = mass_matrix(space, regions, body.extent)
    vertices = _attach(tagged, space, body, (K, M), clamp, fixed)
    M.zeroRowsColumns(owned_rows(space, fixed), 0.0)
    K, M, system = joined.system(K, M)
    for matrix in (K, M):
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    held = tuple(clamp)
    return Solid(tagged, space, K, M, fixed, body, regions, vertices, system, held)


def _held_along(space: fem.FunctionSpace, axis: int, dofs: Indices) -> fem.DirichletBC:
    """No displacement along an axis at some degrees of freedom, unrolled."""
    if space.mesh.topology.dim == 1:  # whose space has no components
        return fem.dirichletbc(fem.Function(space), dofs)
    return fem.dirichletbc(np.float64(0.0), dofs, space.sub(axis))


def _clamped(
    space: fem.FunctionSpace, tagged: TaggedMesh, facets: Indices, clamps: Sequence[Clamp]
) -> tuple[list[fem.DirichletBC], Indices]:
    """Conditions of facets and clamps, and their local degrees of freedom, unrolled."""
    blocks = fem.locate_dofs_topological(space, tagged.dim - 1, facets)
    # a function, since from dolfinx 0.11 on a constant of a rod's vectors has another shape
    clamp = [fem.dirichletbc(fem.Function(space), blocks)]
    clamped = unrolled(blocks, tagged.dim)
    for axis, dofs in _held(space, tagged, clamps, clamped):
        clamp.append(_held_along(space, axis, dofs))
        clamped = np.union1d(clamped, dofs).astype(np.int32)
    return clamp, clamped


def _held(
    space: fem.FunctionSpace, tagged: TaggedMesh, clamps: Sequence[Clamp], before: Indices
) -> list[tuple[int, Indices]]:
    """Degrees of freedom along each axis that clamps hold, without those held before."""
    found: dict[int, list[Indices]] = {}
    for clamp in clamps:
        blocks = held_blocks(space, tagged, clamp)
        for axis in clamp.axes:
            found.setdefault(axis, []).append(blocks * tagged.dim + axis)
    return [
        (axis, np.setdiff1d(np.concatenate(parts), before).astype(np.int32))
        for axis, parts in sorted(found.items())
    ]


def _attach(
    tagged: TaggedMesh,
    space: fem.FunctionSpace,
    body: Body,
    matrices: tuple[PETSc.Mat, PETSc.Mat],
    clamp: list[fem.DirichletBC],
    clamped: Indices,
) -> dict[str, Vertex]:
    """Add masses and springs to K and M, which are left assembled; vertices of those at points."""
    vertices = {}
    for matrix, kind in zip(matrices, ("spring", "mass"), strict=True):
        matrix.assemble()  # what is added to values that are still on their way is lost
        for each in body.attachments:
            if each.kind == kind and each.point:
                vertices[each.key] = nearest_vertex(space, tagged, each, clamped)
                add_at_vertex(matrix, space, vertices[each.key], each.values, clamped)
            elif each.kind == kind:
                form = fem.form(spread_form(space, tagged, each, clamped, body.extent))
                if kind == "mass":
                    # without the clamp: the pattern of facets lacks diagonals of clamped rows
                    add_spread_mass(matrix, assemble_matrix(form))
                else:
                    assemble_matrix(matrix, form, clamp, 1.0)
                    matrix.assemble()
    return vertices


def stress_tensor(u: Expr, solid: Solid) -> Expr:
    """Cauchy stress in Pa as a 3 x 3 tensor, of a displacement u of the body.

    A plane body has the stress sigma_zz in plane strain and no stress on its plane in plane
    stress; a rod has sigma_xx alone. Stress jumps where the material does.
    """
    theory, mesh = solid.body.theory, solid.tagged.mesh
    return solid.regions.piecewise(lambda material: cauchy_stress(u, material, theory, mesh))


def _strain_energy(space: fem.FunctionSpace, body: Body, regions: Regions) -> Expr:
    """Bilinear form of the strain energy."""
    mesh = space.mesh
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    extent = fem.Constant(mesh, float(body.extent))
    return regions.integral(
        lambda each: extent * ufl.inner(stress(u, each, body.theory, mesh), strain(v)), body.degree
    )
