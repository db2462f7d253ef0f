"""Clamps on nodes and edges, and in one direction: against closed forms and whole bodies."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from brick_beams import bricks, inp
from conftest import BEAM, ROD, Ended
from mpi4py import MPI

from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

SOLVERS = [{"linear": "direct"}, {"linear": "iterative"}]


def analysed(base: dict[str, Any], folder: Path, **changes: Any) -> LinearAnalysis:
    study = study_from({**base, **changes}, folder / "study.toml")
    found = linear_analysis(study, MPI.COMM_SELF)
    assert isinstance(found, LinearAnalysis)
    return found


def beam_file(folder: Path, n: tuple[int, int, int], sets: str) -> dict[str, Any]:
    """The beam of bricks, 0.2 x 0.02 x 0.01 m, with sets of nodes."""
    (folder / "beam.inp").write_text(inp(sets, n))
    return {**BEAM, "mesh": {"file": "beam.inp", "length_unit": "m"}}


def test_roller_beam_against_euler_and_bernoulli(tmp_path: Path) -> None:
    """Held in height on the middle lines of both ends, which are edges of elements: f = n^2 ...

    A pinned beam of length L has the frequencies (n pi / L)^2 sqrt(E I / rho A) / 2 pi; Poisson's
    ratio is zero, and Timoshenko's first correction is for the shear and rotation of its height.
    """
    base = beam_file(tmp_path, (16, 1, 2), lines((16, 1, 2)))
    material = {"young": 2.1e11, "poisson": 0.0, "density": 7800.0}
    clamps = [{"nodes": ["ends"], "directions": ["z"]}, {"nodes": "pin", "directions": ["x", "y"]}]
    clamps.append({"nodes": "guide", "directions": ["y"]})
    contact = {"facets": "tip", "direction": [0.0, 0.0, 1.0], "gap": 1e-3, "points": 2}
    groups = {"tip": {"box": {"from": [0.09, -1.0, 0.0099], "to": [0.14, 1.0, 1.0]}}}
    found = analysed(
        base, tmp_path, material=material, clamp=clamps, contact=contact, groups=groups
    )
    n = np.array([1.0])
    euler = (n * np.pi / 0.2) ** 2 * np.sqrt(2.1e11 / 7800 * 0.01**2 / 12) / (2 * np.pi)
    slender = (n * np.pi / 0.2) ** 2 * 0.01**2 / 12
    timoshenko = euler * (1 - slender / 2 * (1 + 2 / (5 / 6)))
    bending = [f for f in found.modes.frequencies if abs(f / timoshenko[0] - 1) < 3e-3]
    assert len(bending) == 1, (found.modes.frequencies, timoshenko)


def lines(n: tuple[int, int, int]) -> str:
    """Middle lines of the ends across the beam, one corner of them, and the other end of one."""
    a, b = n[0] + 1, (n[0] + 1) * (n[1] + 1)
    low = [1 + b, 1 + b + a]
    high = [1 + b + n[0], 1 + b + a + n[0]]
    assert len(bricks(n)) == n[0] * n[1] * n[2]
    return "\n".join(
        [
            "*NSET, NSET=ends\n" + ", ".join(map(str, [*low, *high])),
            f"*NSET, NSET=pin\n{low[0]}",
            f"*NSET, NSET=guide\n{high[0]}",
        ]
    )


def whole_and_half(tmp_path: Path, solver: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies of a clamped beam, and of its half with a plane of symmetry at y = 0.01."""
    contact = {"facets": "pad", "direction": [0.0, 0.0, 1.0], "gap": 1e-3, "points": 4}
    groups = {
        "root": {"x": 0.0},
        "pad": {"box": {"from": [0.14, -1.0, 0.0099], "to": [1.0, 1.0, 1.0]}},
        "plane": {"y": 0.0},
    }
    common = {"groups": groups, "contact": contact, "reduction": {"modes": 8}, "solver": solver}
    whole = beam_file(tmp_path, (8, 2, 1), "")
    one = analysed(whole, tmp_path, clamp={"facets": "root"}, **common)
    (tmp_path / "beam.inp").write_text(inp("", (8, 1, 1)).replace(", 0.02,", ", 0.01,"))
    clamps = [{"facets": "root"}, {"facets": "plane", "directions": ["y"]}]
    two = analysed(whole, tmp_path, clamp=clamps, **common)
    assert len(two.interface.points) == 4
    return one.modes.frequencies, two.modes.frequencies


