"""Prisms, pyramids, shrunken hexahedra and mixed meshes become simplices of the same body."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from cell_boxes import CUBE, WEDGES, box
from mpi4py import MPI

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cell_shapes import facet_table, shape_of, signed_volumes
from fenics_nnm.fem.foreign_body import one_body
from fenics_nnm.fem.foreign_mesh import ForeignMesh, raw_mesh
from fenics_nnm.fem.gmsh_mesh import gmsh_session
from fenics_nnm.fem.mesh import TaggedMesh, spread_mesh
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, assemble_solid
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material

KINDS: dict[str, Callable[[int], str]] = {
    "wedges": lambda number: "wedge",
    "pyramids": lambda number: "pyramid",
    "hexahedra and wedges": lambda number: ("hexahedron", "wedge")[number % 2],
    "hexahedra and pyramids": lambda number: ("hexahedron", "pyramid")[number % 2],
    "all": lambda number: ("hexahedron", "wedge", "pyramid")[number % 3],
}


def skewed(x: np.ndarray) -> np.ndarray:
    return x @ np.array([[2.0, 0.3, 0.1], [0.0, 1.0, 0.2], [0.1, 0.0, 1.5]])


def bent(x: np.ndarray) -> np.ndarray:
    """A quarter of a thick tube between the radii 1 and 2, 1 long: volume 3 pi / 4."""
    r, angle = 1 + x[:, 1], np.pi / 2 * x[:, 0]
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), x[:, 2]])


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_volume_and_surface_stay_and_all_facets_fit(kind: str, order: int) -> None:
    foreign = box((3, 2, 2), KINDS[kind], skewed, order)
    found = one_body("test", foreign)
    ((name, cells),) = found.cells.items()
    assert name == ("tetra" if order == 1 else "tetra10")
    volume = abs(np.linalg.det(skewed(np.eye(3))))
    volumes = signed_volumes(found.points, cells)
    assert abs(volumes.sum()) == pytest.approx(volume, rel=1e-12)
    assert np.abs(volumes).sum() == pytest.approx(volume, rel=1e-12)  # none is turned over
    table = facet_table({name: cells})
    assert set(table.times) == {1, 2}
    assert len(table.outer) == 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2)
    if order == 2:  # all edges are straight here
        edges = np.array(shape_of("tetra").edges)
        middles = found.points[cells[:, edges]].mean(axis=2)
        np.testing.assert_allclose(found.points[cells[:, 4:]], middles, atol=1e-12)
    counts = {
        name: len(rows[found_kind]) for name, rows in found.sets.items() for found_kind in rows
    }
    assert sum(counts.values()) == len(cells)
    assert "are split into" in found.notes[-1]


@pytest.mark.parametrize("kind", KINDS)
def test_curved_volume_converges_with_the_fourth_power(kind: str) -> None:
    errors = []
    for n in (2, 4):
        tagged = spread(box((n, n, 1), KINDS[kind], bent, 2))
        errors.append(abs(mass_of(tagged, 1) / (3 * np.pi / 4) - 1))
    assert errors[1] < 2e-4 and errors[0] / errors[1] > 10, errors


def spread(foreign: ForeignMesh) -> TaggedMesh:
    def read() -> Any:
        with gmsh_session("test"):
            return raw_mesh("test", one_body("test", foreign))

    return spread_mesh(read, 1.0, MPI.COMM_SELF)


def solid_of(tagged: TaggedMesh, degree: int, clamp: str | None = None) -> Any:
    material = Material(Isotropic(2.1e11, 0.3), 7850.0)
    facets = tagged.facets[clamp] if clamp else np.empty(0, dtype=np.int32)
    return assemble_solid(tagged, Body("solid", (Region(material),), degree=degree), facets)


def mass_of(tagged: TaggedMesh, degree: int) -> float:
    """Volume, from the mass of a motion along x."""
    mass = solid_of(tagged, degree).mass
    along = mass.createVecRight()
    along.array[:] = 0.0
    along.array[::3] = 1.0
    return float(along.dot(mass * along)) / 7850.0


def bar(x: np.ndarray) -> np.ndarray:
    return x * [0.2, 0.02, 0.01]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_modes_are_those_of_hexahedra(kind: str, order: int) -> None:
    """Of a slender beam, with quadratic displacements; the finer mesh is nearer."""
    apart = []
    for n in ((6, 2, 1), (12, 2, 2)):
        own, hexahedra = (
            frequencies(spread(box(n, kinds, bar, order)))
            for kinds in (KINDS[kind], lambda number: "hexahedron")
        )
        apart.append(float(np.abs(own / hexahedra - 1).max()))
    assert apart[0] < 0.025 and apart[1] < 0.005 and apart[1] < apart[0], apart


def frequencies(tagged: TaggedMesh) -> np.ndarray:
    with DirectModalSolver(solid_of(tagged, 2, "low")) as solver:
        return np.asarray(solver.modes(3).frequencies)


#: Places of the corners of a hexahedron that fall together, and the volume that is left.
SHRUNK = {
    "prism": ([0, 1, 2, 2, 4, 5, 6, 6], 1 / 2),
    "pyramid": ([0, 1, 2, 3, 4, 4, 4, 4], 1 / 3),
    "tetrahedron": ([0, 1, 2, 2, 4, 4, 4, 4], 1 / 6),
}


@pytest.mark.parametrize("shape", SHRUNK)
@pytest.mark.parametrize("order", [1, 2])
def test_hexahedra_with_nodes_that_stand_twice(shape: str, order: int) -> None:
    """As Ansys writes prisms, pyramids and tetrahedra."""
    places, volume = SHRUNK[shape]
    nodes = list(places)
    points = list(CUBE)
    known: dict[tuple[int, int], int] = {}
    for a, b in shape_of("hexahedron").edges if order == 2 else ():
        ends = min(places[a], places[b]), max(places[a], places[b])
        if ends[0] == ends[1]:
            nodes.append(ends[0])
            continue
        if ends not in known:
            known[ends] = len(points)
            points.append((CUBE[ends[0]] + CUBE[ends[1]]) / 2)
        nodes.append(known[ends])
    kind = "hexahedron" if order == 1 else "hexahedron20"
    found = one_body("test", ForeignMesh(np.array(points), {kind: np.array([nodes])}))
    ((_, cells),) = found.cells.items()
    assert abs(signed_volumes(found.points, cells).sum()) == pytest.approx(volume)
    if order == 2:
        middles = found.points[cells[:, np.array(shape_of("tetra").edges)]].mean(axis=2)
        np.testing.assert_allclose(found.points[cells[:, 4:]], middles, atol=1e-12)


def test_orders_that_do_not_fit_are_refused() -> None:
    linear, quadratic = (box((1, 1, 1), KINDS["wedges"], skewed, order) for order in (1, 2))
    cells = {**quadratic.cells, "hexahedron": np.arange(8)[None] + len(quadratic.points)}
    points = np.concatenate([quadratic.points, CUBE + 5])
    assert linear.cells
    with pytest.raises(MeshError, match="1 elements of order 1 and 2 of order 2"):
        one_body("test", ForeignMesh(points, cells))


def test_quadrangle_on_two_triangles_is_refused_where_it_would_crack() -> None:
    """A hexahedron on two prisms, whose diagonal is not that of the hexahedron's split."""
    points = np.concatenate([CUBE, CUBE[4:] + np.array([0, 0, 1])])
    above = {"hexahedron": np.array([[4, 5, 6, 7, 8, 9, 10, 11]])}
    fits = ForeignMesh(points, {**above, "wedge": np.array(WEDGES)})
    one_body("test", fits)
    turned = np.array([[1, 2, 3, 5, 6, 7], [1, 3, 0, 5, 7, 4]])
    with pytest.raises(MeshError, match=r"1 quadrangles meet two triangles .* elements 1 and 1"):
        one_body("test", ForeignMesh(points, {**above, "wedge": turned}))


