"""Solution of the full-order equations: Newton's iteration, and the flexibility renewed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.equations import Equations, HarmonicEquations
from fenics_nnm.nonlinear.full_order import FullOrderEquations
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.reduction.flexibility import ACCURACY, ResidualFlexibility

#: Largest number of times that the flexibility is renewed at one point.
_ROUNDS = 6

FlexibilitySource = Callable[[float], ResidualFlexibility]
"""From a frequency to the residual flexibility D about it."""

Solver = Callable[[Equations, Array, float, Array], Solution]
"""From equations and a guess of unknowns, frequency and contact forces to a solution."""


def full_order_solution(
    reduced: HarmonicEquations,
    source: FlexibilitySource,
    solver: Solver,
    q: Array,
    omega: float,
    force: Array,
) -> Solution:
    """Solve the full-order equations, with the flexibility renewed where the frequency moved.

    Args:
        reduced: Equations of the modes that stay explicit, with the law of the variant.
        source: Gives D about a frequency, with the static part for the mass-carrying variant.
        solver: Solves equations from unknowns, a frequency and contact forces.
        q: Guess of the modal coordinates, shape (N + 1, J).
        omega: Guess of the frequency.
        force: Guess of the contact forces, shape (s, n_c).

    Returns:
        A solution whose q has the modal coordinates alone.
    """
    flexibility, steps = source(omega), 0
    for _ in range(_ROUNDS):
        equations = FullOrderEquations(reduced, flexibility)
        solution = solver(equations, equations.stacked(q, force), omega, force)
        steps += solution.iterations
        solution = replace(solution.with_q(equations.modal(solution.q)), iterations=steps)
        allowed = ACCURACY * equations.static_flexibility.max()
        accurate = flexibility.error(solution.omega).max() <= allowed
        if accurate or not solution.converged:
            return solution
        q, omega, force = solution.q, solution.omega, solution.forces.force
        flexibility = source(omega)
    return replace(solution, failure="the frequency moves with each renewal of the flexibility")
