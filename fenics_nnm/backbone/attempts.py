"""What a level gave from a guess, and which guesses have failed before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.level_solver import Guess
from fenics_nnm.nonlinear.solution import Solution

#: Failures that are kept: those at a handful of energies.
_KEPT = 200

#: Guesses that differ by less than this part lead to the same: they come from the same motions of
#: other levels, found to the tolerance of their iterations.
_ALIKE = 1e-6


@dataclass(frozen=True, slots=True)
class Attempt:
    """What a level gave: a solution, or why not, and the motion that was refused, if any."""

    solution: Solution | None = None
    failure: str = ""
    refused: Solution | None = None

    def light(self) -> Attempt:
        """The same without factors, of one that failed."""
        return replace(self, refused=self.refused.light() if self.refused else None)


@dataclass(frozen=True, slots=True)
class _Trace:
    """By what a guess is known again.

    Attributes:
        level: Number of the level.
        gamma_ratio: The energy.
        sizes: Frequency, and sizes of motion and forces and of parts of them, shape (5,).
    """

    level: int
    gamma_ratio: float
    sizes: Array

    @classmethod
    def of(cls, level: int, gamma_ratio: float, guess: Guess) -> _Trace:
        """The trace that a guess leaves."""
        sizes = [guess.omega]
        for values in (guess.q.ravel(), guess.force.ravel()):
            size = float(np.linalg.norm(values))
            sizes += [size, size + float(values @ np.cos(np.arange(values.size)))]
        return cls(level, gamma_ratio, np.array(sizes))

    def alike(self, other: _Trace) -> bool:
        """Whether two guesses are the same but for round-off."""
        if (self.level, self.gamma_ratio) != (other.level, other.gamma_ratio):
            return False
        apart = np.abs(self.sizes - other.sizes)
        return bool(np.all(apart <= _ALIKE * np.abs(other.sizes)))


@dataclass(frozen=True, slots=True)
class FailedAttempts:
    """Guesses that led nowhere: an energy that is tried again meets most of them again."""

    _failed: list[tuple[_Trace, Attempt]] = field(default_factory=list)

    def once(
        self, level: int, gamma_ratio: float, guess: Guess, attempt: Callable[[], Attempt]
    ) -> Attempt:
        """The attempt, or what it gave before if that was a failure.

        Args:
            level: Number of the level.
            gamma_ratio: The energy.
            guess: Where it starts.
            attempt: Makes it.
        """
        trace = _Trace.of(level, gamma_ratio, guess)
        known = next((failed for at, failed in self._failed if trace.alike(at)), None)
        if known is not None:
            return known
        found = attempt()
        if found.solution is None:
            self._failed.append((trace, found.light()))
            del self._failed[:-_KEPT]
        return found
