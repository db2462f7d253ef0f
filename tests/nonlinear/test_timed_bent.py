"""Exact integrals of contact forces with second-order kinematics: derivatives, work, no bending."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from bent_body import BentBody
from timed_derivatives import assert_derivatives

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.moving_gap import GapMotion
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.nonlinear.timed import TimedEquations
from fenics_nnm.nonlinear.unknowns import Unknowns

RNG = np.random.default_rng(5)
MODEL = replace(
    BentBody.random(6, 2, seed=3).reduction(3, np.array([0, 2])).model, gap=np.array([0.5, 0.4])
)
RATE, OMEGA = 0.1 * RNG.normal(size=(3, 3)), 1.13
MOTION = RNG.normal(size=(13, 3)) * 0.5 / (1 + np.arange(13) % 7)[:, None]
TURNING = np.array([np.diag([0.3, -0.2]), [[0.1, 0.2], [0.2, 0.0]]])


def equations(model: ReducedModel = MODEL, turning: Array = TURNING) -> TimedEquations:
    push = Excitation(1, np.array([0.2, 0.1, 0.0]), np.array([0.0, 0.3, 0.1]), turning)
    gaps = GapMotion((2,), np.array([[0.05 + 0.02j, -0.03j]]))
    linear, forces = RatedPart(model.omega, RATE), model.kinematics.forces
    mechanics = Mechanics(model, model.at_rest(), linear, forces, (push,), gaps)
    return TimedEquations.of(mechanics, FourierSeries(6, 25))


def test_derivatives_against_differences() -> None:
    assert_derivatives(equations(), MOTION, OMEGA)


def test_only_what_is_given_and_damping_do_work_over_a_period() -> None:
    of = equations()
    at = Unknowns.of(MOTION, OMEGA)
    series, forces = of.series, of.forces(at)
    rates, mean = series.turned(MOTION), series.mean_square[:, None]
    closing, turned = of.sampled.closing, of.mechanics.turned[0]
    pushed = closing.pushed(forces.harmonics(series) @ MODEL.Phi, series, MOTION, forces)
    motion = SampledMotion(series, MOTION, OMEGA)
    gaps = series.turned(-of.given)
    work = np.sum(mean * pushed * rates) - np.sum(mean * forces.harmonics(series) * gaps)
    assert abs(work) < 1e-12 * np.sum(mean * np.abs(pushed * rates))
    for force in of.mechanics.forces:
        found = force.harmonics(motion)
        assert abs(np.sum(mean * found * rates)) < 1e-12 * np.sum(mean * np.abs(found * rates))
    put_in, size = turned.work(motion)
    assert abs(put_in + np.sum(mean * turned.harmonics(motion) * rates)) < 1e-12 * size


def test_without_second_order_terms_it_is_the_linear_case() -> None:
    order = MODEL.kinematics
    nothing = SecondOrder(order.masters, **{n: 0 * each for n, each in order.tensors.items()})
    bent = equations(replace(MODEL, kinematics=nothing), np.zeros((2, 2, 2)))
    mechanics = replace(bent.mechanics, model=MODEL.linearised, forces=())
    straight, at = TimedEquations.of(mechanics, bent.series), Unknowns.of(MOTION, OMEGA)
    residuals = [each.residual(at, each.forces(at)) for each in (bent, straight)]
    size = np.abs(residuals[1]).max()
    np.testing.assert_allclose(residuals[0], residuals[1], atol=1e-13 * size)
    jacobians = [each.jacobian(at, each.forces(at)) for each in (bent, straight)]
    size = np.abs(jacobians[1]).max()
    np.testing.assert_allclose(jacobians[0], jacobians[1], atol=1e-12 * size)
