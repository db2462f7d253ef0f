"""Contact points: areas, directions, spreading."""

from pathlib import Path

import gmsh
import numpy as np
import pytest
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.contact import ContactInterface, contact_interface
from fenics_nnm.fem.direction import Direction
from fenics_nnm.fem.mesh import TaggedMesh, generate_mesh, read_mesh
from fenics_nnm.fem.patch_sites import Patch
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, assemble_solid
from fenics_nnm.geometry import Beam, Plate
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material

UNIT = (Region(Material(Isotropic(1.0, 0.3), 1.0)),)
SOLID = Body("solid", UNIT, degree=2)


def interface(
    tagged: TaggedMesh,
    body: Body,
    clamp: str,
    contact: str,
    direction: Direction,
    count: int | None,
) -> ContactInterface:
    solid = assemble_solid(tagged, body, tagged.facets_of((clamp,), "clamp.facets"))
    return contact_interface(solid, [patch(tagged, contact, direction, count)])


def patch(tagged: TaggedMesh, name: str, direction: Direction, count: int | None) -> Patch:
    facets = tagged.facets_of((name,), "contact.facets")
    return Patch("contact", name, facets, name, direction.at, gap, count)


def gap(points: Array, directions: Array) -> Array:
    return np.full(len(points), 1e-3)


@pytest.mark.parametrize("count", [None, 5])
@pytest.mark.parametrize("cells", ["tetrahedron", "hexahedron"])
def test_tributary_areas_add_up_to_the_face(cells: str, count: int | None) -> None:
    beam = Beam(length=1.0, width=0.2, height=0.1, elements=(6, 4, 3), cells=cells)
    found = interface(
        generate_mesh(beam, MPI.COMM_SELF), SOLID, "left", "right", Direction("normal"), count
    )
    assert found.count == (count or 5 * 4)
    assert found.areas.sum() == pytest.approx(0.02, rel=1e-12)
    assert found.areas.min() > 0


def test_plane_areas_hold_the_thickness() -> None:
    plate = Plate(length=1.0, height=0.2, elements=(8, 4))
    body = Body("plane-stress", UNIT, extent=0.05, degree=2)
    found = interface(
        generate_mesh(plate, MPI.COMM_SELF), body, "left", "right", Direction("normal"), None
    )
    assert found.areas.sum() == pytest.approx(0.2 * 0.05)
    np.testing.assert_allclose(found.directions, [[1.0, 0.0]] * 5, atol=1e-14)


def annulus(folder: Path) -> Path:
    """A thick ring of radii 1 and 2 in the plane, in millimetres."""
    gmsh.initialize(["-noenv"], interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    outer, inner = gmsh.model.occ.addDisk(0, 0, 0, 2, 2), gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
    (ring,), _ = gmsh.model.occ.cut([(2, outer)], [(2, inner)])
    gmsh.model.occ.synchronize()
    curves = {
        round(gmsh.model.occ.getMass(1, tag) / (2 * np.pi)): tag
        for _, tag in gmsh.model.getEntities(1)
    }
    gmsh.model.addPhysicalGroup(2, [ring[1]], name="body")
    gmsh.model.addPhysicalGroup(1, [curves[1]], name="bore")
    gmsh.model.addPhysicalGroup(1, [curves[2]], name="rim")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.15)
    gmsh.model.mesh.generate(2)
    path = folder / "annulus.msh"
    gmsh.write(str(path))
    gmsh.finalize()
    return path


def test_normal_and_radial_directions_of_a_ring(tmp_path: Path) -> None:
    tagged = read_mesh(annulus(tmp_path), "mm", MPI.COMM_SELF)
    body = Body("plane-strain", UNIT, extent=1e-3, degree=2)
    normal = interface(tagged, body, "bore", "rim", Direction("normal"), None)
    radial = interface(tagged, body, "bore", "rim", Direction("radial", (), (0.0, 0.0)), None)
    vector = interface(tagged, body, "bore", "rim", Direction("vector", (1.0, 1.0)), 7)
    outward = normal.points / np.linalg.norm(normal.points, axis=1)[:, None]
    np.testing.assert_allclose(np.linalg.norm(normal.points, axis=1), 2e-3, rtol=1e-9)
    assert np.sum(normal.directions * outward, axis=1).min() > 0.999
    np.testing.assert_allclose(radial.directions, outward, atol=1e-12)
    np.testing.assert_allclose(vector.directions, [[0.5**0.5] * 2] * 7)
    assert normal.areas.sum() == pytest.approx(2 * np.pi * 2e-3 * 1e-3, rel=1e-3)


def test_radial_direction_leaves_out_the_axis() -> None:
    direction = Direction("radial", (2.0, 0.0, 0.0), (5.0, 1.0, 0.0))
    found = direction.at(np.array([[9.0, 4.0, 4.0]]), np.zeros((1, 3)))
    np.testing.assert_allclose(found, [[0.0, 0.6, 0.8]])


def test_radial_direction_on_the_axis_is_refused() -> None:
    with pytest.raises(ModelError, match="is not defined at"):
        Direction("radial", (1.0, 0.0, 0.0), (0.0,) * 3).at(
            np.array([[1.0, 0, 0]]), np.zeros((1, 3))
        )


def test_displacement_and_unit_forces_are_transposes() -> None:
    beam = Beam(length=1.0, width=0.2, height=0.1, elements=(4, 2, 2))
    tagged = generate_mesh(beam, MPI.COMM_SELF)
    solid = assemble_solid(tagged, SOLID, tagged.facets_of(("left",), "clamp.facets"))
    found = contact_interface(
        solid, [patch(tagged, "right", Direction("vector", (1.0, 2.0, 3.0)), 4)]
    )
    motion = np.random.default_rng(2).normal(size=(solid.owned, 3))
    np.testing.assert_allclose(
        found.displacement(motion), found.unit_forces(solid.owned).T @ motion
    )
