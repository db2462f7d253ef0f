"""Modes and static displacements by iteration, against factors and closed forms."""

import logging
from pathlib import Path

import numpy as np
import pytest
from conftest import BEAM, changed, toml
from mpi4py import MPI
from ranks import on_ranks

from fenics_nnm.errors import ConvergenceError, ModelError, OutOfMemoryError
from fenics_nnm.fem.conjugate_gradients import static_displacements
from fenics_nnm.fem.inertia import counted_below, modes_below
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.memory import memory_of_rank
from fenics_nnm.fem.modal_solver import modal_solver
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.pencil import Pencil
from fenics_nnm.fem.two_level import TwoLevel
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import MeshStudy

MODES = 12


def study(solver: dict, cells: str = "tetrahedron", **changes: object) -> MeshStudy:
    """A square beam: its bending modes come in pairs, which an iteration must tell apart."""
    return MeshStudy.model_validate(
        {
            "mesh": {
                "model": "beam",
                "length": 1.0,
                "width": 0.05,
                "height": 0.05,
                "elements": (16, 2, 2),
                "cells": cells,
            },
            "body": {"theory": "solid", "degree": 2},
            "material": {"young": 2.1e11, "poisson": 0.3, "density": 7800.0},
            "clamp": {"facets": ["left"]},
            "contact": {
                "facets": ["right"],
                "direction": (0.0, 0.0, 1.0),
                "gap": 1e-3,
                "points": 4,
            },
            "reduction": {"modes": MODES},
            "solver": solver,
            **changes,
        }
    )


def analysis(solver: dict, cells: str = "tetrahedron") -> LinearAnalysis:
    return linear_analysis(study(solver, cells), MPI.COMM_SELF)


@pytest.fixture(scope="module")
def direct() -> LinearAnalysis:
    return analysis({"linear": "direct"})


@pytest.fixture(scope="module")
def iterated() -> LinearAnalysis:
    return analysis({"linear": "iterative"})


def test_iterated_frequencies_are_those_of_the_factors(
    direct: LinearAnalysis, iterated: LinearAnalysis
) -> None:
    np.testing.assert_allclose(iterated.modes.omega, direct.modes.omega, rtol=1e-9)
    assert iterated.modes.checked_below > iterated.modes.omega[-1]


def test_iterated_modes_span_what_the_modes_of_the_factors_span(
    direct: LinearAnalysis, iterated: LinearAnalysis
) -> None:
    mass = Pencil(direct.solid).mass(direct.modes.shapes)
    overlap = np.linalg.svd(mass.T @ iterated.modes.shapes, compute_uv=False)
    np.testing.assert_allclose(overlap, 1.0, rtol=1e-10)


def test_iterated_reduced_model_is_that_of_the_factors(
    direct: LinearAnalysis, iterated: LinearAnalysis
) -> None:
    static, residual = direct.model.static_flexibility, direct.model.R
    np.testing.assert_allclose(
        iterated.model.static_flexibility, static, atol=1e-9 * np.abs(static).max()
    )
    # R is a thousandth of the flexibility of which the modes take the rest away
    np.testing.assert_allclose(iterated.model.R, residual, atol=1e-5 * np.abs(residual).max())


def test_iterated_hexahedra_agree_with_factors() -> None:
    omegas = [
        analysis({"linear": kind}, "hexahedron").modes.omega for kind in ("direct", "iterative")
    ]
    np.testing.assert_allclose(omegas[1], omegas[0], rtol=1e-9)


def test_preconditioner_is_symmetric_and_positive_definite(direct: LinearAnalysis) -> None:
    preconditioner = TwoLevel(direct.solid)
    columns = preconditioner.random(6)
    gram = columns.T @ preconditioner(columns)
    np.testing.assert_allclose(gram, gram.T, atol=1e-12 * np.abs(gram).max())
    assert np.linalg.eigvalsh(gram)[0] > 0
    preconditioner.destroy()


