"""Displacements that turn cells inside out, of each kind of cell, and such that do not."""

from __future__ import annotations

import numpy as np
import pytest
from dolfinx import fem
from dolfinx.mesh import CellType, create_unit_cube, create_unit_interval, create_unit_square
from mpi4py import MPI

from fenics_nnm.fem.inside_out import turned_inside_out

COMM = MPI.COMM_SELF
MESHES = {
    "interval": create_unit_interval(COMM, 2),
    "triangle": create_unit_square(COMM, 1, 1, CellType.triangle),
    "quadrilateral": create_unit_square(COMM, 2, 1, CellType.quadrilateral),
    "tetrahedron": create_unit_cube(COMM, 1, 1, 1, CellType.tetrahedron),
    "hexahedron": create_unit_cube(COMM, 2, 1, 1, CellType.hexahedron),
}


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("kind", MESHES)
def test_a_mirrored_body_is_inside_out_and_a_turned_one_is_not(kind: str, degree: int) -> None:
    mesh = MESHES[kind]
    dim, cells = mesh.topology.dim, mesh.topology.index_map(mesh.topology.dim).size_local
    u = fem.Function(fem.functionspace(mesh, ("Lagrange", degree, (dim,))))
    assert turned_inside_out(u) == 0
    u.interpolate(lambda x: np.array([-1.5 * x[0], *(0 * x[1:dim])]))
    assert turned_inside_out(u) == cells
    u.interpolate(lambda x: np.array([9 * x[0], *(-0.9 * x[1:dim])]))
    assert turned_inside_out(u) == 0
    if dim > 1:
        u.interpolate(lambda x: np.array([-2 * x[0], -2 * x[1], *(0 * x[2:dim])]))
        assert turned_inside_out(u) == 0


def test_one_corner_of_a_cell_is_enough() -> None:
    mesh = MESHES["quadrilateral"]
    u = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (2,))))
    u.interpolate(lambda x: np.where(x[0] * x[1] > 0.99, -0.9, 0.0) * np.ones((2, 1)))
    assert turned_inside_out(u) == 1
