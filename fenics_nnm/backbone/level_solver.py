"""How the equations of a level are solved: what fixes the motion, and what contact asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.errors import Code, ModelError
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop, solve_with_multipliers
from fenics_nnm.nonlinear.conditions import Condition, FixedEnergy
from fenics_nnm.nonlinear.equations import Equations, HarmonicEquations
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns


@dataclass(frozen=True, slots=True)
class Guess:
    """Where an iteration starts: motion (N + 1, J), frequency, contact forces (s, n_c)."""

    q: Array
    omega: float
    force: Array

    @classmethod
    def of(cls, solution: Solution) -> Guess:
        """A solution as a guess."""
        return cls(solution.q, solution.omega, solution.forces.force)


class ContactSolver(Protocol):
    """Finds contact and motion together, for equations of any kind."""

    @property
    def fixes_energy_only(self) -> bool:
        """Whether motions can be found at a given energy alone, under no other condition."""

    def at_energy(
        self, equations: Equations, guess: Guess, *, gamma: float, newton: Newton
    ) -> Solution:
        """Motion of given gamma."""

    def at_condition(
        self, equations: Equations, guess: Guess, *, condition: Condition, newton: Newton
    ) -> Solution:
        """Motion that a condition picks.

        Raises:
            ModelError: if motions are found at a given energy alone.
        """


class LevelSolver(Protocol):
    """Finds the motions of a level."""

    @property
    def reduced(self) -> bool:
        """Whether contact is found by complementarity alone, on a reduced model."""

    @property
    def fixes_energy_only(self) -> bool:
        """Whether motions can be found at a given energy alone, under no other condition."""

    @property
    def knows_slopes(self) -> bool:
        """Whether the slope of the branch follows from the equations of the level."""

    def at_energy(
        self, equations: HarmonicEquations, guess: Guess, *, gamma: float, newton: Newton
    ) -> Solution:
        """Motion of given gamma."""

    def at_condition(
        self, equations: HarmonicEquations, guess: Guess, *, condition: Condition, newton: Newton
    ) -> Solution:
        """Motion that a condition picks.

        Raises:
            ModelError: if motions are found at a given energy alone.
        """

    def problem(self, equations: HarmonicEquations, newton: Newton) -> Problem:
        """The same equations about any frequency, for continuation by arc-length.

        Raises:
            ModelError: if motions are found at a given energy alone.
        """


@dataclass(frozen=True, slots=True)
class ComplementarySolver:
    """Newton's iteration, with contact by complementarity at each sample."""

    @property
    def reduced(self) -> bool:
        """It is for a reduced model."""
        return True

    @property
    def fixes_energy_only(self) -> bool:
        """Any condition will do."""
        return False

    @property
    def knows_slopes(self) -> bool:
        """The law has slopes."""
        return True

    def at_energy(
        self, equations: Equations, guess: Guess, *, gamma: float, newton: Newton
    ) -> Solution:
        """Motion of given gamma."""
        return self.at_condition(equations, guess, condition=FixedEnergy(gamma), newton=newton)

    def at_condition(
        self, equations: Equations, guess: Guess, *, condition: Condition, newton: Newton
    ) -> Solution:
        """Motion that a condition picks."""
        return solve(equations, condition, Unknowns.of(guess.q, guess.omega), options=newton)

    def problem(self, equations: HarmonicEquations, newton: Newton) -> Problem:
        """The equations, which hold at all frequencies."""
        return Problem.of(equations, newton)


@dataclass(frozen=True, slots=True)
class MultiplierSolver:
    """The augmented Lagrangian, for contact points that carry mass.

    Attributes:
        loop: Configuration of the multipliers.
    """

    loop: MultiplierLoop

    @property
    def reduced(self) -> bool:
        """Contact is not found by complementarity."""
        return False

    @property
    def fixes_energy_only(self) -> bool:
        """Multipliers are found at fixed energy."""
        return True

    @property
    def knows_slopes(self) -> bool:
        """The law is that of the last penalties."""
        return False

    def at_energy(
        self, equations: Equations, guess: Guess, *, gamma: float, newton: Newton
    ) -> Solution:
        """Motion of given gamma."""
        return solve_with_multipliers(
            equations, gamma, guess.q, guess.omega, guess.force, loop=self.loop, newton=newton
        )

    def at_condition(
        self, equations: Equations, guess: Guess, *, condition: Condition, newton: Newton
    ) -> Solution:
        """Refused."""
        raise needs_massless("a condition other than the energy")

    def problem(self, equations: HarmonicEquations, newton: Newton) -> Problem:
        """Refused."""
        raise needs_massless("continuation by arc-length")


def needs_massless(what: str) -> ModelError:
    """What multipliers, which are found at fixed energy, cannot do."""
    return ModelError(
        f"{what} needs contact points without mass: the massless reduction, or full order "
        "with complementarity",
        code=Code.MASS_AT_CONTACT,
    )
