"""Orthotropic bodies: stress, frequencies, and what does not depend on the axes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from fenics_nnm.fem.attachments import Attachment
from fenics_nnm.fem.mesh import TaggedMesh, generate_mesh
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, Solid, assemble_solid, stress_tensor
from fenics_nnm.geometry import Beam, Plate, Rod
from fenics_nnm.materials.elasticity import Isotropic, Orthotropic
from fenics_nnm.materials.material import Material
from fenics_nnm.materials.orientation import Axes, Cylindrical, Orientation, euler_axes

#: A made-up material without any equal constants.
WOOD = Orthotropic((12e9, 0.9e9, 0.5e9), (0.4, 0.6, 0.45), (0.8e9, 0.05e9, 0.7e9))
BEAM = Beam(length=1.0, width=0.15, height=0.1, elements=(3, 1, 1), cells="hexahedron")


def tagged_beam() -> TaggedMesh:
    return generate_mesh(BEAM, MPI.COMM_SELF)


def assembled(
    tagged: TaggedMesh, theory: Any, material: Material, *, clamp: str = "left", **options: Any
) -> Solid:
    clamped = tagged.facets_of((clamp,), "clamp.facets") if clamp else np.empty(0, dtype=np.int32)
    return assemble_solid(tagged, Body(theory, (Region(material),), **options), clamped)


def frequencies(solid: Solid, count: int) -> np.ndarray:
    with DirectModalSolver(solid) as solver:
        return solver.modes(count).frequencies


def wood(orientation: Orientation) -> Material:
    return Material(WOOD, 500.0, orientation)


def mean_stress(solid: Solid, gradient: np.ndarray) -> np.ndarray:
    """Mean stress of the displacement `gradient` x, over a unit volume of the mesh."""
    dim = solid.tagged.dim
    u = fem.Function(solid.space)
    u.interpolate(lambda x: gradient @ x[:dim])
    dx = ufl.Measure("dx", domain=solid.tagged.mesh)
    sigma = stress_tensor(u, solid)
    parts = [[fem.form(sigma[i, j] * dx) for j in range(3)] for i in range(3)]
    return np.array([[fem.assemble_scalar(part) for part in row] for row in parts])


def test_uniform_stress_off_axis_in_plane_stress() -> None:
    """Strains of stress along x alone, by the transformed compliance (Jones, Eq. 2.97)."""
    degrees, stress = 25.0, 3e6
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    (E1, E2, _), nu12, G12 = WOOD.young, WOOD.poisson[0], WOOD.shear[0]
    xx = c**4 / E1 + (1 / G12 - 2 * nu12 / E1) * s**2 * c**2 + s**4 / E2
    xy = (1 / E1 + 1 / E2 - 1 / G12) * s**2 * c**2 - nu12 / E1 * (s**4 + c**4)
    shear = (2 / E1 + 2 * nu12 / E1 - 1 / G12) * s * c**3
    shear -= (2 / E2 + 2 * nu12 / E1 - 1 / G12) * s**3 * c
    gradient = stress * np.array([[xx, shear], [0.0, xy]])
    square = generate_mesh(Plate(length=1.0, height=1.0, elements=(1, 1)), MPI.COMM_SELF)
    solid = assembled(square, "plane-stress", wood(euler_axes((degrees, 0.0, 0.0))), extent=0.01)
    np.testing.assert_allclose(
        mean_stress(solid, gradient), np.diag([stress, 0, 0]), atol=1e-9 * stress
    )


def test_plane_strain_has_the_stress_that_keeps_the_thickness() -> None:
    square = generate_mesh(Plate(length=1.0, height=1.0, elements=(1, 1)), MPI.COMM_SELF)
    turned = euler_axes((25.0, 0.0, 0.0))
    solid = assembled(square, "plane-strain", wood(turned))
    sigma = mean_stress(solid, np.array([[1e-3, 2e-3], [0.0, -3e-3]]))
    local = turned.matrix @ sigma @ turned.matrix.T
    components = local[[0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    assert (WOOD.compliance @ components)[2] == pytest.approx(0.0, abs=1e-15)
    assert abs(sigma[2, 2]) > 1e5


def test_rod_along_an_axis_that_is_no_material_axis() -> None:
    """Frequencies (2 n - 1) / 4 sqrt(Ex / rho) / L, with Ex off axis."""
    c, s = np.cos(np.radians(40.0)), np.sin(np.radians(40.0))
    (E1, E2, _), nu12, G12 = WOOD.young, WOOD.poisson[0], WOOD.shear[0]
    Ex = 1 / (c**4 / E1 + (1 / G12 - 2 * nu12 / E1) * s**2 * c**2 + s**4 / E2)
    rod = generate_mesh(Rod(length=1.0, elements=20), MPI.COMM_SELF)
    solid = assembled(rod, "rod", wood(euler_axes((40.0, 0.0, 0.0))), extent=1e-4)
    exact = np.array([1, 3]) / 4 * np.sqrt(Ex / 500.0)
    np.testing.assert_allclose(frequencies(solid, 2), exact, rtol=1e-5)


def test_turning_body_and_material_together_changes_no_frequency() -> None:
    reference = frequencies(assembled(tagged_beam(), "solid", wood(Axes())), 5)
    turn = euler_axes((20.0, 50.0, 70.0)).matrix.T
    turned = tagged_beam()
    turned.mesh.geometry.x[:] = turned.mesh.geometry.x @ turn.T
    axes = Axes(tuple(turn[:, 0]), tuple(turn[:, 1]))
    together = frequencies(assembled(turned, "solid", wood(axes)), 5)
    np.testing.assert_allclose(together, reference, rtol=1e-9)
    body_alone = frequencies(assembled(turned, "solid", wood(Axes())), 5)
    assert abs(body_alone[0] / reference[0] - 1) > 0.1


@pytest.mark.parametrize(
    "orientation", [Axes((1.0, 2.0, 3.0)), Cylindrical((1.0, 1.0, 0.0), (0.0, 9.0, 9.0))]
)
def test_isotropic_constants_are_the_same_in_all_axes(orientation: Orientation) -> None:
    E, nu = 2.1e11, 0.3
    G = E / (2 * (1 + nu))
    law = Orthotropic((E, E, E), (nu, nu, nu), (G, G, G))
    plain = assembled(tagged_beam(), "solid", Material(Isotropic(E, nu), 7800.0))
    turned = assembled(tagged_beam(), "solid", Material(law, 7800.0, orientation))
    np.testing.assert_allclose(frequencies(turned, 5), frequencies(plain, 5), rtol=1e-9)


@pytest.mark.parametrize("theory", ["plane-stress", "plane-strain", "solid"])
def test_stress_of_a_growing_cylinder_in_its_own_axes(theory: Any) -> None:
    """u = r^2 e_r has the strains 2 r and r along e_r and e_theta, and no shear."""
    if theory == "solid":
        tagged = tagged_beam()
    else:
        tagged = generate_mesh(Plate(length=1.0, height=0.25, elements=(4, 1)), MPI.COMM_SELF)
    origin = (-1.0, -2.0, 0.0)
    solid = assembled(tagged, theory, wood(Cylindrical((0.0, 0.0, 1.0), origin)))
    x = ufl.SpatialCoordinate(tagged.mesh)
    away = ufl.as_vector([x[0] - origin[0], x[1] - origin[1], 0.0][: tagged.dim])
    r = ufl.sqrt(ufl.dot(away, away))
    sigma = stress_tensor(r * away, solid)
    matrix = WOOD.stiffness
    free = theory == "plane-stress"  # sigma_33 = 0
    thickness = matrix[2, :2] @ [2.0, 1.0] / matrix[2, 2] if free else 0.0
    along = matrix[:3, :3] @ [2.0, 1.0, -thickness]
    e_r = ufl.as_vector([away[0] / r, away[1] / r, 0.0])
    e_t = ufl.as_vector([-away[1] / r, away[0] / r, 0.0])
    e_z = ufl.as_vector([0.0, 0.0, 1.0])
    expected = sum(
        float(value) * r * ufl.outer(e, e) for value, e in zip(along, (e_r, e_t, e_z), strict=True)
    )
    dx = ufl.Measure("dx", domain=tagged.mesh, metadata={"quadrature_degree": 6})
    difference = fem.assemble_scalar(fem.form(ufl.inner(sigma - expected, sigma - expected) * dx))
    size = fem.assemble_scalar(fem.form(ufl.inner(expected, expected) * dx))
    assert size > 0 and difference < 1e-24 * size


def test_simply_supported_orthotropic_plate() -> None:
    """Navier's frequencies of a specially orthotropic thin plate (Jones, Eq. 5.36).

    Stiff springs along the edges hold them across the plate and along themselves.
    """
    h, rho = 0.01, 1500.0
    law = Orthotropic((40e9, 10e9, 10e9), (0.25, 0.25, 0.25), (5e9, 5e9, 5e9))
    (E1, E2, _), nu12, G12 = law.young, law.poisson[0], law.shear[0]
    factor = h**3 / 12 / (1 - nu12**2 * E2 / E1)
    D11, D22, D12, D66 = E1 * factor, E2 * factor, nu12 * E2 * factor, G12 * h**3 / 12
    a, b = 1.0, 0.8

    def exact(m: int, n: int) -> float:
        x, y = (m * np.pi / a) ** 2, (n * np.pi / b) ** 2
        bending = D11 * x**2 + 2 * (D12 + 2 * D66) * x * y + D22 * y**2
        return float(np.sqrt(bending / (rho * h)) / (2 * np.pi))

    tagged = generate_mesh(
        Beam(length=a, width=b, height=h, elements=(20, 16, 1), cells="hexahedron"), MPI.COMM_SELF
    )
    stiff = 1e14
    held = tuple(
        Attachment(f"spring[{names[0]}]", "spring", values, facets=names, per_area=True)
        for names, values in (
            (("left", "right"), (0.0, stiff, stiff)),
            (("front", "back"), (stiff, 0.0, stiff)),
        )
    )
    solid = assembled(tagged, "solid", Material(law, rho), clamp="", attachments=held)
    expected = sorted(exact(m, n) for m in (1, 2, 3) for n in (1, 2, 3))[:4]
    np.testing.assert_allclose(frequencies(solid, 4), expected, rtol=5e-3)


def test_orientation_is_without_effect_on_an_isotropic_law() -> None:
    steel = Material(Isotropic(2.1e11, 0.3), 7800.0)
    turned = replace(steel, orientation=Cylindrical((1.0, 0.0, 0.0)))
    one, other = (frequencies(assembled(tagged_beam(), "solid", m), 2) for m in (steel, turned))
    np.testing.assert_array_equal(one, other)
