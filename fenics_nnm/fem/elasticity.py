"""The elasticity of each cell as plain numbers, whatever its material and theory."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.solid import Solid, stress_tensor

#: Rows and columns of a symmetric tensor in VTK's order XX YY ZZ XY YZ XZ.
VTK_ORDER = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def elasticity_at(solid: Solid, points: Array) -> Array:
    """Stress in Pa per unit strain in the cells of this rank.

    Args:
        solid: Body.
        points: Reference coordinates in a cell, shape (s, dim).

    Returns:
        Shape (cells, s, 6, strains): stresses in VTK's order of the strains xx; xx, yy, 2 xy; or
        xx, yy, zz, 2 xy, 2 yz, 2 xz.
    """
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    strain = fem.Constant(mesh, np.zeros((dim, dim)))
    sigma = stress_tensor(ufl.dot(strain, ufl.SpatialCoordinate(mesh)), solid)
    components = ufl.as_vector([sigma[i, j] for i, j in VTK_ORDER])
    expression = fem.Expression(components, points)
    cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
    columns = []
    for i, j in (place for place in VTK_ORDER if max(place) < dim):
        strain.value[:] = 0.0
        strain.value[i, j] = strain.value[j, i] = 1.0 if i == j else 0.5
        columns.append(expression.eval(mesh, cells).reshape(len(cells), len(points), 6))
    return np.stack(columns, axis=-1)


def region_of_cells(solid: Solid) -> Indices:
    """Number of the region of each cell of this rank, from 0."""
    topology = solid.tagged.mesh.topology
    found = np.zeros(topology.index_map(topology.dim).size_local, dtype=np.int64)
    for number, (_, cells) in enumerate(solid.regions.parts):
        found[cells[cells < len(found)]] = number
    return found