def test_static_displacement_of_a_pulled_rod() -> None:
    """Axial force at the end of a plane strip without lateral contraction: u = F L / (E A)."""
    strip = MeshStudy.model_validate(
        {
            "mesh": {"model": "plate", "length": 1.0, "height": 0.1, "elements": (20, 2)},
            "body": {"theory": "plane-stress", "thickness": 0.05},
            "material": {"young": 2.1e11, "poisson": 0.0, "density": 7800.0},
            "clamp": {"facets": ["left"]},
            "contact": {"facets": ["right"], "direction": (1.0, 0.0), "gap": 1e-3, "points": 2},
            "reduction": {"modes": 2},
            "solver": {"linear": "iterative"},
        }
    )
    solid = linear_analysis(strip, MPI.COMM_SELF).solid
    pencil, preconditioner = Pencil(solid), TwoLevel(solid)
    x = solid.space.tabulate_dof_coordinates()[: solid.owned // 2, 0]
    exact = np.zeros((solid.owned, 1))
    exact[::2, 0] = x
    forces = pencil.stiffness(exact)
    found = static_displacements(pencil, preconditioner, forces, tolerance=1e-10)
    np.testing.assert_allclose(found, exact, atol=1e-9)
    assert forces[::2][x > 1 - 1e-9].sum() == pytest.approx(2.1e11 * 0.1 * 0.05, rel=1e-9)
    preconditioner.destroy()


def test_column_without_force_stays_at_rest(direct: LinearAnalysis) -> None:
    preconditioner = TwoLevel(direct.solid)
    forces = direct.interface.unit_forces(direct.solid.owned) * [1.0, 0.0, 1.0, 1.0]
    found = static_displacements(Pencil(direct.solid), preconditioner, forces, tolerance=1e-8)
    assert not found[:, 1].any()
    assert np.abs(found[:, 0]).max() > 0
    preconditioner.destroy()


def test_missed_mode_is_noticed(direct: LinearAnalysis) -> None:
    squared = direct.modes.omega**2
    below = (squared[4] + squared[5]) / 2 if squared[5] > 1.001 * squared[4] else squared[5] * 1.01
    inside = int(np.count_nonzero(squared < below))
    assert modes_below(direct.solid, float(below)) == inside
    with pytest.raises(ConvergenceError, match="a mode was missed"):
        counted_below(direct.solid, np.delete(squared, 2), 8, None)


def test_modes_that_cannot_be_counted_are_told(
    direct: LinearAnalysis, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        assert counted_below(direct.solid, direct.modes.omega**2, 8, memory=1.0) == 0.0
    assert "modes are not counted" in caplog.text


def test_factors_that_do_not_fit_are_told_or_avoided(
    direct: LinearAnalysis, caplog: pytest.LogCaptureFixture
) -> None:
    little = 1e-3  # GiB
    with pytest.raises(OutOfMemoryError, match="more memory for factors"):
        modal_solver(direct.solid, "direct", little)
    with caplog.at_level(logging.WARNING), modal_solver(direct.solid, "auto", little) as solver:
        assert not isinstance(solver, DirectModalSolver)
        found = solver.modes(3)
    assert "iterating instead" in caplog.text
    np.testing.assert_allclose(found.omega, direct.modes.omega[:3], rtol=1e-9)
    with modal_solver(direct.solid, "auto") as solver:
        assert isinstance(solver, DirectModalSolver)


def test_two_ranks_iterate_to_the_modes_of_one(tmp_path: Path) -> None:
    changes = {"mesh": {"elements": [12, 2, 2]}, "contact": {"points": 3}}
    small = changed(BEAM, {**changes, "reduction": {"modes": 6}, "solver": {"linear": "iterative"}})
    (tmp_path / "study.toml").write_text(toml(small))
    script, found = Path(__file__).parents[1] / "iterated_on_ranks.py", []
    for ranks in (1, 2):
        ended = on_ranks(ranks, script, "study.toml", f"{ranks}.npz", folder=tmp_path)
        assert ended.code == 0, ended.err
        found.append(np.load(tmp_path / f"{ranks}.npz"))
    one, two = found
    np.testing.assert_allclose(two["omega"], one["omega"], rtol=1e-9)
    for name, part in (("static", 1e-9), ("R", 1e-5)):
        np.testing.assert_allclose(two[name], one[name], atol=part * np.abs(one[name]).max())


def test_more_modes_than_an_iteration_can_seek(direct: LinearAnalysis) -> None:
    with modal_solver(direct.solid, "iterative") as solver:
        with pytest.raises(ModelError, match="the iterative solver needs"):
            solver.modes(direct.solid.free // 3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reduction": {"method": "craig-bampton", "modes": 4}}, "does not go with"),
        ({"body": {"theory": "solid", "degree": 1}}, "needs quadratic elements"),
    ],
)
def test_what_an_iteration_does_not_go_with(changes: dict, message: str) -> None:
    if "reduction" in changes:
        changes["contact"] = {
            "facets": ["right"],
            "direction": (0.0, 0.0, 1.0),
            "gap": 1e-3,
            "points": 4,
            "law": "augmented-lagrangian",
        }
    with pytest.raises(ValueError, match=message):
        study({"linear": "iterative"}, **changes)


def test_memory_is_shared_by_the_ranks_of_a_machine() -> None:
    comm = MPI.COMM_WORLD
    assert memory_of_rank(comm, 3.0) == pytest.approx(3.0 * 2**30 / comm.size)
    free = memory_of_rank(comm, None)
    assert free is None or free > 0
