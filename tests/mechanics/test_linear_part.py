"""Linear part with terms of the velocity, and forces as terms: products, inverses, derivatives."""

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import CubicSprings, SampledMotion
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries
from fenics_nnm.mechanics.linear_part import LinearPart, ModalPart, RatedPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.condensed import condensed_solution
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.unknowns import Unknowns

OMEGA, MODES = 1.13, 4
NATURAL = np.array([1.0, 2.7, 4.1, 6.3])
RNG = np.random.default_rng(3)
RATE = 0.1 * RNG.normal(size=(MODES, MODES))


@pytest.mark.parametrize("drift", [0.0, 0.07])
def test_without_rate_the_rated_part_is_the_modal_one(drift: float) -> None:
    series = FourierSeries(5, 32)
    modal = ModalPart(NATURAL).at(series, OMEGA, drift)
    rated = RatedPart(NATURAL, np.zeros((MODES, MODES))).at(series, OMEGA, drift)
    q = RNG.normal(size=(3, 11, MODES))
    np.testing.assert_allclose(rated.times(q), modal.times(q), atol=1e-12)
    shapes = RNG.normal(size=(2, MODES))
    assert not modal.kept.any()
    np.testing.assert_allclose(rated.solve(q), modal.solve(q), atol=1e-12)
    np.testing.assert_allclose(rated.flexibility(shapes), modal.flexibility(shapes), atol=1e-12)


@pytest.mark.parametrize("part", [ModalPart(NATURAL), RatedPart(NATURAL, RATE)])
def test_matrix_inverse_and_slope_belong_to_the_product(part: LinearPart) -> None:
    series, step = FourierSeries(5, 32), 1e-6
    operator = part.at(series, OMEGA, 0.05)
    q = RNG.normal(size=(11, MODES))
    matrix = np.zeros((11 * MODES, 11 * MODES))
    operator.add_to(matrix)
    np.testing.assert_allclose(matrix @ q.ravel(), operator.times(q).ravel(), atol=1e-12)
    np.testing.assert_allclose(operator.solve(operator.times(q[None]))[0], q, atol=1e-12)
    ends = [part.at(series, OMEGA + s * step, 0.05).times(q) for s in (1, -1)]
    slope = (ends[0] - ends[1]) / (2 * step)
    np.testing.assert_allclose(operator.by_omega(q), slope, atol=1e-6 * np.abs(slope).max())


def test_rated_part_is_that_of_the_differential_equation() -> None:
    """Lambda q + q'' + C q' at the samples, from derivatives of the series."""
    series = FourierSeries(4, 32)
    q = RNG.normal(size=(9, MODES))
    motion = SampledMotion(series, q, OMEGA)
    balance = motion.displacement * NATURAL**2 + motion.acceleration + motion.velocity @ RATE.T
    operator = RatedPart(NATURAL, RATE).at(series, OMEGA)
    np.testing.assert_allclose(series.synthesis @ operator.times(q), balance, atol=1e-12)


def model() -> ReducedModel:
    return ReducedModel(
        NATURAL, RNG.normal(size=(2, MODES)), [[0.06, 0.02], [0.02, 0.05]], [0.5, 0.4]
    )


def equations(*, driven: bool, cubic: bool, rated: bool) -> HarmonicEquations:
    of = model()
    springs = CubicSprings(
        np.array([[0.5, -0.7, 0.2, 0.3], [0.1, 0.4, 0.6, -0.2]]), np.array([0.8, 0.3])
    )
    push = Excitation(1, np.array([0.2, 0.1, 0.0, 0.0]), np.array([0.0, 0.3, 0.1, 0.0]))
    linear = RatedPart(NATURAL, RATE) if rated else ModalPart(NATURAL)
    mechanics = Mechanics(
        of, of.at_rest(), linear, (springs,) if cubic else (), (push,) if driven else ()
    )
    return HarmonicEquations(mechanics, FourierSeries(3, 24), Complementarity(of.R, of.gap))


