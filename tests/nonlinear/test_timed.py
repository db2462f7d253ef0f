"""Harmonic equations with exact integrals of contact forces: derivatives, work of contact."""

from typing import Any

import numpy as np
import pytest
from timed_derivatives import assert_derivatives

from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import CubicSprings
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.timed import TimedEquations
from fenics_nnm.nonlinear.unknowns import Unknowns

RNG = np.random.default_rng(5)
NATURAL, OMEGA = np.array([1.0, 2.7, 4.1]), 1.13
RATE, PHI = 0.1 * RNG.normal(size=(3, 3)), RNG.normal(size=(2, 3))
MOTION = RNG.normal(size=(17, 3)) * 0.5 / (1 + np.arange(17) % 9)[:, None]


def equations(*forces: Any) -> TimedEquations:
    model = ReducedModel(NATURAL, PHI, [[0.06, 0.02], [0.02, 0.05]], [0.5, 0.4])
    push = Excitation(1, np.array([0.2, 0.1, 0.0]), np.array([0.0, 0.3, 0.1]))
    mechanics = Mechanics(model, model.at_rest(), RatedPart(NATURAL, RATE), forces, (push,))
    return TimedEquations.of(mechanics, FourierSeries(8, 33))


@pytest.mark.parametrize("forces", [(), (CubicSprings(PHI[:1], np.array([0.8])),)])
def test_derivatives_against_differences(forces: tuple[Any, ...]) -> None:
    assert_derivatives(equations(*forces), MOTION, OMEGA)


def test_condensed_solution_is_that_of_the_full_jacobian() -> None:
    of = equations()
    at = Unknowns.of(0.4 * MOTION, OMEGA)
    forces = of.forces(at)
    assert 0 < np.count_nonzero(forces.used) < 0.6 * MOTION.size
    border = Border(
        columns=RNG.normal(size=(1, *MOTION.shape)),
        rows=RNG.normal(size=(1, *MOTION.shape)),
        corner=RNG.normal(size=(1, 1)),
        right=RNG.normal(size=MOTION.shape),
        below=RNG.normal(size=1),
    )
    dense = border.dense_solution(of.jacobian(at, forces), np.ones(MOTION.shape))
    found = of.solved(at, forces, border)
    np.testing.assert_allclose(found, dense, atol=1e-10 * np.abs(dense).max())


def test_contact_does_no_work_over_a_period() -> None:
    of = equations()
    at = Unknowns.of(MOTION, OMEGA)
    series = of.series
    force = of.forces(at).harmonics(series)
    rates = series.turned(MOTION) @ PHI.T
    work = np.sum(series.mean_square[:, None] * force * rates)
    size = np.sum(series.mean_square[:, None] * np.abs(force * rates))
    assert abs(work) < 1e-12 * size
    np.testing.assert_allclose(series.turned(MOTION), series.rotation() @ MOTION)
