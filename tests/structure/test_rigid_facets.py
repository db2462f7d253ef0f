"""Facets that follow a point, of [[rigid]]: closed forms, all reductions, fields and refusals."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended
from constrained_beams import cantilever, rigid_misfit
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.errors import ModelError, StudyError
from fenics_nnm.fem.harmonic import HarmonicSolver
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: A slender cantilever in plane stress whose end carries a mass; its upper edge can touch.
HEIGHT, THICKNESS = 0.02, 0.01
MASS, INERTIA = 0.5, 2e-2
SLENDER: dict[str, Any] = {
    **PLATE,
    "mesh": {**PLATE["mesh"], "height": HEIGHT, "elements": [20, 1]},
    "material": {"young": 2.1e11, "poisson": 0.0, "density": 7800.0},
    "groups": {"pad": {"box": {"from": [0.55, 0.019], "to": [0.85, 1.0]}}},
    "contact": {"facets": "pad", "direction": [0.0, 1.0], "gap": 1e-3},
}
RIGID = {
    "facets": "right",
    "at": [1.0, HEIGHT / 2],
    "mass": MASS,
    "inertia": [INERTIA],
}


def analysed(base: dict[str, Any], **changes: Any) -> Any:
    return linear_analysis(study_from({**base, **changes}, Path("study.toml")), MPI.COMM_SELF)


def test_tip_mass_with_rotary_inertia_against_euler_and_bernoulli() -> None:
    found = analysed(SLENDER, rigid=[RIGID])
    stiffness = 2.1e11 * THICKNESS * HEIGHT**3 / 12, 7800.0 * THICKNESS * HEIGHT
    wanted = cantilever(*stiffness, 1.0, mass=MASS, inertia=INERTIA)
    assert found.modes.frequencies[0] == pytest.approx(wanted, rel=1e-3)
    lighter = cantilever(*stiffness, 1.0, mass=MASS, inertia=0.0)
    assert abs(lighter / wanted - 1) > 3e-3
    assert f"right about (1, {HEIGHT / 2:g}, 0) m, {MASS:g} kg" in "\n".join(found.heading())


def test_mass_at_the_end_of_a_rod_is_that_of_a_mass() -> None:
    heavy = {"facets": "right", "at": [1.0], "mass": 3.0}
    base = {**ROD, "contact": {**ROD["contact"], "facets": "pad"}, "groups": {"pad": {"x": 1.0}}}
    one = analysed(base, rigid=[heavy])
    same = analysed(base, rigid=[{**heavy, "at": ["1000 mm"]}])
    two = analysed(base, mass=[{"at": [1.0], "mass": 3.0}])
    np.testing.assert_array_equal(one.modes.frequencies, same.modes.frequencies)
    np.testing.assert_allclose(one.modes.frequencies, two.modes.frequencies, rtol=1e-12)


def test_point_held_in_all_directions_is_a_clamp() -> None:
    """Held in all, it is the clamp of both ends; without rotation, the sliding one."""
    held = {"facets": "right", "at": [1.0, 0.0], "directions": ["x", "y", "rz"]}
    both = analysed(SLENDER, clamp={"facets": ["left", "right"]}, reduction={"modes": 2})
    found = analysed(SLENDER, rigid=[held], reduction={"modes": 2})
    np.testing.assert_allclose(found.modes.frequencies, both.modes.frequencies, rtol=1e-10)
    EI, rhoA = 2.1e11 * HEIGHT**2 / 12, 7800.0
    sliding = analysed(SLENDER, rigid=[{**held, "directions": ["rz"]}], reduction={"modes": 2})
    wanted = 2.36502**2 * np.sqrt(EI / rhoA) / (2 * np.pi)  # tan x + tanh x = 0
    assert sliding.modes.frequencies[0] == pytest.approx(wanted, rel=2e-3)


def test_shapes_and_attachments_move_the_facets_as_one_body() -> None:
    """In 3-D, of the massless and the Craig-Bampton reduction, whose frequencies agree."""
    rigid = [{"facets": "right", "at": [1.2, 0.0, 0.3], "mass": 2.0, "inertia": [0.1, 0.2, 0.1]}]
    groups = {"pad": {"box": {"from": [0.3, -1.0, 0.099], "to": [0.7, 1.0, 1.0]}}}
    contact = {**BEAM["contact"], "facets": "pad", "points": 2}
    common = {"rigid": rigid, "groups": groups, "contact": contact}
    free = analysed(BEAM, reduction={"modes": 4}, **common)
    held = analysed(BEAM, reduction={"modes": 8, "method": "craig-bampton"}, **common)
    x = free.solid.space.tabulate_dof_coordinates()
    at = x[:, 0] > 1 - 1e-9
    for found in (free, held):
        for shape in found.reduction.shapes.T:
            assert rigid_misfit(x[at], shape.reshape(-1, 3)[at]) < 1e-9
    residual = free.reduction.residual_shapes[:, 0].reshape(-1, 3)
    assert rigid_misfit(x[at], residual[at]) < 1e-6
    own = held.model.omega[:2] / (2 * np.pi)
    np.testing.assert_allclose(own, free.modes.frequencies[:2], rtol=2e-3)


def dense(matrix: PETSc.Mat) -> np.ndarray:
    copy = matrix.convert("dense", out=PETSc.Mat())
    return np.array(copy.getDenseArray())


def test_flexibility_of_full_order_against_dense_matrices() -> None:
    found = analysed(SLENDER, rigid=[RIGID], reduction={"modes": 3})
    solid, model, system = found.solid, found.model, found.solid.system
    K, M, T = (dense(matrix) for matrix in (system.stiffness, system.mass, system.way))
    B = found.interface.unit_forces(solid.owned).T @ T
    omega = 0.7 * model.omega[1]
    with HarmonicSolver(found, harmonics=3) as solver:
        D, _, _ = solver(omega).at(omega)
    tolerance = 1e-8 * np.abs(model.static_flexibility).max()  # round-off of the dense inverse
    for n in range(4):
        s = (n * omega) ** 2
        modal = (model.Phi / (model.omega**2 - s)) @ model.Phi.T
        wanted = B @ np.linalg.solve(K - s * M, B.T) - modal - model.R
        assert np.abs(D[n] - wanted).max() < tolerance
    assert np.abs(D[3]).max() > 1e3 * tolerance


def test_contact_points_that_move_together_are_refused_by_name() -> None:
    contact = {"facets": "right", "direction": [0.0, 1.0], "gap": 1e-3}
    for reduction in ({"modes": 2}, {"modes": 2, "method": "craig-bampton"}):
        with pytest.raises(ModelError, match=r"rigid: [24] contact motions depend on each other"):
            analysed(SLENDER, rigid=[RIGID], contact=contact, reduction=reduction)


BAD = [
    ({"inertia": [1.0, 1.0]}, "rigid.inertia"),
    ({"directions": ["z"]}, 'rigid.directions: "z" is no direction'),
    ({"at": [1.0]}, "rigid.at"),
]


@pytest.mark.parametrize(("change", "words"), BAD)
def test_rigid_facets_that_cannot_be(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        analysed(SLENDER, rigid=[{**RIGID, **change}])


def test_keys_that_are_wrong() -> None:
    for change, words in (({"mass": -1.0}, "mass"), ({"directions": ["x", "x"]}, "different")):
        with pytest.raises(StudyError, match=words):
            study_from({**SLENDER, "rigid": [{**RIGID, **change}]}, Path("study.toml"))
    with pytest.raises(StudyError, match=r"solver.linear = \"iterative\": does not go with rigid"):
        iterative = {"linear": "iterative"}
        study_from({**SLENDER, "rigid": [RIGID], "solver": iterative}, Path("study.toml"))


@pytest.mark.parametrize("turn", range(3))
def test_inertia_of_no_body_is_refused_and_that_of_a_plate_is_not(turn: int) -> None:
    """A thin plate has Jz = Jx + Jy; 0.1 + 0.2 is less than 0.3 in floating point, or more."""

    def study(moments: list[float]) -> Any:
        turned = moments[turn:] + moments[:turn]
        rigid = [{"facets": "right", "at": [1.0, 0.0, 0.0], "mass": 1.0, "inertia": turned}]
        return study_from({**BEAM, "rigid": rigid}, Path("study.toml"))

    assert study([0.1, 0.2, 0.3]).rigid and study([0.1, 0.2, 0.1 + 0.2]).rigid
    axis = "zyx"[turn]
    with pytest.raises(
        StudyError, match=rf"rigid.1..inertia = .*: no body has J{axis} = 0.31: .* two, 0.3$"
    ):
        study([0.1, 0.2, 0.31])
