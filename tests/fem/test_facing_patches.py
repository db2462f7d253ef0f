"""Patches of one mesh that face each other: a tuning fork against half of it, and projection."""

from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from fork_mesh import SLIT, fork, fork_study
from mpi4py import MPI
from petsc4py import PETSc
from scipy import sparse
from small_meshes import QUADRANGLE, explicit, saved_model

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import follow
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.patch_vertices import PatchVertices
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.reduction.matrix_analysis import matrix_analysis
from fenics_nnm.structure.analysis import (
    harmonic_balance,
    linear_analysis,
    nonlinear_mode,
    wanted_motions,
)
from fenics_nnm.study import Study, study_from

CRAIG_BAMPTON = {"method": "craig-bampton", "modes": 8}


def analysed(folder: Path, values: dict[str, Any]) -> tuple[Study, LinearAnalysis]:
    study = study_from(values, folder / "study.toml")
    analysis = linear_analysis(study, MPI.COMM_SELF)
    assert isinstance(analysis, LinearAnalysis)
    return study, analysis


def matrix(of: PETSc.Mat) -> sparse.csr_array:
    rows, columns, values = of.getValuesCSR()
    return sparse.csr_array((values, columns, rows), shape=of.getSize())


def closing_motions(analysis: LinearAnalysis) -> sparse.csr_array:
    """Columns that move both halves of the fork alike, mirrored at x = 0, and are not clamped."""
    solid = analysis.solid
    places = solid.space.tabulate_dof_coordinates()[:, :2]
    keys = {tuple(np.round(place, 9) + 0.0): block for block, place in enumerate(places)}
    columns: list[tuple[list[int], list[float]]] = []
    for (x, y), block in keys.items():
        if 2 * block in solid.clamped or x < 0:
            continue
        mirror = keys[-x + 0.0, y]
        if x > 0:
            columns.append(([2 * block, 2 * mirror], [1.0, -1.0]))
            columns.append(([2 * block + 1, 2 * mirror + 1], [1.0, 1.0]))
        else:
            columns.append(([2 * block + 1], [1.0]))
    rows = np.concatenate([rows for rows, _ in columns])
    values = np.concatenate([values for _, values in columns])
    numbers = np.repeat(np.arange(len(columns)), [len(rows) for rows, _ in columns])
    return sparse.csr_array((values, (rows, numbers)), shape=(solid.owned, len(columns)))


@pytest.mark.parametrize("degree", [1, 2])
def test_closing_mode_is_that_of_half_the_fork_against_a_wall(degree: int, tmp_path: Path) -> None:
    """Half the gap, half the points' displacement: the wall is the plane of symmetry."""
    fork(tmp_path / "fork.msh")
    values = fork_study(tmp_path / "fork.msh")
    values["body"]["degree"] = degree
    study, analysis = analysed(tmp_path, values)
    np.testing.assert_allclose(analysis.interface.gap, SLIT, rtol=1e-12)
    branch = nonlinear_mode(study, analysis)
    assert branch.complete

    motions = closing_motions(analysis)
    K, M = matrix(analysis.solid.stiffness), matrix(analysis.solid.mass)
    wall = study_from(
        fork_study(tmp_path / "fork.msh", facets="left tine", direction=[1.0, 0.0], gap=SLIT / 2),
        tmp_path / "study.toml",
    )
    wall = wall.model_copy(update={"body": study.body})
    B = linear_analysis(wall, MPI.COMM_SELF).interface.unit_forces(analysis.solid.owned).T
    reaches = np.abs(analysis.model.Phi).max(axis=0)
    closing = int(np.count_nonzero(reaches > 1e-6 * reaches.max()))
    half = matrix_analysis(
        Matrices(motions.T @ K @ motions, motions.T @ M @ motions, B @ motions, SLIT / 2),
        modes=closing,
    )
    expected = follow(half.model, wanted_motions(study), harmonic_balance(study), mode=0)
    assert expected.complete and 3 <= closing <= 5
    assert expected.points[-1].frequency_ratio > 1.005
    assert len(branch.points) == len(expected.points) == 4
    for found, wanted in zip(branch.points, expected.points, strict=True):
        assert found.motion.frequency == pytest.approx(wanted.motion.frequency, rel=1e-8)
        assert found.motion.energy == pytest.approx(wanted.motion.energy, rel=1e-8)


