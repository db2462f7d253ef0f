"""Bodies on meshes and matrices answer the same questions, each in its own way."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, ROD, changed
from mpi4py import MPI

import fenics_nnm.structure.motions
import fenics_nnm.structure.prepared
from fenics_nnm.errors import StudyError
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.run import run_study
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode, prepared, structure_of
from fenics_nnm.structure.structure import Linear
from fenics_nnm.study import Study, study_from

COMM = MPI.COMM_SELF

#: A chain of two springs k and two masses m has omega^2 = (3 -+ sqrt(5)) / 2 * k / m.
SPRING, MASS = 1e6, 2.0


def chain(folder: Path, **contact: Any) -> Study:
    """Two masses in a row, held at one end; the last one can touch."""
    K, M = SPRING * np.array([[2.0, -1.0], [-1.0, 1.0]]), MASS * np.eye(2)
    np.savez(folder / "chain.npz", K=K, M=M, B=np.array([[0.0, 1.0]]))
    values = {
        "matrices": {"file": "chain.npz"},
        "contact": {"gap": 1e-3, **contact},
        "reduction": {"modes": 1},
        "mode": {"harmonics": 3, "samples": 32},
        "continuation": {"energies": {"from": 0.8, "to": 1.1, "step": 0.1}},
    }
    return study_from(values, folder / "study.toml")


def body(base: dict[str, Any] = ROD, **changes: Any) -> Study:
    return study_from(changed(base, changes), Path("study.toml"))


def test_modes_of_matrices_are_those_of_the_closed_form(tmp_path: Path) -> None:
    linear = linear_analysis(chain(tmp_path), COMM)
    omega = np.sqrt((3 - np.sqrt(5)) / 2 * SPRING / MASS)
    assert linear.model.omega == pytest.approx([omega], rel=1e-12)


def test_matrices_have_nothing_of_a_mesh(tmp_path: Path) -> None:
    study = chain(tmp_path)
    linear = linear_analysis(study, COMM)
    assert structure_of(study).outline is None
    assert linear.body is None
    assert linear.flexibility(3) is None
    assert linear.groups() == []
    assert linear.sizes() == {"dofs": 2, "contact_points": 1}
    assert linear.first_contact(0).place == "contact row 1"


def test_a_mesh_can_be_drawn_and_seen() -> None:
    study = body(PLATE)
    outline, linear = structure_of(study).outline, linear_analysis(study, COMM)
    assert outline is not None and isinstance(linear, LinearAnalysis)
    assert outline.roles == {"left": "clamped", "right": "contact"}
    assert outline.casings == {}
    assert set(outline.mesh(COMM).facets) == set(linear.solid.tagged.facets)
    assert linear.body is linear


def test_full_order_of_a_mesh_begins_at_its_truncation() -> None:
    """At frequency 0 the residual flexibility D vanishes, and its slope is X^T M X."""
    linear = linear_analysis(body(PLATE, reduction={"method": "none"}), COMM)
    truncation: Any = linear.reduction.truncation
    source = linear.flexibility(2)
    assert source is not None
    with source as flexibility:
        D, slope, _ = flexibility(0.0).at(0.0)
    assert np.all(D == 0)
    np.testing.assert_array_equal(slope[1], truncation.slope)


@pytest.mark.parametrize("kind", ["mesh", "matrices"])
def test_data_bring_back_the_displacement(kind: str, tmp_path: Path) -> None:
    """What branch.h5 keeps gives u = shapes^T q - residual_shapes^T lambda."""
    linear = linear_analysis(body() if kind == "mesh" else chain(tmp_path), COMM)
    data = linear.data()
    whole = {name: each.rows(slice(None)) for name, each in data.blocks.items()}
    shapes, residual = ({**data.arrays, **whole}[f"basis/{name}"] for name in NAMES)
    q, force = np.arange(1.0, linear.model.modes + 1), np.array([3e3])
    moved = np.tensordot(q, shapes, 1) - np.tensordot(force, residual, 1)
    found = linear.reduction.displacement(q, force)
    assert np.sort(moved.ravel()) == pytest.approx(np.sort(found), abs=1e-15)


NAMES = ("shapes", "residual_shapes")


@pytest.mark.parametrize("kind", ["mesh", "matrices"])
def test_another_gap_changes_the_gap_alone(kind: str, tmp_path: Path) -> None:
    def study(**contact: Any) -> Study:
        return body(contact=contact) if kind == "mesh" else chain(tmp_path, **contact)

    before: Linear = linear_analysis(study(gap=0.0, reference_displacement=2e-4), COMM)
    after = before.with_contact(study(gap=2e-3))
    assert after is not None
    assert after.model.gap == pytest.approx([2e-3])
    assert after.model.reference is None
    np.testing.assert_array_equal(after.model.R, before.model.R)


def test_other_contact_rows_are_another_analysis() -> None:
    linear = linear_analysis(body(PLATE), COMM)
    assert linear.with_contact(body(PLATE, contact={"direction": [0.0, -1.0]})) is None


def test_matrices_need_no_finite_elements() -> None:
    asked = "('dolfinx', 'petsc4py', 'slepc4py', 'ufl', 'gmsh')"
    script = f"""
import sys
import fenics_nnm.structure.matrix_structure
print([name for name in {asked} if name in sys.modules])
"""
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (found.stdout, found.stderr) == ("[]\n", "")


def test_linear_frequencies_are_those_about_rest(tmp_path: Path) -> None:
    """A point pressed at rest is held there: of the chain, the first mass with two springs."""
    pressed = prepared(*_with_linear(chain(tmp_path, gap=-1e-3)))
    open_ = prepared(*_with_linear(chain(tmp_path)))
    free = np.sqrt((3 - np.sqrt(5)) / 2 * SPRING / MASS) / (2 * np.pi)
    assert open_.linear_frequencies == pytest.approx([free], rel=1e-12)
    assert pressed.linear_frequencies[0] > 1.5 * free


def _with_linear(study: Study) -> tuple[Study, Linear]:
    return study, linear_analysis(study, COMM)


def test_a_branch_does_not_leave_its_beginning_out(tmp_path: Path) -> None:
    """A study that names a motion of another file is not followed from the linear mode instead."""
    start = {"file": "other.h5", "gamma_ratio": 1.05}
    study = body(
        continuation={"parameter": "arc-length", "energies": {"step": None}, "start": start}
    )
    with pytest.raises(StudyError, match=r"continuation\.start: .* is not given"):
        nonlinear_mode(study, linear_analysis(study, COMM))


def test_a_run_asks_its_study_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Series and wanted motions are made once, and handed on."""
    asked = []
    for name in ("harmonic_balance", "wanted_motions"):
        original = getattr(fenics_nnm.structure.motions, name)

        def note(*given: Any, name: str = name, original: Any = original) -> Any:
            asked.append(name)
            return original(*given)

        monkeypatch.setattr(fenics_nnm.structure.prepared, name, note)
    result = run_study(chain(tmp_path), "", tmp_path / "out", comm=COMM)
    assert len(result.branch.points) == 4
    assert sorted(asked) == ["harmonic_balance", "wanted_motions"]
