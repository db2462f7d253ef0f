"""Stress of the static state of a body."""

from __future__ import annotations

import basix
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.elasticity import VTK_ORDER
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.stress import Expr, strain_stress, warm_stress
from fenics_nnm.materials.material import Material


def state_stress(solid: Solid) -> Expr:
    """Cauchy stress F S F^T / det F in Pa of a loaded body, a 3 x 3 tensor in UFL.

    In plane stress and in a rod the change of the thickness or the cross-section is left out.
    """
    assert solid.state is not None
    u, loads, dim = solid.state.displacement, solid.state.loads, solid.tagged.dim
    mesh, theory = solid.tagged.mesh, solid.body.theory
    slope = ufl.grad(u)
    strain = ufl.sym(slope) + slope.T * slope / 2
    whole = [[slope[i, j] if max(i, j) < dim else 0 for j in range(3)] for i in range(3)]
    F = ufl.Identity(3) + ufl.as_tensor(whole)

    def stress(material: Material) -> Expr:
        if not loads.warming.any:
            return strain_stress(strain, material, theory, mesh)
        return warm_stress(strain, loads.warming.expression(mesh), material, theory, mesh)

    S = solid.regions.piecewise(stress)
    return F * S * F.T / ufl.det(F)


def state_stress_at(solid: Solid, points: Array) -> Array:
    """Cauchy stress in Pa of a loaded body in the cells of this rank, in VTK's order.

    Args:
        solid: Body about its static state.
        points: Reference coordinates in a cell, shape (s, dim).

    Returns:
        Shape (cells, s, 6).
    """
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    sigma = state_stress(solid)
    components = ufl.as_vector([sigma[i, j] for i, j in VTK_ORDER])
    cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
    found = fem.Expression(components, points).eval(mesh, cells)
    return np.asarray(found).reshape(len(cells), len(points), 6)


def largest_von_mises(solid: Solid) -> float:
    """Largest von Mises stress in Pa of a loaded body, at points inside its cells; on all ranks."""
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    sigma = state_stress(solid)
    deviator = sigma - ufl.tr(sigma) / 3 * ufl.Identity(3)
    value = ufl.sqrt(3 * ufl.inner(deviator, deviator) / 2)
    kind = basix.CellType[mesh.topology.cell_name()]
    points, _ = basix.make_quadrature(kind, 2 * (solid.body.degree - 1))
    cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
    found = fem.Expression(value, points).eval(mesh, cells)
    return float(mesh.comm.allreduce(np.max(found, initial=0.0), op=MPI.MAX))
