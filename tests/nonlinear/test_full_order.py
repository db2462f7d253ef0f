"""Full order: harmonic equations without reduction, on matrices small enough to solve directly."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import eigh

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch, EnergyContinuation, FullOrder, ReducedOrder, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.penalty_law import AugmentedLagrangian
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop
from fenics_nnm.nonlinear.equations import harmonic_equations
from fenics_nnm.nonlinear.full_order import FullOrderEquations
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.reduction.flexibility import ResidualFlexibility
from fenics_nnm.reduction.massless import massless_model
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.reduction.matrix_analysis import matrix_analysis
from fenics_nnm.reduction.truncation import MasslessTruncation

HARMONICS, SAMPLES = 5, 64


@dataclass(frozen=True)
class Chain:
    """A clamped-free chain of 40 masses on a tapered bar; three of them can touch."""

    K: Array
    M: Array
    B: Array
    gap: Array

    def modes(self, count: int) -> tuple[Array, Array]:
        squared, shapes = eigh(self.K, self.M)
        shapes *= np.sign((self.B @ shapes)[0])
        return np.sqrt(squared[:count]), shapes[:, :count]

    def model(self, count: int) -> ReducedModel:
        omega, shapes = self.modes(count)
        S = self.B @ np.linalg.solve(self.K, self.B.T)
        return massless_model(omega, self.B @ shapes, S, self.gap)

    def source(self, count: int) -> Callable[[float], ResidualFlexibility]:
        """D of the modes above `count`, from the dense matrices by the formulas of D itself."""
        squared, shapes = eigh(self.K, self.M)
        rest, Phi = squared[count:], self.B @ shapes[:, count:]

        def at(omega: float) -> ResidualFlexibility:
            s = (np.arange(HARMONICS + 1) * omega) ** 2
            weights = [
                [(1 / (rest - each) - 1 / rest) for each in s],
                [1 / (rest - each) ** 2 for each in s],
                [1 / (rest - each) ** 3 for each in s],
            ]
            parts = [np.array([(Phi * w) @ Phi.T for w in rows]) for rows in weights]
            return ResidualFlexibility(s, *parts)

        return at


@pytest.fixture(scope="module")
def chain() -> Chain:
    size = 40
    stiffness = 40.0 * (1.3 - np.arange(size) / size)
    K = np.diag(stiffness + np.append(stiffness[1:], 0.0))
    K -= np.diag(stiffness[1:], 1) + np.diag(stiffness[1:], -1)
    off = np.full(size - 1, 1 / 6)
    M = (np.diag(np.full(size, 2 / 3)) + np.diag(off, 1) + np.diag(off, -1)) / size
    B = np.zeros((3, size))
    B[[0, 1, 2], [39, 37, 33]] = 1.0
    return Chain(K, M, B, np.array([1.0, 0.97, 0.96]))


def branch(
    chain: Chain,
    modes: int,
    *,
    full: bool,
    mass: bool = False,
    truncation: MasslessTruncation | None = None,
) -> Branch:
    return follow(
        chain.model(modes),
        EnergyContinuation(0.8, 2.0, 0.2),
        HarmonicBalance(HARMONICS, SAMPLES, multipliers=MultiplierLoop() if mass else None),
        mode=0,
        order=FullOrder(chain.source(modes)) if full else ReducedOrder(truncation),
    )


def equations_at(chain: Chain, omega: float, kind: str, series: Series) -> FullOrderEquations:
    """Dimensionless equations of either variant about a frequency."""
    model, flexibility = chain.model(4), chain.source(4)(omega)
    if kind == "massless boundary":
        law = Complementarity(model.R, model.gap)
        return FullOrderEquations(harmonic_equations(model, series, law), flexibility)
    none = np.zeros_like(model.R)
    free = ReducedModel(model.omega, model.Phi, none, model.gap, contact=MASSIVE)
    shape = (len(series.phase), 3)
    spring = AugmentedLagrangian(model.gap, np.full(shape, 80.0), np.full(shape, 0.05))
    return FullOrderEquations(
        harmonic_equations(free, series, spring), flexibility.with_static(model.R)
    )


@pytest.mark.parametrize("kind", ["massless boundary", "mass-carrying"])
@pytest.mark.parametrize("series", [CosineSeries(5, 32), FourierSeries(5, 32)])
def test_every_derivative_against_differences(chain: Chain, kind: str, series: Series) -> None:
    omega, drift, step = 1.07 * chain.modes(1)[0][0], 0.2 * series.free_phase, 1e-6
    equations = equations_at(chain, omega, kind, series)
    rng = np.random.default_rng(7)
    x = 1.5 * rng.normal(size=(len(series.order), 7)) / (1 + series.order[:, None])
    at = Unknowns.of(x, omega, *[drift] * series.free_phase)
    forces = equations.forces(at)
    assert len(forces.samples) > 5

    def moved(q: Array, frequency: float) -> Unknowns:
        return Unknowns.of(q, frequency, *at.parameters[1:])

    def residual(q: Array, frequency: float) -> Array:
        there = moved(q, frequency)
        return equations.residual(there, equations.forces(there)).ravel()

    def gamma(q: Array, frequency: float) -> float:
        return equations.energy.gamma(moved(q, frequency))

    changes = step * np.eye(x.size).reshape(-1, *x.shape)
    difference = np.array(
        [(residual(x + d, omega) - residual(x - d, omega)) / (2 * step) for d in changes]
    ).T
    jacobian = equations.jacobian(at, forces)
    assert np.abs(jacobian - difference).max() < 1e-6 * np.abs(jacobian).max()

    column = equations.slopes(at, forces)[0].ravel()
    difference = (residual(x, omega + step) - residual(x, omega - step)) / (2 * step)
    assert np.abs(column - difference).max() < 1e-6 * np.abs(column).max()

    by = equations.energy.gamma_gradient(at)
    difference = np.array(
        [(gamma(x + d, omega) - gamma(x - d, omega)) / (2 * step) for d in changes]
    )
    assert np.abs(by.q.ravel() - difference).max() < 1e-6 * np.abs(by.q).max()
    ends = [gamma(x, omega + sign * step) for sign in (1, -1)]
    assert by.omega == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)


def test_motion_solves_the_unreduced_equations(chain: Chain) -> None:
    """Signorini at every sample, with displacements straight from the dense matrices."""
    series = CosineSeries(HARMONICS, SAMPLES)
    modes = 4
    R = chain.model(modes).R
    for point in branch(chain, modes, full=True).points[2:]:  # beyond grazing
        omega = 2 * np.pi * point.motion.frequency
        ell = series.analysis @ point.motion.force
        dynamic = [chain.K - (n * omega) ** 2 * chain.M for n in range(HARMONICS + 1)]
        U = np.array(
            [-np.linalg.solve(Z, chain.B.T @ f) for Z, f in zip(dynamic, ell, strict=True)]
        )
        beyond = point.motion.force - series.synthesis @ ell
        w = series.synthesis @ U @ chain.B.T - beyond @ R
        assert (w - chain.gap).max() < 1e-8
        assert np.abs(point.motion.force * (w - chain.gap)).max() < 1e-8 * point.motion.force.max()
        n_squared = np.arange(HARMONICS + 1) ** 2
        mass = np.einsum("n,n,nx,xy,ny->", series.mean_square, n_squared, U, chain.M, U)
        stiffness = np.einsum("n,nx,xy,ny->", series.mean_square, U, chain.K, U)
        stiffness += series.weight @ np.einsum("sc,cd,sd->s", beyond, R, beyond)
        model = chain.model(modes)
        grazing = model.grazing_amplitude() ** 2 / 4
        assert mass / 2 == pytest.approx(point.gamma_ratio * grazing, rel=1e-8)
        assert np.sqrt(stiffness / mass) / 2 / np.pi == pytest.approx(
            point.motion.rayleigh_frequency, rel=1e-8
        )
        assert point.motion.energy == pytest.approx((stiffness + omega**2 * mass) / 2, rel=1e-8)
        assert point.balance.virial_error < 1e-9


def test_reduced_model_converges_to_full_order(chain: Chain) -> None:
    worst = []
    for modes in (3, 6, 20):
        pairs = zip(
            branch(chain, modes, full=False).points,
            branch(chain, modes, full=True).points,
            strict=True,
        )
        worst.append(max(abs(a.motion.frequency / b.motion.frequency - 1) for a, b in pairs))
    assert worst[0] > 5 * worst[1] > 50 * worst[2] > 0


def test_mass_at_the_contact_points(chain: Chain) -> None:
    massless, carrying = (branch(chain, 6, full=True, mass=mass) for mass in (False, True))
    assert carrying.complete
    for a, b in zip(massless.points, carrying.points, strict=True):
        assert b.balance.virial_error < 1e-9
        assert a.motion.frequency == pytest.approx(b.motion.frequency, rel=1e-2)
    assert carrying.points[-1].motion.frequency != pytest.approx(
        massless.points[-1].motion.frequency, rel=1e-6
    )


@pytest.mark.parametrize("modes", [6, 12, 20])
def test_error_of_the_reduction_predicts_the_difference(chain: Chain, modes: int) -> None:
    static = chain.source(modes)(0.0)
    truncation = MasslessTruncation(static.slope[0], static.curvature[0])
    reduced = branch(chain, modes, full=False, truncation=truncation).points
    full = branch(chain, modes, full=True).points
    for point, exact in list(zip(reduced, full, strict=True))[2:]:  # beyond grazing
        error = point.motion.frequency / exact.motion.frequency - 1
        assert point.expected.reduction.frequency == pytest.approx(error, rel=0.05)
        assert point.expected.reduction.residual > abs(error)


def craig_bampton_branch(chain: Chain, modes: int) -> Branch:
    analysis = matrix_analysis(
        Matrices(chain.K, chain.M, chain.B, chain.gap), modes=modes, method="craig-bampton"
    )
    return follow(
        analysis.model,
        EnergyContinuation(0.8, 2.0, 0.2),
        HarmonicBalance(HARMONICS, SAMPLES),
        mode=0,
        order=ReducedOrder(analysis.reduction.truncation),
    )


@pytest.mark.parametrize("modes", [8, 12])
def test_error_of_craig_bampton_predicts_the_difference(chain: Chain, modes: int) -> None:
    reduced = craig_bampton_branch(chain, modes).points
    full = branch(chain, 6, full=True, mass=True).points
    for point, exact in list(zip(reduced, full, strict=True))[2:]:
        error = point.motion.frequency / exact.motion.frequency - 1
        assert point.expected.reduction.frequency == pytest.approx(error, rel=0.15)
        assert point.expected.reduction.residual > abs(error)
