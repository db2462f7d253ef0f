"""Solvers of a level: what they can fix, and when the flexibility of full order is renewed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from fenics_nnm.backbone.full_order_solver import FullOrderSolver, RenewedEquations
from fenics_nnm.backbone.level_solver import ComplementarySolver, Guess, MultiplierSolver
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop
from fenics_nnm.nonlinear.conditions import FixedEnergy, FixedFrequency
from fenics_nnm.nonlinear.equations import HarmonicEquations, harmonic_equations
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.reduction.flexibility import ResidualFlexibility

MODEL = ReducedModel(omega=[1.0, 3.4], Phi=[[1.0, 1.0]], R=[[0.1]], gap=[1.0])
NEWTON = Newton()
HARMONICS = 3
GAMMA = 0.25 * 1.5


@dataclass
class Left:
    """One mode of frequency `omega` that is left out, and where D was asked for."""

    omega: float = 30.0
    asked: list[float] = field(default_factory=list)

    def __call__(self, omega: float) -> ResidualFlexibility:
        self.asked.append(omega)
        square, s = self.omega**2, (np.arange(HARMONICS + 1) * omega) ** 2
        parts = [1 / (square - s) - 1 / square, 1 / (square - s) ** 2, 1 / (square - s) ** 3]
        return ResidualFlexibility(s, *(40.0 * part[:, None, None] for part in parts))


class Wavering(Left):
    """Another D each time that it is asked for."""

    def __call__(self, omega: float) -> ResidualFlexibility:
        found = Left.__call__(self, omega)
        part = 1.0 if len(self.asked) % 2 else 0.5
        parts = (found.value, found.slope, found.curvature)
        return ResidualFlexibility(found.centre, *(part * each for each in parts))


def equations() -> HarmonicEquations:
    law = Complementarity(MODEL.R, MODEL.gap)
    return harmonic_equations(MODEL, CosineSeries(HARMONICS, 64), law)


def guess(omega: float | None = None) -> Guess:
    """The motion of the reduced model, said to have a frequency."""
    q = np.zeros((HARMONICS + 1, 2))
    q[1, 0] = 1.2
    start = Guess(q, 1.0, np.zeros((33, 1)))
    found = ComplementarySolver().at_energy(equations(), start, gamma=GAMMA, newton=NEWTON)
    assert found.converged
    return Guess.of(found) if omega is None else replace(Guess.of(found), omega=omega)


def test_equations_are_the_same_while_the_flexibility_is_accurate() -> None:
    renewed = RenewedEquations(equations(), source := Left())
    first = renewed.about(1.0)
    assert renewed.about(1.0) is first and renewed.about(1.0 + 1e-6) is first
    assert renewed.about(1.5) is not first
    assert source.asked == [1.0, 1.5]


def test_full_order_solution_does_not_depend_on_where_the_flexibility_began() -> None:
    found = [
        FullOrderSolver(ComplementarySolver(), Left()).at_energy(
            equations(), guess(omega=omega), gamma=GAMMA, newton=NEWTON
        )
        for omega in (1.0, 1.05)
    ]
    assert all(solution.converged and solution.q.shape == (4, 2) for solution in found)
    assert found[0].omega == pytest.approx(found[1].omega, rel=1e-10)
    at_frequency = FullOrderSolver(ComplementarySolver(), Left()).at_condition(
        equations(), guess(), condition=FixedFrequency(found[0].omega), newton=NEWTON
    )
    assert at_frequency.energies.gamma == pytest.approx(GAMMA, rel=1e-7)


def test_a_flexibility_that_never_settles_is_a_failure() -> None:
    solver = FullOrderSolver(ComplementarySolver(), source := Wavering(omega=5.0))
    found = solver.at_energy(equations(), guess(), gamma=GAMMA, newton=NEWTON)
    assert found.failure == "the frequency moves with each renewal of the flexibility"
    assert len(source.asked) == 7


def test_multipliers_fix_the_energy_alone() -> None:
    multipliers = MultiplierSolver(MultiplierLoop())
    for solver in (multipliers, FullOrderSolver(multipliers, Left())):
        assert solver.fixes_energy_only and not solver.reduced
        with pytest.raises(ModelError, match="needs contact points without mass"):
            solver.problem(equations(), NEWTON)
        with pytest.raises(ModelError, match="needs contact points without mass"):
            solver.at_condition(equations(), guess(), condition=FixedFrequency(1.1), newton=NEWTON)


def test_arc_length_problem_of_a_level() -> None:
    """The same motion by the problem of a level as by its solver, reduced and of full order."""
    condition = FixedEnergy(GAMMA)
    for solver in (ComplementarySolver(), FullOrderSolver(ComplementarySolver(), Left())):
        found = solver.at_condition(equations(), guess(), condition=condition, newton=NEWTON)
        problem = solver.problem(equations(), NEWTON)
        about = problem.about(found.omega)
        q = about.stacked(found.q, found.forces.force)
        again = problem.solve(condition, Unknowns.of(q, found.omega))
        assert again.omega == pytest.approx(found.omega, rel=1e-11)
        np.testing.assert_allclose(again.q[:, :2], found.q, atol=1e-9)
