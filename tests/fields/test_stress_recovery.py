"""Stresses at nodes: rates on a manufactured solution, exact polynomials, materials that meet."""

from collections.abc import Callable

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from dolfinx.fem.petsc import apply_lifting, assemble_matrix, assemble_vector, set_bc
from dolfinx.plot import vtk_mesh
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fields.invariants import principal, von_mises
from fenics_nnm.fields.recovery import StressRecovery, field_mesh, stress_recovery

YOUNG, POISSON = 2.1e11, 0.3
MU = YOUNG / (2 * (1 + POISSON))
LAMBDA = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))

SHAPES = {
    "triangles": (2, dmesh.CellType.triangle),
    "quadrilaterals": (2, dmesh.CellType.quadrilateral),
    "tetrahedra": (3, dmesh.CellType.tetrahedron),
    "hexahedra": (3, dmesh.CellType.hexahedron),
}


def uneven_mesh(shape: str, n: int) -> dmesh.Mesh:
    """Unit square or cube with inner nodes moved at random by up to a fifth of a cell."""
    dim, cell = SHAPES[shape]
    if dim == 2:
        mesh = dmesh.create_unit_square(MPI.COMM_SELF, n, n, cell)
    else:
        mesh = dmesh.create_unit_cube(MPI.COMM_SELF, n, n, n, cell)
    x = mesh.geometry.x
    inner = np.all((x[:, :dim] > 1e-9) & (x[:, :dim] < 1 - 1e-9), axis=1)
    moves = np.random.default_rng(1).uniform(-0.2 / n, 0.2 / n, (inner.sum(), dim))
    x[inner, :dim] += moves
    return mesh


def isotropic(dim: int) -> Array:
    """Hooke's law (plane strain in 2-D) from strains to XX YY ZZ XY YZ XZ."""
    law = np.zeros((6, 6))
    law[:3, :3] = LAMBDA
    law[np.arange(3), np.arange(3)] += 2 * MU
    law[np.arange(3, 6), np.arange(3, 6)] = MU
    return law[:, [0, 1, 3]] if dim == 2 else law


def recovery_on(space: fem.FunctionSpace, region: Array | None = None) -> StressRecovery:
    listed, types, points = vtk_mesh(space)
    cells = listed.reshape(-1, listed[0] + 1)[:, 1:].astype(np.int64)
    regions = np.zeros(len(cells), dtype=np.int64) if region is None else region
    mesh = field_mesh(points, cells, int(types[0]), regions)
    law = isotropic(mesh.cell.dim)
    return stress_recovery(mesh, law[None], np.zeros((len(cells), len(mesh.cell.samples)), int))


def at_nodes(recovery: StressRecovery, u: fem.Function) -> Array:
    dim = recovery.mesh.cell.dim
    return recovery.at_nodes(u.x.array.reshape(-1, dim)[recovery.mesh.origin])


def field(x: ufl.SpatialCoordinate | Array, lib: object) -> list[object]:
    """The manufactured displacement, of UFL or of numpy."""
    sin, cos = lib.sin, lib.cos  # type: ignore[attr-defined]
    if len(x) == 2:
        return [sin(2 * x[0] + x[1]), cos(1.5 * x[0] - x[1])]
    return [sin(2 * x[0] + x[1] - x[2]), cos(1.5 * x[0] - x[1]), sin(x[2] + x[0]) * cos(x[1])]


def exact_stress(places: Array, dim: int) -> Array:
    """Its stress by central differences, relative error 1e-9."""
    h, x = 1e-5, places[:, :dim].T
    gradient = np.empty((len(places), dim, dim))
    for j in range(dim):
        step = np.zeros((dim, 1))
        step[j] = h
        change = np.array(field(x + step, np)) - np.array(field(x - step, np))
        gradient[:, :, j] = change.T / (2 * h)
    pairs = ((0, 1), (1, 2), (0, 2))[: 1 if dim == 2 else 3]
    strains = [gradient[:, i, i] for i in range(dim)]
    strains += [gradient[:, i, j] + gradient[:, j, i] for i, j in pairs]
    return np.stack(strains, axis=1) @ isotropic(dim).T