def test_craig_bampton_keeps_the_relative_displacement(tmp_path: Path) -> None:
    """Static flexibility of the reduced model against the whole one, for any number of modes."""
    fork(tmp_path / "fork.msh")
    values = fork_study(tmp_path / "fork.msh")
    _, massless = analysed(tmp_path, values)
    whole = massless.model.Phi @ np.diag(massless.model.omega**-2.0) @ massless.model.Phi.T
    for interface in ("all", "contact"):
        values["reduction"] = {**CRAIG_BAMPTON, "interface": interface}
        model = analysed(tmp_path, values)[1].model
        flexibility = model.Phi @ np.diag(model.omega**-2.0) @ model.Phi.T
        np.testing.assert_allclose(flexibility, whole + massless.model.R, rtol=1e-7)
        assert model.omega[:2] == pytest.approx(massless.model.omega[:2], rel=1e-4)


def relative(analysis: LinearAnalysis, field: Any) -> Array:
    """Contact displacements of a field of x and y in m."""
    places = analysis.solid.space.tabulate_dof_coordinates()[:, :2]
    return analysis.interface.displacement(field(*places.T).T.reshape(-1, 1))[:, 0]


def two_blocks(path: Path, *, hexahedra: bool, order: int = 1) -> None:
    """Unit cubes 1 mm above each other, clamped at their far faces; the lower one is coarser."""
    with saved_model(path):
        occ = gmsh.model.occ
        boxes = [occ.addBox(0, 0, z, 1, 1, 1) for z in (0.0, 1.001)]
        occ.synchronize()
        for box, count in zip(boxes, (3, 4), strict=True):
            shell = gmsh.model.getBoundary([(3, box)], oriented=False)
            for _, line in gmsh.model.getBoundary(shell, combined=False, oriented=False):
                gmsh.model.mesh.setTransfiniteCurve(abs(line), count)
            for _, face in shell:
                gmsh.model.mesh.setTransfiniteSurface(face)
                if hexahedra:
                    gmsh.model.mesh.setRecombine(2, face)
            gmsh.model.mesh.setTransfiniteVolume(box)
        gmsh.model.addPhysicalGroup(3, boxes, name="body")
        for name, heights in {"far": (0.0, 2.001), "lower": (1.0,), "upper": (1.001,)}.items():
            faces = [
                tag
                for z in heights
                for _, tag in gmsh.model.getEntitiesInBoundingBox(
                    -1, -1, z - 1e-4, 2, 2, z + 1e-4, 2
                )
            ]
            gmsh.model.addPhysicalGroup(2, faces, name=name)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("hexahedra", [True, False])
@pytest.mark.parametrize("slanted", [[0.0, 0.0, 1.0], [0.1, 0.0, 1.0]])
def test_facing_faces_in_space(
    hexahedra: bool, slanted: list[float], order: int, tmp_path: Path
) -> None:
    """Quadratic fields are followed exactly between the nodes, along slanted lines too.

    Hexahedra of order 2 have facets of 9 nodes.
    """
    two_blocks(tmp_path / "blocks.msh", hexahedra=hexahedra, order=order)
    values = {
        **fork_study(tmp_path / "blocks.msh"),
        "body": {"theory": "solid", "degree": 2},
        "clamp": {"facets": "far"},
        "contact": {"facets": "lower", "against": "upper", "direction": slanted},
    }
    _, analysis = analysed(tmp_path, values)
    interface = analysis.interface
    shift = 1e-3 * slanted[0]
    count = 9 if shift == 0 else 6
    assert (interface.count, interface.left_out) == (count, (9 - count,))
    length = np.linalg.norm(slanted)
    np.testing.assert_allclose(interface.gap, 1e-3 * length, rtol=1e-9)
    x, y = interface.points[:, 0], interface.points[:, 1]

    places = analysis.solid.space.tabulate_dof_coordinates()
    upper = places[:, 2] > 1.0005
    field = np.zeros_like(places)
    field[:, 2] = np.where(upper, places[:, 0] ** 2 + places[:, 0] * places[:, 1], places[:, 1])
    expected = (y - (x + shift) ** 2 - (x + shift) * y) / length
    found = interface.displacement(field.reshape(-1, 1))[:, 0]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def shaft_in_a_ring(path: Path, size: float, *, depth: float) -> None:
    """A disk of radius 0.1 m in a ring with a clearance of 0.1 mm, of order 2."""
    with saved_model(path):
        occ = gmsh.model.occ
        occ.addDisk(0, 0, 0, 0.1, 0.1)
        occ.cut(
            [(2, occ.addDisk(0, 0, 0, 0.13, 0.13))], [(2, occ.addDisk(0, 0, 0, 0.1001, 0.1001))]
        )
        if depth:
            occ.extrude(occ.getEntities(2), 0, 0, depth, [1])
        occ.synchronize()
        dim = 3 if depth else 2
        gmsh.model.addPhysicalGroup(dim, [tag for _, tag in occ.getEntities(dim)], name="body")
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.mesh.generate(dim)
        gmsh.model.mesh.setOrder(2)


