"""Harmonic equations: derivatives against differences, energies against quadrature."""

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.energies import Energies
from fenics_nnm.nonlinear.equations import HarmonicEquations, harmonic_equations
from fenics_nnm.nonlinear.unknowns import Unknowns

OMEGA = 1.1


@pytest.fixture
def equations() -> HarmonicEquations:
    rng = np.random.default_rng(5)
    factor = rng.normal(size=(3, 3))
    model = ReducedModel(
        omega=[1.0, 2.7, 6.1, 9.4],
        Phi=rng.normal(size=(3, 4)),
        R=0.02 * (factor @ factor.T + np.eye(3)),
        gap=[0.4, 0.5, 0.6],
    )
    return harmonic_equations(model, CosineSeries(4, 41), Complementarity(model.R, model.gap))


@pytest.fixture
def motion(equations: HarmonicEquations) -> Array:
    q = 0.3 * np.random.default_rng(6).normal(size=equations.shape)
    assert len(equations.forces(Unknowns.of(q, OMEGA)).samples) > 5
    return q


def residual(equations: HarmonicEquations, q: Array, omega: float) -> Array:
    at = Unknowns.of(q, omega)
    return equations.residual(at, equations.forces(at)).ravel()


def energies_of(equations: HarmonicEquations, q: Array) -> Energies:
    at = Unknowns.of(q, OMEGA)
    return equations.energy.energies(at, equations.forces(at))


def test_jacobian_against_differences(equations: HarmonicEquations, motion: Array) -> None:
    omega, step = OMEGA, 1e-7
    at = Unknowns.of(motion, omega)
    jacobian = equations.jacobian(at, equations.forces(at))
    difference = np.empty_like(jacobian)
    for column in range(motion.size):
        change = np.zeros(motion.size)
        change[column] = step
        ahead, behind = motion + change.reshape(motion.shape), motion - change.reshape(motion.shape)
        difference[:, column] = (
            residual(equations, ahead, omega) - residual(equations, behind, omega)
        ) / (2 * step)
    assert np.abs(jacobian - difference).max() < 1e-6 * np.abs(jacobian).max()


def test_frequency_column_against_differences(equations: HarmonicEquations, motion: Array) -> None:
    omega, step = OMEGA, 1e-6
    at = Unknowns.of(motion, omega)
    column = equations.slopes(at, equations.forces(at))[0].ravel()
    difference = (
        residual(equations, motion, omega + step) - residual(equations, motion, omega - step)
    ) / (2 * step)
    assert np.abs(column - difference).max() < 1e-6 * np.abs(column).max()


def test_gamma_gradient_against_differences(equations: HarmonicEquations, motion: Array) -> None:
    energy, step = equations.energy, 1e-6
    gradient = energy.gamma_gradient(Unknowns.of(motion, OMEGA))
    assert gradient.omega == 0
    for index in np.ndindex(motion.shape):
        change = np.zeros_like(motion)
        change[index] = step
        difference = (
            energy.gamma(Unknowns.of(motion + change, OMEGA))
            - energy.gamma(Unknowns.of(motion - change, OMEGA))
        ) / (2 * step)
        assert gradient.q[index] == pytest.approx(difference, abs=1e-8)


def test_mass_energy_is_the_mean_of_the_velocity_squared(
    equations: HarmonicEquations, motion: Array
) -> None:
    phase = 2 * np.pi * np.arange(200) / 200
    velocity = equations.series.rate_at(phase) @ motion  # d q / d (omega t)
    energies = energies_of(equations, motion)
    assert energies.mass == pytest.approx(np.mean(np.sum(velocity**2, axis=1)), rel=1e-12)


def test_stiffness_energy_holds_modal_and_residual_parts(
    equations: HarmonicEquations, motion: Array
) -> None:
    samples, model = equations.series.samples, equations.model
    q = equations.series.basis_at(2 * np.pi * np.arange(samples) / samples) @ motion
    force = equations.law(q @ model.Phi.T).force
    strain = np.sum((model.omega * q) ** 2, axis=1) + np.einsum(
        "sc,cd,sd->s", force, model.R, force
    )
    energies = energies_of(equations, motion)
    assert energies.stiffness == pytest.approx(np.mean(strain), rel=1e-12)


def test_virial_identity_holds_at_solutions_and_not_elsewhere(
    equations: HarmonicEquations, motion: Array
) -> None:
    energies = energies_of(equations, motion)
    assert energies.virial_error(1.0) > 1e-2
    branch = follow(
        equations.model, EnergyContinuation(0.9, 2.0, 0.1), HarmonicBalance(4, 64), mode=0
    )
    assert branch.complete
    for point in branch.points:
        assert point.balance.virial_error < 1e-9
        assert point.balance.complementarity < 1e-10
    last = branch.points[-1]
    assert (
        last.motion.frequency > 1.01 * last.motion.rayleigh_frequency
    )  # the frequency is not sqrt(r)
