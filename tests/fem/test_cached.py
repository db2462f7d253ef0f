"""Kept meshes, static states and modes: taken bit for bit, and never for another body."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, changed
from mpi4py import MPI
from read_here import in_this_process

from fenics_nnm.fem import cached_state, cad, surroundings
from fenics_nnm.fem.cad_model import Cad, MeshCad
from fenics_nnm.fem.deflection import BodyForces
from fenics_nnm.fem.mesh_file import ReadMesh
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.static_state import _Newton
from fenics_nnm.files.cache import VARIABLE, Cache
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from

SQUARE = """Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {1, 1, 0}; Point(4) = {0, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
"""

#: A beam that turns about an axis below its root.
TURNING: dict[str, Any] = {
    **BEAM,
    "rotation": {"axis": "z", "speed": 60.0, "origin": [-0.5, 0.0, 0.0]},
}

#: The same with second-order kinematics.
BENT: dict[str, Any] = {**TURNING, "body": {**TURNING["body"], "kinematics": "second-order"}}


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cache:
    """An empty cache that is used."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kept"))
    return Cache(tmp_path / "kept")


def noting(found: list[str], name: str, work: Callable[..., Any]) -> Callable[..., Any]:
    """The same function, which adds a name to a list when it is called."""

    def call(*given: Any) -> Any:
        found.append(name)
        return work(*given)

    return call


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is computed, not taken: "mesh", "state" or "modes", one after the other."""
    found: list[str] = []
    noted = partial(noting, found)
    monkeypatch.setattr(cad, "in_own_process", noted("mesh", in_this_process))
    monkeypatch.setattr(_Newton, "loaded", noted("state", _Newton.loaded))
    monkeypatch.setattr(DirectModalSolver, "modes", noted("modes", DirectModalSolver.modes))
    return found


def analysed(base: dict[str, Any], **changes: Any) -> Any:
    study = study_from(changed(base, changes), Path("study.toml"))
    return linear_analysis(study, MPI.COMM_SELF)


def square_study(path: Path, **changes: Any) -> dict[str, Any]:
    mesh = {"file": str(path), "length_unit": "m", "element_size": 0.5, **changes}
    return {
        **BEAM,
        "mesh": mesh,
        "groups": {"low": {"x": 0.0}, "right": {"x": 1.0}},
        "body": {"theory": "plane-stress", "thickness": 0.01},
        "clamp": {"facets": "low"},
        "contact": {"facets": "right", "direction": [1.0, 0.0], "gap": 1e-3, "points": 2},
    }


def test_a_mesh_is_taken_as_long_as_file_and_sizes_are_the_same(
    kept: Cache, made: list[str], tmp_path: Path
) -> None:
    file = tmp_path / "square.geo"
    file.write_text(SQUARE)
    first, again = (analysed(square_study(file)) for _ in range(2))
    assert made == ["mesh", "modes"]
    mesh, taken = (each.solid.tagged.as_read.digest for each in (first, again))
    assert mesh == taken
    analysed(square_study(file, element_size=0.1))
    file.write_text(SQUARE.replace("{1, 1, 0}", "{1, 1.1, 0}"))
    moved = analysed(square_study(file))
    assert made == 3 * ["mesh", "modes"]
    assert moved.solid.tagged.bounds()[1, 1] == pytest.approx(1.1)


def test_meshes_that_may_depend_on_other_files_are_not_kept(tmp_path: Path) -> None:
    script, mesh = tmp_path / "square.geo", tmp_path / "square.msh"
    script.write_text(SQUARE + 'Merge "other.geo";\n')
    mesh.write_text("$MeshFormat")
    assert MeshCad(Cad(script, "m", trust_script=True)).identity() == ""
    assert MeshCad(Cad(script, "m")).identity() == ""
    assert ReadMesh(tmp_path / "square.xdmf").identity() == ""
    assert ReadMesh(mesh).identity() != ""


def test_state_and_modes_are_taken_bit_for_bit(kept: Cache, made: list[str]) -> None:
    first, again = analysed(TURNING), analysed(TURNING, contact={"gap": 1e-3})
    assert made == ["state", "modes"]
    assert len(kept.files()) == 5  # and what makes second-order kinematics
    for one, other in (
        (first.modes.shapes, again.modes.shapes),
        (first.modes.omega, again.modes.omega),
        (first.model.R, again.model.R),
        (first.model.Phi, again.model.Phi),
        (first.solid.state.displacement.x.array, again.solid.state.displacement.x.array),
    ):
        assert one.tobytes() == other.tobytes()
    assert np.abs(first.solid.state.displacement.x.array).max() > 1e-7
    assert first.solid.state.steps == again.solid.state.steps


@pytest.mark.parametrize(
    "change",
    [
        {"rotation": {"speed": 61.0}},
        {"rotation": {"origin": [-0.6, 0.0, 0.0]}},
        {"material": {"density": 7801.0}},
        {"material": {"poisson": 0.31}},
        {"clamp": {"facets": "right"}, "contact": {"facets": "left"}},
        {"mesh": {"height": 0.11}},
    ],
)
def test_nothing_is_taken_for_another_body(
    kept: Cache, made: list[str], change: dict[str, Any]
) -> None:
    analysed(TURNING)
    analysed(TURNING, **change)
    assert made == 2 * ["state", "modes"]


@pytest.fixture
def derived(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is computed, not taken, of second order."""
    found: list[str] = []
    noted = partial(noting, found)
    for name in ("_pairs", "_all"):
        monkeypatch.setattr(BodyForces, name, noted(name, getattr(BodyForces, name)))
    return found


