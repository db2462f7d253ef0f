"""Stiffness and consistent mass of an elastic body in one, two or three dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.fem.petsc import assemble_matrix
from petsc4py import PETSc

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.mesh import TaggedMesh

Theory = Literal["rod", "plane-stress", "plane-strain", "solid"]

#: Dimension of the mesh that each theory needs.
THEORY_DIMENSION: dict[Theory, int] = {"rod": 1, "plane-stress": 2, "plane-strain": 2, "solid": 3}


@dataclass(frozen=True, slots=True)
class Body:
    """Material and theory of a homogeneous isotropic body, in SI units.

    Attributes:
        theory: "rod" (axial motion, E A and rho A), "plane-stress", "plane-strain" or "solid".
        young: Young's modulus in Pa.
        poisson: Poisson's ratio; without effect on a rod.
        density: Mass density in kg/m^3.
        extent: What the mesh lacks: cross-section of a rod in m^2, thickness of a plane body in
            m, 1 for a solid.
        degree: Polynomial degree of the displacement, 1 or 2.
    """

    theory: Theory
    young: float
    poisson: float
    density: float
    extent: float = 1.0
    degree: int = 2


@dataclass(frozen=True, slots=True)
class Solid:
    """Assembled body, clamped.

    Attributes:
        tagged: Mesh and named facets.
        space: Displacement space.
        stiffness: K in N/m, unit diagonal on clamped rows.
        mass: Consistent M in kg, zero on clamped rows.
        clamped: Local indices of clamped degrees of freedom, unrolled.
        body: Material and theory.
    """

    tagged: TaggedMesh
    space: fem.FunctionSpace
    stiffness: PETSc.Mat
    mass: PETSc.Mat
    clamped: Indices
    body: Body

    @property
    def dofs(self) -> int:
        """Number of degrees of freedom, clamped ones included."""
        index_map = self.space.dofmap.index_map
        return int(index_map.size_global * self.space.dofmap.index_map_bs)

    @property
    def owned(self) -> int:
        """Number of degrees of freedom of this rank."""
        return int(self.space.dofmap.index_map.size_local * self.space.dofmap.index_map_bs)


def assemble_solid(tagged: TaggedMesh, body: Body, clamped_facets: Indices) -> Solid:
    """Assemble stiffness and mass, clamped on the given local facets.

    Raises:
        MeshError: if the dimension of the mesh is not that of the theory.
    """
    expected = THEORY_DIMENSION[body.theory]
    if tagged.dim != expected:
        raise MeshError(
            f'body.theory = "{body.theory}": needs a mesh of dimension {expected}, '
            f"this one has dimension {tagged.dim}"
        )
    mesh = tagged.mesh
    space = fem.functionspace(mesh, ("Lagrange", body.degree, (tagged.dim,)))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    strain_energy = ufl.inner(stress(u, body, mesh), strain(v)) * ufl.dx
    inertia = fem.Constant(mesh, float(body.density * body.extent)) * ufl.inner(u, v) * ufl.dx
    blocks = fem.locate_dofs_topological(space, tagged.dim - 1, clamped_facets)
    zero = np.zeros(tagged.dim, dtype=default_scalar_type)
    clamp = [fem.dirichletbc(zero, blocks, space)]
    K = assemble_matrix(fem.form(strain_energy), clamp, 1.0)
    M = assemble_matrix(fem.form(inertia), clamp, 0.0)
    for matrix in (K, M):
        matrix.assemble()
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    unrolled = (blocks[:, None] * tagged.dim + np.arange(tagged.dim)).ravel().astype(np.int32)
    return Solid(tagged, space, K, M, unrolled, body)


def strain(u: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
    """Small-strain tensor of a displacement."""
    return ufl.sym(ufl.grad(u))


def stress(u: ufl.core.expr.Expr, body: Body, mesh: object) -> ufl.core.expr.Expr:
    """Stress times `extent`: a force per length in 2-D, a force in 1-D.

    Isotropic linear elasticity; plane stress replaces Lame's first parameter by
    2 lambda mu / (lambda + 2 mu), and a rod has the stress E u'.
    """
    E, nu = body.young, body.poisson
    mu = E / (2 * (1 + nu))
    lam = E * nu / ((1 + nu) * (1 - 2 * nu)) if nu < 0.5 else np.inf
    if body.theory == "rod":
        return fem.Constant(mesh, float(E * body.extent)) * strain(u)
    if body.theory == "plane-stress":
        lam = E * nu / (1 - nu**2)
    first = fem.Constant(mesh, float(lam * body.extent))
    second = fem.Constant(mesh, float(2 * mu * body.extent))
    return first * ufl.tr(strain(u)) * ufl.Identity(len(u)) + second * strain(u)


def stress_tensor(u: ufl.core.expr.Expr, solid: Solid) -> ufl.core.expr.Expr:
    """Cauchy stress in Pa as a 3 x 3 tensor, of a displacement u of the body.

    A plane body has the stress sigma_zz = lambda tr(strain) in plane strain and none normal to its
    plane in plane stress; a rod has sigma_xx alone.
    """
    body, mesh = solid.body, solid.tagged.mesh
    own = stress(u, body, mesh) / fem.Constant(mesh, float(body.extent))
    if body.theory == "solid":
        return own
    size = len(u)
    rows = [[own[i, j] if max(i, j) < size else 0 for j in range(3)] for i in range(3)]
    if body.theory == "plane-strain":
        # tr(sigma) / 2 = (lambda + mu) tr(strain), and lambda / (lambda + mu) = 2 nu
        rows[2][2] = fem.Constant(mesh, float(body.poisson)) * ufl.tr(own)
    return ufl.as_tensor(rows)
