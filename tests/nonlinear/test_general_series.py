"""General Fourier series against the time-reversible one, which it does not assume."""

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch, EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.conditions import FixedEnergy
from fenics_nnm.nonlinear.equations import harmonic_equations
from fenics_nnm.nonlinear.newton import solve
from fenics_nnm.nonlinear.unknowns import Unknowns

MODEL = ReducedModel(
    omega=[1.0, 2.62, 6.31],
    Phi=[[1.0, -0.6, 0.5], [0.7, 0.4, -0.8]],
    R=[[0.06, 0.02], [0.02, 0.05]],
    gap=[1.0, 0.9],
)


def branch(*, general: bool) -> Branch:
    energies = EnergyContinuation(0.9, 2.0, 0.1)
    found = follow(MODEL, energies, HarmonicBalance(8, 64, general=general), mode=0)
    assert found.complete
    return found


def test_frequencies_and_energies_agree() -> None:
    pairs = zip(branch(general=True).points, branch(general=False).points, strict=True)
    for general, reversible in pairs:
        assert general.motion.frequency == pytest.approx(reversible.motion.frequency, rel=1e-8)
        assert general.motion.energy == pytest.approx(reversible.motion.energy, rel=1e-8)
        assert general.balance.penetration == pytest.approx(
            reversible.balance.penetration, abs=1e-8
        )
        assert general.motion.contact_fraction == pytest.approx(reversible.motion.contact_fraction)
        assert general.returned.after_one == pytest.approx(reversible.returned.after_one, abs=1e-6)


def shifted(series: FourierSeries, q: Array, phase: float) -> Array:
    """The same motion begun later, in a series of the same length."""
    return series.analysis @ (series.basis_at(series.phase + phase) @ q)


def test_motion_is_time_reversible_though_nothing_assumed_it() -> None:
    """Begun from a shifted and disturbed guess, it is even about some instant."""
    point = branch(general=False).points[-1]
    scaled, scales = MODEL.dimensionless()
    series = FourierSeries(8, 64)
    equations = harmonic_equations(scaled, series, Complementarity(scaled.R, scaled.gap))
    start = np.vstack([point.motion.q / scales.amplitude, np.zeros((8, 3))])
    guess = shifted(series, start, 2 * np.pi / 64 * 3)
    guess += 1e-3 * np.random.default_rng(3).normal(size=guess.shape)
    at = Unknowns.of(start, point.frequency_ratio)
    gamma = equations.energy.gamma(at)
    solution = solve(equations, FixedEnergy(gamma), Unknowns.of(guess, point.frequency_ratio))
    assert solution.converged
    assert solution.omega == pytest.approx(point.frequency_ratio, rel=2e-4)
    # shift back so that the followed mode has no first sine: all sines are small then
    first = np.arctan2(solution.q[9, 0], solution.q[1, 0])
    even = shifted(series, solution.q, first)
    assert np.abs(even[9:]).max() < 5e-3 * np.abs(even).max()
    assert np.abs(even[:9] - start[:9]).max() < 5e-3


def test_rotation_is_the_derivative() -> None:
    series, step = FourierSeries(4, 16), 1e-6
    q = np.random.default_rng(1).normal(size=(9, 2))
    phase = np.array([0.2, 1.7, 4.0])
    difference = (series.basis_at(phase + step) - series.basis_at(phase - step)) @ q / (2 * step)
    np.testing.assert_allclose(
        series.basis_at(phase) @ series.rotation() @ q, difference, atol=1e-8
    )
    np.testing.assert_allclose(series.rate_at(phase) @ q, difference, atol=1e-8)


def test_analysis_undoes_synthesis_and_truncation_keeps_cosines_and_sines() -> None:
    series = FourierSeries(4, 16)
    q = np.random.default_rng(2).normal(size=(9, 2))
    np.testing.assert_allclose(series.analysis @ (series.synthesis @ q), q, atol=1e-14)
    shorter, longer = FourierSeries(2, 16), FourierSeries(6, 16)
    phase = np.array([0.3])
    np.testing.assert_allclose(
        longer.basis_at(phase) @ longer.fitted(q), series.basis_at(phase) @ q, atol=1e-14
    )
    np.testing.assert_array_equal(shorter.fitted(q), q[[0, 1, 2, 5, 6]])


def test_jacobian_with_drift_against_differences() -> None:
    scaled, _ = MODEL.dimensionless()
    equations = harmonic_equations(
        scaled, FourierSeries(3, 24), Complementarity(scaled.R, scaled.gap)
    )
    q = 0.5 * np.random.default_rng(4).normal(size=equations.shape)
    omega, drift, step = 1.1, 0.3, 1e-7
    at = Unknowns.of(q, omega, drift)
    jacobian = equations.jacobian(at, equations.forces(at))
    assert len(equations.forces(at).samples) > 3
    for column in range(q.size):
        change = np.zeros(q.size)
        change[column] = step
        ends = [Unknowns.of(q + s * change.reshape(q.shape), omega, drift) for s in (1, -1)]
        ahead, behind = (equations.residual(end, equations.forces(end)).ravel() for end in ends)
        difference = (ahead - behind) / (2 * step)
        assert np.abs(jacobian[:, column] - difference).max() < 1e-6 * np.abs(jacobian).max()
