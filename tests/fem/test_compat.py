"""The bridge between versions of dolfinx."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from dolfinx import mesh as dmesh
from mpi4py import MPI

import fenics_nnm
from fenics_nnm.fem.compat import (
    cell_nodes,
    cell_permutation,
    coordinate_element,
    ufl_mesh,
)

SOURCE = Path(fenics_nnm.__file__).parent

#: What some versions from 0.9 on do not have, have elsewhere, or warn of.
MOVED = (
    r"\bgmshio\b",
    r"dolfinx\.io import gmsh",
    r"geometry\.(dofmaps?|cmaps?)\b",
    r"interpolation_points",
    r"assemble_matrix\(.*diag(onal)?=",
    r"num_entity(_closure)?_dofs",
    r"dolfinx\.nls",
    r"index_to_dest_ranks",
)


def test_no_other_module_uses_names_that_moved() -> None:
    found = [
        f"{path.relative_to(SOURCE)}:{number}: {line}"
        for path in SOURCE.rglob("*.py")
        if path.name != "compat.py"
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1)
        if any(re.search(pattern, line) for pattern in MOVED)
    ]
    assert not found


def test_cells_have_their_nodes() -> None:
    mesh = dmesh.create_rectangle(
        MPI.COMM_SELF, [[0.0, 0.0], [3.0, 2.0]], [3, 2], dmesh.CellType.quadrilateral
    )
    corners = mesh.geometry.x[cell_nodes(mesh)]
    assert corners.shape == (6, 4, 3)
    np.testing.assert_allclose(np.ptp(corners, axis=1), [[1.0, 1.0, 0.0]] * 6)
    assert coordinate_element(mesh).degree == 1
    middle = coordinate_element(mesh).push_forward(np.array([[0.5, 0.5]]), corners[0, :, :2])
    np.testing.assert_allclose(middle[0], corners[0, :, :2].mean(axis=0))


def test_nodes_of_gmsh_are_put_in_dolfinx_order() -> None:
    # gmsh goes round a quadrangle, dolfinx counts its corners like the bits of 0 to 3
    order = cell_permutation(dmesh.CellType.quadrilateral, 4)
    np.testing.assert_array_equal(order, [0, 1, 3, 2])
    mesh = ufl_mesh(10, 2, np.float64)
    assert mesh.ufl_coordinate_element().embedded_superdegree >= 2
