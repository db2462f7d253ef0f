"""The stress tensor of a displacement, against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from fenics_nnm.fem.mesh import generate_mesh
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, Solid, assemble_solid, stress_tensor
from fenics_nnm.geometry import Beam, Plate, Rod
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material

YOUNG, POISSON = 2.0e11, 0.3
MESHES: dict[str, Any] = {
    "rod": Rod(model="rod", length=1.0, elements=2),
    "plane-stress": Plate(model="plate", length=1.0, height=1.0, elements=(2, 2)),
    "plane-strain": Plate(model="plate", length=1.0, height=1.0, elements=(2, 2)),
    "solid": Beam(model="beam", length=1.0, width=1.0, height=1.0, elements=(1, 1, 1)),
}


def body_of(theory: Any) -> Solid:
    tagged = generate_mesh(MESHES[theory], MPI.COMM_SELF)
    steel = Material(Isotropic(YOUNG, POISSON), 7800.0)
    body = Body(theory, (Region(steel),), extent=0.02)
    return assemble_solid(tagged, body, tagged.facets_of(("left",), "clamp.facets"))


def stress_under(solid: Solid, gradient: np.ndarray) -> np.ndarray:
    """Mean stress of the displacement `gradient` x."""
    dim = solid.tagged.dim
    u = fem.Function(solid.space)
    u.interpolate(lambda x: gradient[:dim, :dim] @ x[:dim])
    sigma = stress_tensor(u, solid)
    dx = ufl.Measure("dx", domain=solid.tagged.mesh)
    parts = [[fem.form(sigma[i, j] * dx) for j in range(3)] for i in range(3)]
    return np.array([[fem.assemble_scalar(part) for part in row] for row in parts])


@pytest.mark.parametrize(
    ("theory", "strain_zz"), [("plane-strain", 0.0), ("plane-stress", -2.1e-3), ("solid", 4e-4)]
)
def test_stress_obeys_hooke_in_three_dimensions(theory: str, strain_zz: float) -> None:
    """The strain comes back from the stress: strain = ((1 + nu) sigma - nu tr(sigma) I) / E."""
    gradient = np.array([[1e-3, 2e-4, 0.0], [4e-4, 3.9e-3, 0.0], [0.0, 0.0, 4e-4]])
    sigma = stress_under(body_of(theory), gradient)
    strain = ((1 + POISSON) * sigma - POISSON * np.trace(sigma) * np.eye(3)) / YOUNG
    # in plane stress eps_zz = -nu / (1 - nu) (eps_xx + eps_yy)
    expected = np.array([[1e-3, 3e-4, 0.0], [3e-4, 3.9e-3, 0.0], [0.0, 0.0, strain_zz]])
    np.testing.assert_allclose(strain, expected, atol=1e-12)


def test_a_rod_has_the_stress_along_its_axis() -> None:
    sigma = stress_under(body_of("rod"), np.diag([1e-3, 0.0, 0.0]))
    np.testing.assert_allclose(sigma, np.diag([2e8, 0.0, 0.0]), rtol=1e-12)