def test_second_order_is_taken_bit_for_bit(kept: Cache, derived: list[str]) -> None:
    first, again = analysed(BENT), analysed(BENT, contact={"gap": 1e-3})
    assert derived == ["_pairs", "_all"]
    assert first.reduction.bent_shapes.tobytes() == again.reduction.bent_shapes.tobytes()
    for name, tensor in first.model.kinematics.tensors.items():
        assert tensor.tobytes() == again.model.kinematics.tensors[name].tobytes()
        assert np.abs(tensor).max() > 0


@pytest.mark.parametrize(
    "change",
    [
        {"rotation": {"speed": 61.0}},
        {"material": {"young": 2.2e11}},
        {"mode": {"number": 2}},
    ],
)
def test_second_order_is_not_taken_for_another_body_or_mode(
    kept: Cache, derived: list[str], change: dict[str, Any]
) -> None:
    analysed(BENT)
    analysed(BENT, **change)
    assert derived == 2 * ["_pairs", "_all"]


def test_more_modes_are_found_anew(kept: Cache, made: list[str]) -> None:
    for modes in (2, 3, 2):
        assert len(analysed(BEAM, reduction={"modes": modes}).modes.omega) == modes
    assert made == ["modes", "modes"]


def test_a_state_that_is_not_one_of_these_loads_is_not_taken(
    kept: Cache, made: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even one that is kept under the right key."""
    first = analysed(TURNING)
    read = Cache.read

    def off(cache: Cache, key: str) -> dict[str, Any] | None:
        found = read(cache, key)
        if found and "displacement" in found:
            found["displacement"] = 1.000001 * found["displacement"]
        return found

    monkeypatch.setattr(Cache, "read", off)
    again = analysed(TURNING)
    assert made == ["state", "modes", "state"]
    one, other = (each.solid.state.displacement.x.array for each in (first, again))
    assert one.tobytes() == other.tobytes()


def test_another_program_takes_nothing(
    kept: Cache, made: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    analysed(BEAM)
    for module in (cached_state, "fenics_nnm.fem.cached_modes"):
        name = module if isinstance(module, str) else module.__name__
        monkeypatch.setattr(f"{name}.surroundings", lambda: "of another version")
    analysed(BEAM)
    assert made == ["modes", "modes"]


def test_a_change_of_the_source_is_seen(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text("one = 1\n")
    before = surroundings._source(tmp_path)
    (tmp_path / "a.py").write_text("one = 2\n")
    assert surroundings._source(tmp_path) != before
    assert surroundings.surroundings() == surroundings.surroundings()
