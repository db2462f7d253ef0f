"""Files of several programs against CalculiX on the same meshes, a clamped beam of steel.

The figures of CalculiX are made anew by tests/calculix.py; the table in docs/verification_bodies.md
is that of this file.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ufl
from calculix import DENSITY, KEPT, POISSON, YOUNG, mesh
from cell_boxes import write_bdf, write_cdb, write_inp, write_vtu
from dolfinx import fem
from dolfinx.fem.petsc import assemble_matrix
from mpi4py import MPI
from scipy.linalg import eigh

from fenics_nnm.fem.foreign_mesh import ForeignMesh
from fenics_nnm.fem.mesh import read_mesh
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.picking import Level, Pick, with_groups
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, Solid, assemble_solid
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material

CALCULIX: dict[str, list[float]] = json.loads(KEPT.read_text())

#: Writer of each kind of file.
FILES: dict[str, Callable[[ForeignMesh, Path], Any]] = {
    "inp": write_inp,
    "bdf": write_bdf,
    "cdb": write_cdb,
    "vtu": write_vtu,
}

#: Mesh, degree of the displacement and largest relative difference of the first four frequencies.
CASES = [
    ("C3D10", 2, 1e-4),
    ("C3D20", 2, 1e-2),
    ("C3D20, finer", 2, 1.3e-3),
    ("C3D15", 2, 1e-2),
    ("C3D15, finer", 2, 3e-3),
    ("C3D20 and C3D15", 2, 1e-2),
    ("C3D20 and C3D15, finer", 2, 3e-3),
]


def assembled(path: Path, degree: int) -> Solid:
    """The clamped beam of a file."""
    tagged = with_groups(
        read_mesh(path, "m", MPI.COMM_SELF), {"root of the beam": Pick([Level(0, 0.0)])}
    )
    region = Region(Material(Isotropic(YOUNG, POISSON), DENSITY))
    body = Body("solid", (region,), degree=degree)
    return assemble_solid(tagged, body, tagged.facets["root of the beam"])


def ours(path: Path, degree: int) -> np.ndarray:
    """The lowest four frequencies of a file in Hz."""
    with DirectModalSolver(assembled(path, degree)) as solver:
        return np.asarray(solver.modes(4).frequencies)


@pytest.mark.parametrize(("name", "degree", "within"), CASES, ids=[name for name, *_ in CASES])
def test_frequencies_of_calculix(name: str, degree: int, within: float, tmp_path: Path) -> None:
    write_inp(mesh(name), tmp_path / "a.inp")
    apart = np.abs(ours(tmp_path / "a.inp", degree) / np.array(CALCULIX[name]) - 1)
    assert apart.max() < within, apart


def test_linear_tetrahedra_with_the_mass_of_calculix(tmp_path: Path) -> None:
    """CalculiX takes the mass of C3D4 at one point: then frequencies agree to all its digits.

    With the consistent mass, which is used here, they are lower by less than its error.
    """
    write_inp(mesh("C3D4"), tmp_path / "a.inp")
    solid = assembled(tmp_path / "a.inp", 1)
    u, v = ufl.TrialFunction(solid.space), ufl.TestFunction(solid.space)
    form = DENSITY * ufl.inner(u, v) * ufl.dx(metadata={"quadrature_degree": 1})
    at_one_point = assemble_matrix(fem.form(form))
    at_one_point.assemble()
    K, M, consistent = (
        free_part(solid, matrix) for matrix in (solid.stiffness, at_one_point, solid.mass)
    )
    squared = eigh(M, K, eigvals_only=True)
    found = np.sort(1 / np.sqrt(squared[-4:]) / (2 * np.pi))
    np.testing.assert_allclose(found, CALCULIX["C3D4"], rtol=1e-6)
    own = np.sqrt(eigh(K, consistent, eigvals_only=True)[:4]) / (2 * np.pi)
    assert (own > 0.98 * found).all() and (own < found * 1.02).all()


def free_part(solid: Solid, matrix: Any) -> np.ndarray:
    """Rows and columns of the free degrees of freedom."""
    free = np.setdiff1d(np.arange(solid.dofs), solid.clamped)
    return np.asarray(matrix.convert("dense").getDenseArray())[np.ix_(free, free)]


def test_hexahedra_with_the_shape_functions_of_calculix(tmp_path: Path) -> None:
    """C3D20 has no nodes inside; here they follow the others, as its shape functions say."""
    write_inp(mesh("C3D20"), tmp_path / "a.inp")
    solid = assembled(tmp_path / "a.inp", 2)
    T = np.kron(serendipity(solid), np.eye(3))
    free = np.setdiff1d(np.arange(solid.dofs), solid.clamped)
    T = T[free][:, free]
    T = T[:, np.abs(T).sum(axis=0) > 0]
    K, M = (T.T @ free_part(solid, matrix) @ T for matrix in (solid.stiffness, solid.mass))
    found = np.sqrt(eigh(K, M, eigvals_only=True)[:4]) / (2 * np.pi)
    np.testing.assert_allclose(found, CALCULIX["C3D20"], rtol=1e-6)


def serendipity(solid: Solid) -> np.ndarray:
    """Values at all blocks by those at corners and middles of edges, of bricks along the axes."""
    x = solid.space.tabulate_dof_coordinates()
    T, inner = np.eye(len(x)), []
    for blocks in solid.space.dofmap.list:
        middle = (x[blocks].max(axis=0) + x[blocks].min(axis=0)) / 2
        inside = np.isclose(x[blocks], middle, atol=1e-9)
        for block, zeros in zip(blocks, inside, strict=True):
            if zeros.sum() < 2:
                continue
            near = blocks[np.isclose(x[blocks][:, ~zeros], x[block][~zeros], atol=1e-9).all(axis=1)]
            edges = np.isin(blocks, near) & (inside.sum(axis=1) == 1)
            corners = np.isin(blocks, near) & (inside.sum(axis=1) == 0)
            T[block] = 0.0
            T[block, blocks[edges]] = 2 / edges.sum() if zeros.sum() == 2 else 3 / edges.sum()
            T[block, blocks[corners]] = -1 / corners.sum() if zeros.sum() == 2 else -2 / 8
            inner.append(block)
    T[:, inner] = 0.0
    return T


@pytest.mark.parametrize("ending", FILES)
@pytest.mark.parametrize("name", ["C3D10", "C3D15", "C3D20 and C3D15"])
def test_files_of_one_mesh_have_the_same_frequencies(
    name: str, ending: str, tmp_path: Path
) -> None:
    write_inp(mesh(name), tmp_path / "a.inp")
    FILES[ending](mesh(name), tmp_path / f"b.{ending}")
    same = ours(tmp_path / f"b.{ending}", 2) / ours(tmp_path / "a.inp", 2)
    within = 1e-2 if name != "C3D10" and ending == "cdb" else 1e-8
    np.testing.assert_allclose(same, 1, rtol=within)
