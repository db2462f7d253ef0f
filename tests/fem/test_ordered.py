"""Factors of a stiffness whose rows are in another order give the same solutions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import BEAM, changed
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.fem import dissection
from fenics_nnm.fem.block import product
from fenics_nnm.fem.loads import Loads, Rotation
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.ordered import Ordered
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.static_state import loaded
from fenics_nnm.fem.system import FreeSystem
from fenics_nnm.stages import Stages
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.study import MeshStudy, study_from

PREFIX = "test_ordered_"


@pytest.fixture(scope="module")
def solid() -> Solid:
    mesh = {"length": 0.4, "width": 0.1, "height": 0.1, "elements": [6, 2, 2]}
    study = study_from(changed(BEAM, {"mesh": mesh}), Path("study.toml"))
    assert isinstance(study, MeshStudy)
    return MeshStructure(study).assembled(MPI.COMM_SELF, Stages()).solid


@pytest.fixture
def dissecting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few cells are worth the while."""
    monkeypatch.setattr(dissection, "_WORTHWHILE", 1)


@pytest.mark.usefixtures("dissecting")
def test_solutions_are_in_the_order_of_the_matrix(solid: Solid) -> None:
    solver = Ordered.of(solid, None, PREFIX)
    assert solver.kept and (solver.order != np.arange(solid.owned)).any()
    solver.factorise(None)
    forces = np.sin(np.arange(2.0 * solid.owned)).reshape(-1, 2)
    left = product(solid.stiffness, solver.solve(forces)) - forces
    assert np.abs(left).max() < 1e-9
    solver.release()


@pytest.mark.usefixtures("dissecting")
def test_cholmod_keeps_the_order_once_and_options_of_the_user_win(solid: Solid) -> None:
    options = PETSc.Options(PREFIX)
    for kept in ("", "3"):
        if kept:
            options.setValue("mat_cholmod_nmethods", kept)
        solver = Ordered.of(solid, None, PREFIX)
        solver.factorise(None)
        assert options.getString("mat_cholmod_nmethods", "") == kept
        solver.release()
    options.delValue("mat_cholmod_nmethods")


def test_a_static_state_does_not_depend_on_the_order(
    solid: Solid, monkeypatch: pytest.MonkeyPatch
) -> None:
    loads = Loads(Rotation((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), 2000.0))
    found = []
    for worthwhile in (1, 10**6):
        monkeypatch.setattr(dissection, "_WORTHWHILE", worthwhile)
        state = loaded(solid, loads).state
        assert state is not None
        found.append(state.owned(solid.owned))
    assert np.abs(found[0] - found[1]).max() < 1e-10 * np.abs(found[1]).max()
    assert (found[0] != found[1]).any()


def factored_by(solver: DirectModalSolver) -> str:
    return str(solver.factored().inverse.ksp.getPC().getFactorSolverType())


@pytest.mark.usefixtures("dissecting")
def test_modes_do_not_depend_on_the_order(solid: Solid, monkeypatch: pytest.MonkeyPatch) -> None:
    forces = np.zeros((solid.owned, 2))
    forces[[50, 100], [0, 1]] = 1.0
    found = []
    for solver_type in ("cholmod", "mumps"):
        if solver_type == "mumps":
            monkeypatch.setattr(dissection, "_WORTHWHILE", 10**6)
        with DirectModalSolver(solid) as solver:
            assert factored_by(solver) == solver_type and solver.negative == 0
            still = solver.static(forces)
            held = solver.fixed_interface_modes(forces, still, 4)
            found.append((solver.modes(6), still, np.abs(held)))
    (one, still, held), (other, still_too, held_too) = found
    assert one.omega == pytest.approx(other.omega, rel=1e-10)
    assert one.checked_below == pytest.approx(other.checked_below, rel=1e-9)
    assert still == pytest.approx(still_too, abs=1e-10 * np.abs(still_too).max())
    assert held == pytest.approx(held_too, abs=1e-6 * held_too.max())


@pytest.mark.usefixtures("dissecting")
def test_mumps_counts_where_the_stiffness_is_not_definite(solid: Solid) -> None:
    with DirectModalSolver(solid) as solver:
        omega = solver.modes(6).omega
    K = solid.stiffness.copy()
    K.axpy(-float(omega[2] * omega[3]), solid.mass, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    shifted = replace(solid, stiffness=K, system=FreeSystem(K, solid.mass))
    with DirectModalSolver(shifted) as solver:
        assert factored_by(solver) == "mumps" and solver.negative == 3


@pytest.mark.usefixtures("dissecting")
@pytest.mark.parametrize("option", ["mat_mumps_icntl_14", "pc_factor_mat_solver_type"])
def test_options_of_mumps_are_for_mumps(solid: Solid, option: str) -> None:
    options = PETSc.Options("nnm_st_")
    options.setValue(option, "mumps" if "type" in option else "30")
    try:
        with DirectModalSolver(solid) as solver:
            assert factored_by(solver) == "mumps"
    finally:
        options.delValue(option)
