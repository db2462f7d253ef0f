"""Solution of the full-order equations, with the flexibility renewed where the frequency moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

from fenics_nnm.backbone.level_solver import ContactSolver, Guess, needs_massless
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.nonlinear.conditions import Condition
from fenics_nnm.nonlinear.equations import Equations, HarmonicEquations
from fenics_nnm.nonlinear.full_order import FullOrderEquations
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.reduction.flexibility import ACCURACY, FlexibilitySource

#: Largest number of times that the flexibility is renewed at one point.
_ROUNDS = 6


@dataclass(slots=True)
class RenewedEquations:
    """Full-order equations about any frequency, renewed where they are not accurate any more.

    Attributes:
        reduced: Equations of the modes that stay explicit, with the law of the variant.
        source: Gives D about a frequency, with the static part for the mass-carrying variant.
    """

    reduced: HarmonicEquations
    source: FlexibilitySource
    _last: FullOrderEquations | None = field(default=None, init=False, repr=False)

    def about(self, omega: float) -> FullOrderEquations:
        """Equations that are accurate about a frequency: the last ones if these are."""
        if self._last is None or not _accurate(self._last, omega):
            self._last = FullOrderEquations(self.reduced, self.source(omega))
        return self._last


@dataclass(frozen=True, slots=True)
class FullOrderSolver:
    """Solves the full-order equations about the frequency that comes out.

    Attributes:
        inner: Solves the equations about a frequency.
        source: Gives D about a frequency, with the static part for the mass-carrying variant.
    """

    inner: ContactSolver
    source: FlexibilitySource

    @property
    def reduced(self) -> bool:
        """Nothing is left out."""
        return False

    @property
    def fixes_energy_only(self) -> bool:
        """As it is for the equations about a frequency."""
        return self.inner.fixes_energy_only

    @property
    def knows_slopes(self) -> bool:
        """They are those of the explicit modes."""
        return True

    def at_energy(
        self, equations: HarmonicEquations, guess: Guess, *, gamma: float, newton: Newton
    ) -> Solution:
        """Motion of given gamma, q of the modal coordinates alone."""
        return self._renewed(
            equations, guess, partial(self.inner.at_energy, gamma=gamma, newton=newton)
        )

    def at_condition(
        self, equations: HarmonicEquations, guess: Guess, *, condition: Condition, newton: Newton
    ) -> Solution:
        """Motion that a condition picks, q of the modal coordinates alone."""
        return self._renewed(
            equations, guess, partial(self.inner.at_condition, condition=condition, newton=newton)
        )

    def problem(self, equations: HarmonicEquations, newton: Newton) -> Problem:
        """The equations about any frequency."""
        if self.fixes_energy_only:
            raise needs_massless("continuation by arc-length")
        return Problem(RenewedEquations(equations, self.source).about, newton)

    def _renewed(
        self,
        reduced: HarmonicEquations,
        guess: Guess,
        solved: Callable[[Equations, Guess], Solution],
    ) -> Solution:
        """Solve again while the frequency leaves the range of the flexibility."""
        renewal = RenewedEquations(reduced, self.source)
        equations, steps = renewal.about(guess.omega), 0
        for _ in range(_ROUNDS):
            found = solved(equations, replace(guess, q=equations.stacked(guess.q, guess.force)))
            steps += found.iterations
            solution = replace(found.with_q(equations.modal(found.q)), iterations=steps)
            if not found.converged:
                return solution
            renewed = renewal.about(found.omega)
            if renewed is equations:
                return solution
            equations, guess = renewed, Guess.of(solution)
        return replace(solution, failure="the frequency moves with each renewal of the flexibility")


def _accurate(equations: FullOrderEquations, omega: float) -> bool:
    """Whether the flexibility holds at a frequency."""
    allowed = ACCURACY * equations.static_flexibility.max()
    return bool(equations.flexibility.error(omega).max() <= allowed)