def test_folded_prism_is_refused_by_its_number() -> None:
    points = CUBE.copy()
    points[[6, 5]] = points[[5, 6]]
    foreign = ForeignMesh(points, {"wedge": np.array(WEDGES)}, numbers={"wedge": np.array([7, 9])})
    with pytest.raises(MeshError, match=r"degenerate elements .* number 7"):
        one_body("test", foreign)


def test_plane_mesh_of_triangles_and_quadrangles() -> None:
    points = np.array([(x, y, 0.0) for y in (0.0, 1.0) for x in (0.0, 1.0, 2.0)])
    cells = {"quad": np.array([[0, 1, 4, 3]]), "triangle": np.array([[1, 2, 4], [2, 5, 4]])}
    sets = {"end": {"line": np.array([0])}}
    found = one_body("test", ForeignMesh(points, {**cells, "line": np.array([[0, 3]])}, sets))
    assert {kind: len(rows) for kind, rows in found.cells.items()} == {"triangle": 4}
    np.testing.assert_array_equal(np.sort(found.facets["end"]), [[0, 3]])


def test_sides_of_prisms_carry_over() -> None:
    """Areas of the groups of a split mesh, from sets of nodes."""
    from fenics_nnm.fem.boundary import boundary

    tagged = spread(box((2, 2, 2), KINDS["all"], bar, 2))
    surface = boundary(tagged.mesh)
    for name, x in (("low", 0.0), ("high", 0.2)):
        chosen = surface.mask(tagged.facets[name]) != 0
        assert surface.areas[chosen].sum() == pytest.approx(2e-4)
        np.testing.assert_allclose(surface.centres[chosen][:, 0], x, atol=1e-12)
        assert len(tagged.nodes[name]) == len(np.unique(surface_nodes(tagged, name, x)))


def surface_nodes(tagged: TaggedMesh, name: str, x: float) -> Any:
    return np.flatnonzero(np.abs(tagged.mesh.geometry.x[:, 0] - x) < 1e-12)