def solved(energy: object, load: object, clamp: object, space: object) -> fem.Function:
    """Solution of a(u, v) = L(v), for which dolfinx's own class asks for more from 0.10 on."""
    form, solution = fem.form(energy), fem.Function(space)
    A, b = assemble_matrix(form, [clamp]), assemble_vector(fem.form(load))
    A.assemble()
    apply_lifting(b, [form], [[clamp]])
    set_bc(b, [clamp])
    solver, x = PETSc.KSP().create(A.comm), b.duplicate()
    solver.setOperators(A)
    solver.setType("preonly")
    solver.getPC().setType("lu")
    solver.getPC().setFactorSolverType("mumps")
    solver.solve(b, x)
    solution.x.array[:] = x.array
    return solution


def relative_error(shape: str, degree: int, n: int) -> float:
    """Root mean square error of the nodal stress of the finite element solution."""
    mesh = uneven_mesh(shape, n)
    dim = SHAPES[shape][0]
    space = fem.functionspace(mesh, ("Lagrange", degree, (dim,)))
    exact = ufl.as_vector(field(ufl.SpatialCoordinate(mesh), ufl))

    def sigma(u: object) -> object:
        eps = ufl.sym(ufl.grad(u))
        return LAMBDA * ufl.tr(eps) * ufl.Identity(dim) + 2 * MU * eps

    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    held = fem.Function(space)
    held.interpolate(lambda x: np.array(field(x[:dim], np)))
    left = dmesh.locate_entities_boundary(mesh, dim - 1, lambda x: np.isclose(x[0], 0))
    clamp = fem.dirichletbc(held, fem.locate_dofs_topological(space, dim - 1, left))
    traction = ufl.inner(sigma(exact) * ufl.FacetNormal(mesh), v) * ufl.ds
    load = traction - ufl.inner(ufl.div(sigma(exact)), v) * ufl.dx
    energy = ufl.inner(sigma(u), ufl.sym(ufl.grad(v))) * ufl.dx
    solution = solved(energy, load, clamp, space)
    recovery = recovery_on(space)
    wanted = exact_stress(recovery.mesh.nodes, dim)
    difference = at_nodes(recovery, solution) - wanted
    return float(np.sqrt((difference**2).mean() / (wanted**2).mean()))


@pytest.mark.parametrize(
    ("shape", "degree", "coarse", "fine", "rate", "largest"),
    [
        ("triangles", 1, 8, 16, 1.2, 0.02),
        ("triangles", 2, 8, 16, 2.6, 0.0004),
        ("quadrilaterals", 1, 8, 16, 1.6, 0.013),
        ("quadrilaterals", 2, 8, 16, 2.8, 0.0004),
        ("tetrahedra", 1, 4, 8, 1.1, 0.08),
        ("tetrahedra", 2, 3, 6, 2.3, 0.005),
        ("hexahedra", 1, 4, 8, 1.8, 0.03),
        ("hexahedra", 2, 2, 4, 2.8, 0.02),
    ],
)
def test_nodal_stress_converges(
    shape: str, degree: int, coarse: int, fine: int, rate: float, largest: float
) -> None:
    first, second = (relative_error(shape, degree, n) for n in (coarse, fine))
    assert second < largest
    assert np.log(first / second) / np.log(fine / coarse) > rate


def interpolated(space: fem.FunctionSpace, value: Callable[[Array], Array]) -> fem.Function:
    u = fem.Function(space)
    u.interpolate(value)
    return u


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("degree", [1, 2])
def test_linear_displacement_has_its_constant_stress(shape: str, degree: int) -> None:
    mesh = uneven_mesh(shape, 3)
    dim = SHAPES[shape][0]
    gradient = np.arange(1.0, 1 + dim * dim).reshape(dim, dim) * 1e-4
    space = fem.functionspace(mesh, ("Lagrange", degree, (dim,)))
    recovery = recovery_on(space)
    found = at_nodes(recovery, interpolated(space, lambda x: gradient @ x[:dim]))
    pairs = ((0, 1), (1, 2), (0, 2))[: 1 if dim == 2 else 3]
    strains = [*np.diag(gradient), *(gradient[i, j] + gradient[j, i] for i, j in pairs)]
    wanted = isotropic(dim) @ np.array(strains)
    np.testing.assert_allclose(found, np.broadcast_to(wanted, found.shape), rtol=1e-8, atol=1.0)


