"""Craig-Bampton with the augmented Lagrangian, against the massless boundary and itself."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch, EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.geometry.blade import Blade
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.penalty_law import AugmentedLagrangian
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop, PenalisedEnergy
from fenics_nnm.nonlinear.equations import HarmonicEquations, harmonic_equations
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import Study, read_study
from fenics_nnm.study.reduction import AnyReduction, CraigBamptonSection, MasslessSection

ROTOR37 = Path(__file__).parents[2] / "demos" / "rotor37" / "rotor37.toml"
RATIOS = EnergyContinuation(0.7, 2.0, 0.1)


@pytest.fixture(scope="module")
def rotor37() -> Study:
    """The blade of the demonstration, of a coarse mesh."""
    study = read_study(ROTOR37)
    assert isinstance(study.mesh, Blade)
    coarse = study.mesh.model_copy(update={"element_size": 0.006})
    return study.model_copy(update={"mesh": coarse})


def reduced(study: Study, reduction: AnyReduction) -> LinearAnalysis:
    return linear_analysis(study.model_copy(update={"reduction": reduction}), MPI.COMM_SELF)


@pytest.fixture(scope="module")
def contact_only(rotor37: Study) -> LinearAnalysis:
    return reduced(rotor37, CraigBamptonSection(interface="contact"))


def branch(model: ReducedModel, **multipliers: object) -> Branch:
    found = follow(
        model,
        RATIOS,
        HarmonicBalance(5, 128, multipliers=MultiplierLoop(**multipliers)),
        mode=0,
    )
    assert found.complete
    return found


def ratios(found: Branch) -> Array:
    """Frequency ratios at the energies asked for, without those of halved steps."""
    by_energy = {point.gamma_ratio: point.frequency_ratio for point in found.points}
    return np.array([by_energy[ratio] for ratio in RATIOS.targets()])


@pytest.fixture(scope="module")
def all_directions(rotor37: Study) -> LinearAnalysis:
    return reduced(rotor37, CraigBamptonSection())


@pytest.fixture(scope="module")
def massless(rotor37: Study) -> LinearAnalysis:
    return reduced(rotor37, MasslessSection())


@pytest.fixture(scope="module")
def default(contact_only: LinearAnalysis) -> Array:
    return ratios(branch(contact_only.model))


def test_basis_holds_the_retained_coordinates_and_the_fixed_modes(
    all_directions: LinearAnalysis, contact_only: LinearAnalysis
) -> None:
    assert contact_only.model.modes == 24 + 40
    assert all_directions.model.modes == 72 + 40
    assert not contact_only.model.massless


def test_lowest_frequencies_are_those_of_the_body_from_above(contact_only: LinearAnalysis) -> None:
    body = contact_only.modes.omega[:5]
    error = contact_only.model.omega[:5] / body - 1
    assert error.min() > 0
    assert error.max() < 1e-4


def test_static_flexibility_of_the_contact_points_is_exact(
    massless: LinearAnalysis, contact_only: LinearAnalysis
) -> None:
    def static(model: ReducedModel) -> Array:
        scaled = model.Phi / model.omega
        return scaled @ scaled.T + model.R

    exact = static(massless.model)
    np.testing.assert_allclose(static(contact_only.model), exact, atol=1e-8 * exact.max())


def test_frequencies_agree_with_the_massless_boundary(
    massless: LinearAnalysis, default: Array
) -> None:
    assert np.abs(default / ratios(branch(massless.model)) - 1).max() < 5e-3
    assert default[-1] > 1.005


def test_all_directions_agree_with_the_contact_direction(
    all_directions: LinearAnalysis, default: Array
) -> None:
    np.testing.assert_allclose(ratios(branch(all_directions.model)), default, rtol=1e-5)


@pytest.mark.parametrize("penalty", [1.0, 100.0])
def test_branch_does_not_depend_on_the_first_penalty(
    contact_only: LinearAnalysis, default: Array, penalty: float
) -> None:
    found = ratios(branch(contact_only.model, penalty=penalty))
    np.testing.assert_allclose(found, default, rtol=1e-8)


@pytest.mark.parametrize("algorithm", ["simultaneous", "sequential"])
def test_literal_form_agrees_with_the_exact_row(
    contact_only: LinearAnalysis, default: Array, algorithm: str
) -> None:
    found = branch(contact_only.model, normalisation="penalised", algorithm=algorithm)
    np.testing.assert_allclose(ratios(found), default, rtol=1e-6)


def test_every_point_obeys_virial_and_signorini(contact_only: LinearAnalysis) -> None:
    for point in branch(contact_only.model).points:
        assert point.balance.virial_error < 10 * 1e-10
        assert point.balance.complementarity < 10 * 1e-10


def test_stalled_loop_names_the_measure(contact_only: LinearAnalysis) -> None:
    found = follow(
        contact_only.model,
        EnergyContinuation(0.9, 1.5, 0.3, smallest_step=0.2),
        HarmonicBalance(5, 64, multipliers=MultiplierLoop(iterations=2)),
        mode=0,
    )
    assert not found.complete
    assert "the multiplier loop stalled after 2 steps: the contact measure stays at" in found.reason


@pytest.fixture
def equations() -> HarmonicEquations:
    rng = np.random.default_rng(11)
    model = ReducedModel(
        omega=[1.0, 2.7, 6.1],
        Phi=rng.normal(size=(2, 3)),
        R=np.zeros((2, 2)),
        gap=[0.3, 0.4],
        contact=MASSIVE,
    )
    series = CosineSeries(4, 33)
    kappa = rng.uniform(1, 5, size=(len(series.phase), 2))
    theta = 0.02 * rng.normal(size=kappa.shape)
    return harmonic_equations(model, series, AugmentedLagrangian(model.gap, kappa, theta))


def test_jacobian_under_the_penalty_law_against_differences(equations: HarmonicEquations) -> None:
    q, omega, step = 0.3 * np.random.default_rng(12).normal(size=equations.shape), 1.1, 1e-7
    at = Unknowns.of(q, omega)
    forces: ContactForces = equations.forces(at)
    assert len(forces.samples) > 3
    jacobian = equations.jacobian(at, forces)
    for column in range(q.size):
        change = np.zeros(q.size)
        change[column] = step
        ends = [Unknowns.of(q + s * change.reshape(q.shape), omega) for s in (1, -1)]
        ahead, behind = (equations.residual(e, equations.forces(e)).ravel() for e in ends)
        difference = (ahead - behind) / (2 * step)
        assert np.abs(jacobian[:, column] - difference).max() < 1e-6 * np.abs(jacobian).max()


@pytest.mark.parametrize("base", [None, 1.2])
def test_penalised_energy_against_differences(
    equations: HarmonicEquations, base: float | None
) -> None:
    q, omega, step = 0.3 * np.random.default_rng(13).normal(size=equations.shape), 1.1, 1e-6
    constraint = PenalisedEnergy(gamma=0.2, kappa=3.0, theta=-0.01, base=base)
    by = constraint.gradient(equations, Unknowns.of(q, omega))
    for index in np.ndindex(q.shape):
        change = np.zeros_like(q)
        change[index] = step
        ahead, behind = (
            constraint.value(equations, Unknowns.of(q + s * change, omega)) for s in (1, -1)
        )
        assert by.q[index] == pytest.approx((ahead - behind) / (2 * step), abs=1e-6)
    ahead, behind = (constraint.value(equations, Unknowns.of(q, omega + s * step)) for s in (1, -1))
    assert by.omega == pytest.approx((ahead - behind) / (2 * step), rel=1e-6)


def test_loop_is_a_frozen_configuration() -> None:
    assert replace(MultiplierLoop(), penalty=3.0).alpha == 4.0
