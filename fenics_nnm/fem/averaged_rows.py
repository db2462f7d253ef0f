"""Contact rows that average the displacement about a point in place of taking it at a vertex."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from dolfinx.fem.petsc import assemble_matrix

from fenics_nnm.arrays import Indices
from fenics_nnm.fem.patch_vertices import PatchVertices, at_vertices
from fenics_nnm.fem.rows import Entries
from fenics_nnm.fem.solid import Solid


def averaged_entries(
    solid: Solid, facets: Indices, vertices: PatchVertices, point: Indices
) -> Entries:
    """Weights of displacement blocks in the mean displacement about each contact point.

    With the linear hat functions h_v of the vertices v of point c, and basis functions phi_i,

        W_ci = sum_v int h_v phi_i dS / sum_v int h_v dS,

    so that the force of a point acts as a pressure that is linear between the vertices.

    Args:
        solid: Assembled body.
        facets: Local facets of the patch.
        vertices: All their vertices.
        point: Contact point that each vertex belongs to, shape (n,).
    """
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    tags = dmesh.meshtags(mesh, dim - 1, np.sort(facets), np.ones(len(facets), dtype=np.int32))
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)(1)
    hats = fem.functionspace(mesh, ("Lagrange", 1))
    scalar = fem.functionspace(mesh, ("Lagrange", solid.body.degree))
    extent = fem.Constant(mesh, float(solid.body.extent))
    form = extent * ufl.TrialFunction(scalar) * ufl.TestFunction(hats) * ds
    matrix = assemble_matrix(fem.form(form))
    matrix.assemble()
    starts, columns, values = matrix.getValuesCSR()
    matrix.destroy()
    areas = np.bincount(point, weights=vertices.areas)
    blocks = _blocks(solid, scalar, columns)
    dofs = at_vertices(mesh, hats.dofmap.list)
    parts = []
    for vertex in np.flatnonzero(vertices.local >= 0):
        row, owner = dofs[vertices.local[vertex]], point[vertex]
        own = slice(starts[row], starts[row + 1])
        used = values[own] != 0
        rows = np.full(np.count_nonzero(used), owner)
        parts.append((rows, blocks[own][used], values[own][used] / areas[owner]))
    return Entries.joined(parts)


def _blocks(solid: Solid, scalar: fem.FunctionSpace, columns: Indices) -> Indices:
    """Global blocks of the displacement space of global columns of a scalar space alike."""
    numbers = np.zeros(scalar.dofmap.list.max(initial=0) + 1, dtype=np.int32)
    numbers[scalar.dofmap.list] = solid.space.dofmap.list
    local = scalar.dofmap.index_map.global_to_local(np.asarray(columns, dtype=np.int64))
    found = solid.space.dofmap.index_map.local_to_global(numbers[local])
    return np.asarray(found, dtype=np.int64)
