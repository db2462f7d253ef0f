"""The mass of a body is that of the form of its inertia, without the entries between axes."""

import json
from pathlib import Path

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import assemble_matrix
from mpi4py import MPI
from ranks import on_ranks
from scipy import sparse

from fenics_nnm.fem.mass import mass_matrix
from fenics_nnm.fem.regions import Regions
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material

SELF, DENSITIES, EXTENT = MPI.COMM_SELF, (7800.0, 2700.0), 0.3
MESHES = {
    1: lambda: mesh.create_unit_interval(SELF, 7),
    2: lambda: mesh.create_unit_square(SELF, 3, 4, mesh.CellType.quadrilateral),
    3: lambda: mesh.create_unit_cube(SELF, 2, 3, 2),
}


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("dim", MESHES)
def test_mass_of_two_materials_is_that_of_the_form_of_all_axes(dim: int, degree: int) -> None:
    domain = MESHES[dim]()
    cells = np.arange(domain.topology.index_map(dim).size_local, dtype=np.int32)
    materials = [Material(Isotropic(2e11, 0.3), density) for density in DENSITIES]
    regions = Regions(domain, tuple(zip(materials, np.split(cells, [3]), strict=True)))
    space = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    density = fem.Function(fem.functionspace(domain, ("DG", 0)))
    density.x.array[:] = np.where(cells < 3, *DENSITIES)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    whole = assemble_matrix(fem.form(EXTENT * density * ufl.inner(u, v) * ufl.dx))
    whole.assemble()

    matrix = mass_matrix(space, regions, EXTENT)
    found, expected = (sparse.csr_array(each.getValuesCSR()[::-1]) for each in (matrix, whole))
    assert abs(found - expected).max() <= 1e-14 * abs(expected).max()
    assert found.nnz * dim == expected.nnz
    along = np.zeros(len(matrix.createVecRight().array))
    along[dim - 1 :: dim] = 1.0
    share = 3 / len(cells)  # of cells of one size
    mean = share * DENSITIES[0] + (1 - share) * DENSITIES[1]
    assert along @ found @ along == pytest.approx(mean * EXTENT, rel=1e-12)


def test_mass_spread_over_facets_stops_at_the_clamp_on_several_ranks(tmp_path: Path) -> None:
    """Motion (1, 2), but none at a clamped side, where quadratic elements of size h = 1/6 begin.

    There 1 less the first shape function N = (1 - s)(1 - 2 s) moves, of mean square 4/5.
    """
    script = Path(__file__).parents[1] / "spread_mass_on_ranks.py"
    ended = on_ranks(2, script, "found.json", folder=tmp_path, seconds=60)
    assert ended.code == 0, ended.err
    share = 1 - (1 - 4 / 5) / 6
    expected = share * (7800.0 * (1 + 4) + 100.0 * 1 + 300.0 * 4)
    assert json.loads((tmp_path / "found.json").read_text()) == pytest.approx(expected, rel=1e-12)