def test_bending_of_one_layer_of_cells_is_linear_over_the_depth() -> None:
    """A row of quadratic cells has two Gauss points over its depth, enough for a straight line."""
    mesh = dmesh.create_rectangle(
        MPI.COMM_SELF, [[0.0, 0.0], [4.0, 1.0]], [4, 1], dmesh.CellType.quadrilateral
    )
    space = fem.functionspace(mesh, ("Lagrange", 2, (2,)))
    recovery = recovery_on(space)
    bent = interpolated(space, lambda x: np.array([-1e-4 * x[0] * x[1], 5e-5 * x[0] ** 2]))
    stress = at_nodes(recovery, bent)
    strain = -1e-4 * recovery.mesh.nodes[:, 1]
    np.testing.assert_allclose(stress[:, 0], (LAMBDA + 2 * MU) * strain, rtol=1e-6, atol=10.0)


def test_stress_jumps_where_materials_meet() -> None:
    """Two halves of a bar under the same stress have different strains; none is averaged."""
    mesh = dmesh.create_unit_square(MPI.COMM_SELF, 8, 4)
    space = fem.functionspace(mesh, ("Lagrange", 2, (2,)))
    listed, types, points = vtk_mesh(space)
    cells = listed.reshape(-1, listed[0] + 1)[:, 1:].astype(np.int64)
    soft = (points[cells[:, :3], 0].mean(axis=1) > 0.5).astype(np.int64)
    body = field_mesh(points, cells, int(types[0]), soft)
    law = isotropic(2)
    rows = np.repeat(soft[:, None], 3, axis=1)
    recovery = stress_recovery(body, np.stack([law, law / 4]), rows)
    stretched = interpolated(space, lambda x: np.array([1e-3 * x[0], 0 * x[0]]))
    stress = at_nodes(recovery, stretched)
    assert len(body.nodes) == len(points) + 9  # those on the line x = 1/2 are there twice
    stiff = 1e-3 * (LAMBDA + 2 * MU)
    of_node = np.zeros(len(body.nodes), dtype=np.int64)
    of_node[body.cells] = soft[:, None]
    np.testing.assert_allclose(stress[:, 0], np.where(of_node == 1, stiff / 4, stiff), rtol=1e-8)


def test_von_mises_of_known_states() -> None:
    assert von_mises(np.array([2e8, 0, 0, 0, 0, 0])) == pytest.approx(2e8)
    assert von_mises(np.array([-2e8, 0, 0, 0, 0, 0])) == pytest.approx(2e8)
    assert von_mises(np.array([5e7, 5e7, 5e7, 0, 0, 0])) == 0
    assert von_mises(np.array([0, 0, 0, 0, 1e8, 0])) == pytest.approx(np.sqrt(3) * 1e8)


def test_principal_stresses_are_roots_of_the_characteristic_polynomial() -> None:
    stress = np.random.default_rng(2).normal(size=(20, 6))
    found = principal(stress)
    assert np.all(np.diff(found, axis=1) <= 0)
    xx, yy, zz, xy, yz, xz = stress.T
    first, third = xx + yy + zz, xx * yy * zz + 2 * xy * yz * xz
    third -= xx * yz**2 + yy * xz**2 + zz * xy**2
    second = xx * yy + yy * zz + zz * xx - xy**2 - yz**2 - xz**2
    for root in found.T:
        np.testing.assert_allclose(
            root**3 - first * root**2 + second * root - third, 0, atol=1e-12 * 100
        )
    a, b, c = found.T
    np.testing.assert_allclose(
        von_mises(stress), np.sqrt(((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2) / 2)
    )
