"""The consistent mass of a body: that of one axis, for each of its axes.

Nothing couples the axes of rho u . v. So a vector of displacements has a third of the entries, in
space, that it shares with the stiffness, and the integrals are those of one axis.
"""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import assemble_matrix
from petsc4py import PETSc
from scipy import sparse

from fenics_nnm.fem.regions import Regions


def mass_matrix(space: fem.FunctionSpace, regions: Regions, extent: float) -> PETSc.Mat:
    """Consistent mass in kg of a body that nothing holds; its pattern is a part of K's.

    Args:
        space: Displacement space.
        regions: Materials and their cells.
        extent: As `solid.Body.extent`.
    """
    mesh, degree = space.mesh, space.element.basix_element.degree
    axis = fem.functionspace(mesh, ("Lagrange", degree))
    assert np.array_equal(axis.dofmap.list, space.dofmap.list)  # so that nodes have one number
    u, v = ufl.TrialFunction(axis), ufl.TestFunction(axis)
    form = regions.integral(
        lambda each: fem.Constant(mesh, float(each.density * extent)) * u * v, degree
    )
    matrix = assemble_matrix(fem.form(form))
    matrix.assemble()
    found = _for_each_axis(matrix, space.dofmap.index_map_bs)
    matrix.destroy()
    return found


def _for_each_axis(matrix: PETSc.Mat, axes: int) -> PETSc.Mat:
    """The matrix of displacements of nodes from that of one axis."""
    first, columns, values = matrix.getValuesCSR()
    nodes, total = matrix.getLocalSize()[0], matrix.getSize()[1]
    of_axis = sparse.csr_array((values, columns, first), shape=(nodes, total))
    rows = of_axis[np.repeat(np.arange(nodes), axes)]
    axis = np.tile(np.arange(axes, dtype=columns.dtype), nodes).repeat(np.diff(rows.indptr))
    csr = (rows.indptr, axes * rows.indices + axis, rows.data)
    sizes = [(axes * local, axes * every) for local, every in matrix.getSizes()]
    return PETSc.Mat().createAIJ(sizes, csr=csr, comm=matrix.comm)