@pytest.mark.parametrize("depth", [0.0, 0.01])
def test_gaps_to_curved_facets_are_those_of_the_curve(depth: float, tmp_path: Path) -> None:
    """Straight edges of 26 mm would lie 0.8 mm inside the ring: no clearance were left."""
    shaft_in_a_ring(tmp_path / "shaft.msh", 0.026, depth=depth)

    def between(low: float, high: float) -> dict[str, Any]:
        return {"radii": {"axis": "z", "from": low, "to": high}}

    base = fork_study(tmp_path / "shaft.msh")
    body = {"theory": "solid", "degree": 2} if depth else {**base["body"], "degree": 2}
    values = {
        **base,
        "body": body,
        "groups": {
            "shaft": between(0.0999, 0.10001),
            "ring": between(0.10005, 0.1002),
            "rim": between(0.129, 0.131),
        },
        "clamp": {"facets": "rim"},
        "spring": [{"facets": "shaft", "foundation": [1e12] * (3 if depth else 2)}],
        "contact": {"facets": "shaft", "against": "ring", "points": 20},
    }
    _, analysis = analysed(tmp_path, values)
    np.testing.assert_allclose(analysis.interface.gap, 1e-4, rtol=0.02)


@pytest.mark.parametrize("degree", [1, 2])
def test_meshes_of_the_two_sides_need_not_match(degree: int, tmp_path: Path) -> None:
    """The trace of a polynomial of the elements' degree is exact between nodes."""
    fork(tmp_path / "fork.msh", along=6, right=9)
    values = fork_study(tmp_path / "fork.msh", facets="left tine", against="right tine", points=4)
    values["body"]["degree"] = degree
    _, analysis = analysed(tmp_path, values)
    y = analysis.interface.points[:, 1]

    def field(x: Array, y: Array) -> Array:
        opens = np.where(x > 0, y**degree, 3.0)
        return np.array([opens, np.sin(900 * y)])

    assert not np.isclose(y[:, None], np.linspace(0, 0.1, 10)).all()
    np.testing.assert_allclose(relative(analysis, field), 3.0 - y**degree, rtol=1e-12)


def test_tip_of_a_crack_is_no_contact_point(tmp_path: Path) -> None:
    """The node that both faces share cannot move relative to itself."""
    heights = {0: 0.0, 1: 1.0, 2: 1.0, 3: 2.0}
    nodes = [(float(x), y, 0.0) for y in heights.values() for x in range(4)]

    def node(x: int, level: int) -> int:
        return 4 * (1 if level == 2 and x < 2 else level) + x + 1

    cells = [
        [node(x, low), node(x + 1, low), node(x + 1, low + 1), node(x, low + 1)]
        for x in range(3)
        for low in (0, 2)
    ]
    used = sorted({number for cell in cells for number in cell})
    again = {number: i + 1 for i, number in enumerate(used)}
    edges = {
        name: [[again[node(x, level)], again[node(x + 1, level)]] for x in places]
        for name, level, places in (("bottom", 0, (0, 1, 2)), ("low", 1, (1, 2)), ("up", 2, (1, 2)))
    }
    explicit(
        tmp_path / "crack.msh",
        [nodes[number - 1] for number in used],
        {QUADRANGLE: [[again[number] for number in cell] for cell in cells]},
        edges,
    )
    values = fork_study(tmp_path / "crack.msh", facets="low", against="up", gap=1e-4)
    found = analysed(tmp_path, values)[1].interface
    assert found.left_out == (1,)
    np.testing.assert_allclose(found.points, [[2, 1], [3, 1]])
    np.testing.assert_allclose(found.gap, 1e-4)


def test_pressure_of_both_sides_carries_the_contact_force(tmp_path: Path) -> None:
    fork(tmp_path / "fork.msh", along=6, right=9)
    _, analysis = analysed(tmp_path, fork_study(tmp_path / "fork.msh"))
    interface, solid = analysis.interface, analysis.solid
    force = np.random.default_rng(2).uniform(1, 2, interface.count)
    pressure = interface.pressures @ force
    for name in ("left tine", "right tine"):
        facets = solid.tagged.facets_of((name,), "facets")
        vertices = PatchVertices.of(solid, facets, "facets", name)
        assert (pressure[vertices.local] > 0).all()
        total = pressure[vertices.local] @ vertices.areas
        assert total == pytest.approx(force.sum(), rel=1e-12)
