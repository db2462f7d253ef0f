"""Static modal derivatives of bodies: derivatives, foreshortening, curvature of obstacles."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, changed
from mpi4py import MPI

from fenics_nnm.fem.deflection import BodyForces, FormDeflection
from fenics_nnm.fem.linear import operators_of
from fenics_nnm.fem.loaded_residual import LoadedResidual
from fenics_nnm.fem.loads import Loads
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.obstacle_curvature import obstacle_closing
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.modal_derivatives import ModalDerivatives, by_triples, modal_derivatives
from fenics_nnm.reduction.operators import Operators
from fenics_nnm.stages import Stages
from fenics_nnm.structure.bending import deflection_of
from fenics_nnm.structure.mesh_structure import MeshLinear, MeshStructure
from fenics_nnm.structure.point_choice import chosen_of
from fenics_nnm.study import MeshStudy, study_from

#: A slender cantilever in plane stress whose tip can touch beyond its end.
SLENDER: dict[str, Any] = changed(
    PLATE,
    {
        "mesh": {"height": 0.01, "elements": [20, 1]},
        "contact": {"direction": [1.0, 0.0], "points": 1},
        "reduction": {"modes": 3},
    },
)


#: Material axes that are not those of the body.
AXES = {"axes": [[0.0, 1.0, 0.0], [0.6, 0.0, 0.8]]}


def layered(orientation: dict[str, Any]) -> dict[str, Any]:
    """A material with three moduli, along axes."""
    material = {
        "young": [126e9, 11e9, 9e9],
        "poisson": [0.28, 0.40, 0.28],
        "shear": [6.6e9, 3.9e9, 6.6e9],
        "density": 1600.0,
        "orientation": orientation,
    }
    return {"=": material}


def solid_of(base: dict[str, Any], **changes: Any) -> Solid:
    study = study_from(changed(base, changes), Path("study.toml"))
    assert isinstance(study, MeshStudy)
    return MeshStructure(study).assembled(MPI.COMM_SELF, Stages()).solid


def derivatives_of(linear: MeshLinear, masters: np.ndarray) -> ModalDerivatives:
    with DirectModalSolver(linear.solid) as solver:
        operators = operators_of(linear.solid, linear.interface, solver)
        return modal_derivatives(linear.reduction, masters, operators, deflection_of(linear))


@pytest.mark.parametrize("changes", [{}, {"rotation": {"axis": [0.0, 1.0, 1.0], "speed": 900.0}}])
def test_derivatives_of_the_internal_force(changes: dict[str, Any]) -> None:
    """f''[a, b] is the change of K_T b along a, f''' that of f''."""
    solid = solid_of(BEAM, mesh={"elements": [1, 1, 1]}, **changes)
    rng = np.random.default_rng(4)
    a, b, c = rng.normal(size=(3, solid.owned))
    for each in (a, b, c):
        each[solid.clamped] = 0.0
    loads = solid.state.loads if solid.state else Loads()
    at = solid.state.owned(solid.owned) if solid.state else np.zeros(solid.owned)
    plain = solid_of(BEAM, mesh={"elements": [1, 1, 1]})
    residual = LoadedResidual(plain, loads)
    residual.apply(1.0)

    def stiff(step: float) -> np.ndarray:
        residual.move(at + step * a)
        right, left = residual.assemble().createVecs()
        right.array[:] = b
        residual.tangent.mult(right, left)
        return np.array(left.array)

    # K_T is quadratic in u, so that differences of any step are exact but for round-off
    deflection = FormDeflection(solid)
    second = (stiff(0.1) - stiff(-0.1)) / 0.2
    size = np.abs(second).max()
    pairs = BodyForces(solid).second(np.column_stack([a, 1e4 * b]))
    assert pairs[:, 1] / 1e4 == pytest.approx(second, abs=1e-9 * size)
    assert deflection.second(a) == pytest.approx(pairs[:, 0], rel=1e-12)
    third = (stiff(0.1) - 2 * stiff(0.0) + stiff(-0.1)) / 0.01
    assert deflection.third(a, a, b) == pytest.approx(third, abs=1e-8 * np.abs(third).max())
    assert deflection.third(a, b, c) == pytest.approx(deflection.third(c, a, b), rel=1e-9, abs=1e-3)


@pytest.mark.parametrize(
    ("base", "changes"),
    [
        (BEAM, {"material": layered(AXES), "rotation": {"axis": [0.0, 1.0, 1.0], "speed": 900.0}}),
        (BEAM, {"material": layered({"cylindrical": "x", "origin": [0.0, 0.0, -1.0]})}),
        (PLATE, {"body": {"theory": "plane-strain"}}),
        (ROD, {}),
    ],
)
def test_third_derivatives_along_masters(base: dict[str, Any], changes: dict[str, Any]) -> None:
    """From gradients at points they are those of the residual's form, for all theories."""
    solid = solid_of(base, **changes)
    phi = np.random.default_rng(6).normal(size=(solid.owned, 3))
    phi[solid.clamped] = 0.0
    form = FormDeflection(solid)
    wanted = by_triples(form.third, lambda a, b: a.T @ b, phi)
    found = BodyForces(solid).third(phi)
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max())


def test_static_displacements_are_made_once_for_the_same_masters() -> None:
    """Also where a model is made again with other contact points, and other functions."""
    solid = solid_of(BEAM, mesh={"elements": [1, 1, 1]})
    phi = np.random.default_rng(7).normal(size=(solid.owned, 2))
    forces, made = BodyForces(solid), []

    def times(factor: float, columns: np.ndarray) -> np.ndarray:
        made.append((factor, columns.shape[1]))
        return factor * columns

    for shapes in (phi, phi.copy(), phi[:, :1], phi[:, :1]):
        static, mass = (partial(times, factor) for factor in (2.0, 3.0))
        kept = forces.remembering(Operators(mass, mass, static, mass, np.dot), "factors")
        found = kept.mass(kept.static(forces.second(shapes)))
        assert found == pytest.approx(6 * forces.second(shapes), rel=1e-15)
    assert made == [(2.0, 3), (3.0, 3), (2.0, 1), (3.0, 1)]


def test_a_bending_cantilever_draws_its_tip_in() -> None:
    """By 0.580972, 4.052175, 9.662361 a^2 / L in modes 1, 2, 3 of tip amplitude a."""
    for mode, exact in enumerate((0.580972, 4.052175, 9.662361)):
        bent = {"body": {"kinematics": "second-order"}, "mode": {"number": mode + 1}}
        study = study_from(changed(SLENDER, bent), Path("study.toml"))
        assert isinstance(study, MeshStudy)
        linear = MeshStructure(study).linear(MPI.COMM_SELF, Stages())
        derivatives = derivatives_of(linear, np.array([mode]))
        x = linear.solid.space.tabulate_dof_coordinates()
        tip = int(np.argmax(x[:, 0]))
        amplitude = linear.reduction.shapes[2 * tip + 1, mode]
        drawn = -derivatives.order.Theta[0, 0, 0] / 2
        # what axial modes share of the derivative is theirs in the reduced model
        assert drawn / amplitude**2 == pytest.approx(exact, rel=1e-2)
        # those of the study are the same, of its own factors
        for name, tensor in linear.model.kinematics.tensors.items():
            own = derivatives.order.tensors[name]
            assert tensor == pytest.approx(own, rel=1e-6, abs=1e-9 * np.abs(own).max()), name


def test_tensors_are_those_of_the_potential() -> None:
    """alpha and beta are derivatives of the potential along the second-order displacement."""
    study = study_from(
        changed(PLATE, {"reduction": {"modes": 3}, "mesh": {"elements": [3, 1]}}), Path("s.toml")
    )
    assert isinstance(study, MeshStudy)
    linear = MeshStructure(study).linear(MPI.COMM_SELF, Stages())
    masters = np.array([0, 1])
    derivatives = derivatives_of(linear, masters)
    solid, phi = linear.solid, linear.reduction.shapes[:, masters]
    residual = LoadedResidual(solid, Loads())
    x = np.array([0.7, -0.4])

    def work(s: float) -> float:
        """Derivative of the potential by s along u(s x), u with second order."""
        residual.move(s * phi @ x + s**2 * derivatives.displacement(x))
        along = phi @ x + 2 * s * derivatives.displacement(x)
        return float(residual.value() @ along)

    # powers of s up to 7; those of alpha and beta are 2 and 3
    s = np.linspace(-1, 1, 8)
    powers = np.linalg.solve(np.vander(s, increasing=True), [work(each) for each in s])
    order = derivatives.order
    alpha = np.einsum("ijk,i,j,k->", order.alpha[masters], x, x, x)
    beta = np.einsum("ijkl,i,j,k,l->", order.beta, x, x, x, x)
    assert powers[1] == pytest.approx(np.sum((linear.model.omega[masters] * x) ** 2), rel=1e-6)
    assert powers[2] == pytest.approx(alpha, rel=1e-5, abs=1e-8 * abs(powers[1]))
    assert powers[3] == pytest.approx(beta, rel=1e-5)


def test_a_round_casing_curves_towards_what_moves_along_it() -> None:
    """A point at radius r that moves by t along the casing comes nearer by t^2 / (2 r)."""
    contact = {"facets": "right", "direction": "radial", "axis": "x", "origin": [0.0, 0.0, -1.0]}
    study = study_from(changed(BEAM, {"contact": contact, "reduction": {"modes": 2}}), Path("s"))
    assert isinstance(study, MeshStudy)
    linear = MeshStructure(study).linear(MPI.COMM_SELF, Stages())
    points, phi = linear.interface.points, linear.reduction.shapes[:, [0, 1]]
    moved = linear.interface.displacements(phi)
    found = obstacle_closing(linear.interface, linear.sites, chosen_of(linear.choices), phi)
    away = points - np.array([0.0, 0.0, -1.0])
    r = np.hypot(away[:, 1], away[:, 2])
    t = (-moved[:, 1] * away[:, 2, None] + moved[:, 2] * away[:, 1, None]) / r[:, None]
    assert found == pytest.approx(t[:, :, None] * t[:, None, :] / r[:, None, None], rel=1e-6)
