"""Curved elements: as gmsh's optimiser gives them, and straight only where that does no harm."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cad_model import Cad, MeshCad
from fenics_nnm.fem.curved import _size
from fenics_nnm.fem.gmsh_mesh import gmsh_session
from fenics_nnm.fem.native import Limits, in_own_process
from fenics_nnm.fem.optimiser import _in_fork
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.study.error_keys import one_line

#: A ring, by its number of nodes on a quarter turn; from 5 on the optimiser can do it.
RING = (
    'SetFactory("OpenCASCADE");\nCylinder(1) = {{0, 0, 0, 0, 0, 3, 10}};\n'
    "Cylinder(2) = {{0, 0, 0, 0, 0, 3, 8.5}};\n"
    "BooleanDifference{{ Volume{{1}}; Delete; }}{{ Volume{{2}}; Delete; }}\n"
    "{more}Transfinite Curve {{:}} = {nodes};\n"
)
BLOCK = "Box(9) = {50, 0, 0, 400, 400, 400};\n"

#: Middle node of each edge of a tetrahedron of gmsh, and even orders of the corners.
MIDDLE = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (2, 3): 8, (1, 3): 9}
CORNERS = ((0, 1, 2, 3), (1, 2, 0, 3), (2, 0, 1, 3), (3, 0, 2, 1))


def corner_volumes(raw: RawMesh) -> Any:
    """Jacobian determinants at the corners of curved tetrahedra, from their shape functions."""
    x = raw.points[raw.cells]
    found = []
    for at, *ends in CORNERS:
        middle = [MIDDLE[min(at, end), max(at, end)] for end in ends]
        found.append(np.linalg.det(4 * x[:, middle] - 3 * x[:, [at]] - x[:, ends]))
    return np.array(found)


def meshed(path: Path, nodes: int, more: str = "", size: float = 30.0) -> RawMesh:
    path.write_text(RING.format(nodes=nodes, more=more))
    return in_own_process(MeshCad(Cad(path, "mm", element_size=size, order=2)), Limits())


def volume(raw: RawMesh) -> float:
    """Volume of curved tetrahedra by a rule that is exact for their Jacobians, of degree 3."""
    total = 0.0
    at = [[1 / 4] * 4, *(np.where(np.arange(4) == i, 1 / 2, 1 / 6) for i in range(4))]
    slopes = np.vstack([-np.ones(3), np.eye(3)])
    for part, weight in zip(np.array(at), [-4 / 5, *[9 / 20] * 4], strict=True):
        gradients = np.zeros((10, 3))
        gradients[:4] = (4 * part - 1)[:, None] * slopes
        for (i, j), row in MIDDLE.items():
            gradients[row] = 4 * (part[i] * slopes[j] + part[j] * slopes[i])
        jacobians = np.einsum("enx,nl->exl", raw.points[raw.cells], gradients)
        total += weight / 6 * float(np.linalg.det(jacobians).sum())
    return total


def test_optimised_elements_follow_the_surface_and_are_the_same_each_time(
    tmp_path: Path,
) -> None:
    """Straight elements would miss a fifth of the ring."""
    first, second = (meshed(tmp_path / "a.geo", 5) for _ in range(2))
    assert [first.notes, second.notes] == [(), ()]  # or the optimiser ended early
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.cells, second.cells)
    assert corner_volumes(first).min() > 0
    quarter = 1 / 2 + 2 / 3 * (np.sqrt(2) - 1)  # a triangle and the parabola over its chord
    assert volume(first) == pytest.approx(3 * 4 * quarter * (10**2 - 8.5**2), rel=2e-3)


def test_straight_elements_that_would_change_the_body_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshError) as error:
        meshed(tmp_path / "a.geo", 4)
    message = one_line(error.value)
    assert message.startswith(f"mesh.file = {tmp_path / 'a.geo'}: 31 curved elements are folded")
    assert "optimiser crashed (SIGABRT)" in message and "\n" not in message
    assert "a smaller element_size" in message and "order = 1" in message
    assert len(meshed(tmp_path / "a.geo", 7).cells) > 66  # what it advises helps


def test_few_bad_elements_of_a_large_body_become_straight(tmp_path: Path) -> None:
    raw = meshed(tmp_path / "a.geo", 4, BLOCK, 300.0)
    (note,) = raw.notes
    assert note.startswith("31 curved elements were folded") and "crashed" in note
    places = note.partition(" at (")[2].partition(") mm ...")[0].split("); (")
    assert len(set(places)) == 3
    assert all(np.hypot(*map(float, at.split(", ")[:2])) < 10 for at in places)
    volumes = corner_volumes(raw)
    assert volumes.min() > 0
    radii = np.linalg.norm(raw.points[raw.points[:, 0] < 20, :2], axis=1)
    assert radii.max() == pytest.approx(10, rel=1e-9)


def test_the_optimiser_may_crash_fail_or_not_end() -> None:
    begin = time.monotonic()
    assert _in_fork(lambda: time.sleep(60), 0.3) == "took more than 0.3 s"
    assert time.monotonic() - begin < 10
    assert _in_fork(os.abort, 10.0) == "crashed (SIGABRT)"
    assert _in_fork(lambda: [][0], 10.0) == "failed"
    assert _in_fork(lambda: None, 10.0) == ""


def test_area_of_a_plane_body_counts_folded_parts_as_negative() -> None:

    with gmsh_session("disk"):
        gmsh.model.occ.addDisk(0, 0, 0, 2, 2)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.ElementOrder", 2)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)
        gmsh.model.mesh.generate(2)
        before = _size(2)
        assert before == pytest.approx(4 * np.pi, rel=1e-4)
        assert _size(1) == pytest.approx(4 * np.pi, rel=1e-4)
        inside = gmsh.model.mesh.getNodes(2)[0][0]
        gmsh.model.mesh.setNode(int(inside), [9.0, 9.0, 0.0], [])
        assert _size(2) == pytest.approx(before, rel=1e-12)  # its boundary is as it was