@pytest.mark.parametrize("solver", SOLVERS, ids=["direct", "iterative"])
def test_half_a_body_has_the_symmetric_modes(solver: dict[str, Any], tmp_path: Path) -> None:
    """With contact points on the plane of symmetry, which are free along the contact direction."""
    whole, half = whole_and_half(tmp_path, solver)
    for frequency in half[:4]:
        assert np.abs(whole / frequency - 1).min() < 1e-7, (whole, half)
    assert np.abs(half / whole[1] - 1).min() > 1e-2  # bending along y is not symmetric


def test_clamp_of_all_nodes_of_a_facet_is_the_clamp_of_the_facet(tmp_path: Path) -> None:
    groups = {"root": {"x": 0.0}, "pad": {"x": 0.2}}
    common = {"groups": groups, "contact": {**BEAM["contact"], "facets": "pad"}}
    base = beam_file(tmp_path, (4, 1, 1), "*NSET, NSET=left\n1, 6, 11, 16")
    facets = analysed(base, tmp_path, clamp={"facets": "root"}, **common)
    nodes = analysed(base, tmp_path, clamp={"nodes": "left"}, **common)
    parts = [{"facets": "root", "directions": [axis]} for axis in "zyx"]
    axes = analysed(base, tmp_path, clamp=parts, **common)
    for other in (nodes, axes):
        np.testing.assert_array_equal(np.sort(other.solid.clamped), np.sort(facets.solid.clamped))
        np.testing.assert_allclose(other.modes.frequencies, facets.modes.frequencies, rtol=1e-10)


def test_contact_on_the_plane_of_symmetry_reduces_alike_by_craig_and_bampton(
    tmp_path: Path,
) -> None:
    """No force acts on what is held: the lowest modes stay those of the body."""
    base = beam_file(tmp_path, (8, 1, 1), "")
    groups = {"root": {"x": 0.0}, "plane": {"y": 0.0}, "tip": {"x": 0.2}}
    clamps = [{"facets": "root"}, {"facets": "plane", "directions": ["y"]}]
    reduction = {"modes": 12, "method": "craig-bampton", "interface": "all"}
    contact = {"facets": "tip", "direction": [0.0, 0.0, 1.0], "gap": 1e-3}
    found = analysed(
        base, tmp_path, groups=groups, clamp=clamps, contact=contact, reduction=reduction
    )
    own = found.model.at_rest().omega[:4] / (2 * np.pi)
    np.testing.assert_allclose(own, found.modes.frequencies[:4], rtol=2e-3)


BAD = [
    ({"nodes": "none"}, 'clamp.nodes = "none": the mesh has no such set of nodes; it has "Nall"'),
    ({"facets": "root", "directions": []}, "clamp.directions"),
    ({"facets": "root", "directions": ["w"]}, "clamp.directions"),
    ({"facets": "root", "directions": ["x", "x"]}, "must be different"),
    ({"directions": ["x"]}, "clamp.facets: is missing"),
    ({"facets": "pad", "directions": ["z"]}, "contact facets must not touch the clamp"),
]


@pytest.mark.parametrize(("clamp", "words"), BAD)
def test_clamps_that_cannot_be(
    clamp: dict[str, Any],
    words: str,
    study_file: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    base = beam_file(tmp_path, (4, 1, 1), "")
    groups = {"root": {"x": 0.0}, "pad": {"x": 0.2}}
    study = study_file(base, clamp={"=": clamp}, groups={"=": groups}, contact={"facets": "pad"})
    command("check", study).assert_one_line(2, words)


def test_direction_that_a_mesh_does_not_have(study_file: StudyFile, command: Command) -> None:
    study = study_file(ROD, clamp={"directions": ["y"]})
    command("check", study).assert_one_line(2, 'clamp.directions: "y"', "dimension 1")


def test_clamp_in_some_directions_is_in_the_study_of_a_run(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """A sliding rod: its left end held along x is what it was."""
    study = study_file(ROD, clamp={"directions": ["x"]})
    first = re.search(r"\n +1 +([\d.]+)", command("check", study).out)
    second = re.search(r"\n +1 +([\d.]+)", command("check", study_file(ROD)).out)
    assert first and second and float(first[1]) == pytest.approx(float(second[1]), rel=1e-9)