@pytest.mark.parametrize("cubic", [False, True])
@pytest.mark.parametrize("rated", [False, True])
@pytest.mark.parametrize("driven", [False, True])
def test_every_derivative_with_terms_against_differences(
    driven: bool, cubic: bool, rated: bool
) -> None:
    of, step = equations(driven=driven, cubic=cubic, rated=rated), 1e-7
    q = 0.5 * RNG.normal(size=of.shape)
    drift = () if driven else (0.3,)
    assert of.parameters == (("omega",) if driven else ("omega", "drift"))
    at = Unknowns.of(q, OMEGA, *drift)
    assert len(of.forces(at).samples) > 3

    def residual(x: Array, *parameters: float) -> Array:
        there = Unknowns.of(x, *parameters)
        return of.residual(there, of.forces(there)).ravel()

    parameters = (OMEGA, *drift)
    changes = step * np.eye(q.size).reshape(-1, *q.shape)
    difference = np.array(
        [
            (residual(q + d, *parameters) - residual(q - d, *parameters)) / (2 * step)
            for d in changes
        ]
    ).T
    jacobian = of.jacobian(at, of.forces(at))
    assert np.abs(jacobian - difference).max() < 1e-6 * np.abs(jacobian).max()
    for number, slope in enumerate(of.slopes(at, of.forces(at))):
        ends = [
            residual(q, *(p + s * step * (i == number) for i, p in enumerate(parameters)))
            for s in (1, -1)
        ]
        found = (ends[0] - ends[1]) / (2 * step)
        assert np.abs(slope.ravel() - found).max() < 1e-6 * np.abs(found).max()


def test_condensed_solution_with_a_rate_is_that_of_the_full_jacobian() -> None:
    of = equations(driven=True, cubic=False, rated=True)
    at = Unknowns.of(0.5 * RNG.normal(size=of.shape), OMEGA)
    forces = of.forces(at)
    border = Border(
        columns=RNG.normal(size=(1, *of.shape)),
        rows=RNG.normal(size=(1, *of.shape)),
        corner=RNG.normal(size=(1, 1)),
        right=RNG.normal(size=of.shape),
        below=RNG.normal(size=1),
    )
    dense = border.dense_solution(of.jacobian(at, forces), np.ones(of.shape))
    found = condensed_solution(of.linear(at), of.series, of.model.Phi, forces, border)
    np.testing.assert_allclose(found, dense, atol=1e-10 * np.abs(dense).max())


def test_cubic_force_is_that_of_its_potential_and_exact_in_the_series() -> None:
    springs = CubicSprings(np.array([[0.5, -0.7, 0.2, 0.3]]), np.array([0.8]))
    q, v, step = RNG.normal(size=MODES), RNG.normal(size=MODES), 1e-6
    for j in range(MODES):
        d = step * np.eye(MODES)[j]
        slope = (springs.energy_at(q + d, v) - springs.energy_at(q - d, v)) / (2 * step)
        assert springs.at(q, v)[j] == pytest.approx(slope, rel=1e-7)
        column = (springs.at(q + d, v) - springs.at(q - d, v)) / (2 * step)
        np.testing.assert_allclose(springs.tangent_at(q, v, v)[0][:, j], column, rtol=1e-6)
    a = RNG.normal(size=(4, MODES))
    few, many = (SampledMotion(CosineSeries(3, m), a, 1.0) for m in (13, 400))
    np.testing.assert_allclose(springs.harmonics(few), springs.harmonics(many), atol=1e-13)
    # Parseval: the mean of force times motion is four times the mean potential
    assert springs.mean_virial(many) == pytest.approx(4 * springs.mean_energy(many))
    unit = springs.scaled(2.0, 5.0)
    assert unit.energy_at(q, v) == pytest.approx(springs.energy_at(2.0 * q, v) / 5.0)
