"""What a level gave from a guess, and which guesses have failed before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from fenics_nnm.backbone.level_solver import Guess
from fenics_nnm.backbone.memory import forget_oldest
from fenics_nnm.nonlinear.solution import Solution

#: Failures that are kept: those at a handful of energies.
_KEPT = 200


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
class FailedAttempts:
    """Guesses that led nowhere: an energy that is tried again meets most of them again."""

    _failed: dict[int, Attempt] = field(default_factory=dict)

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
        key = hash((level, gamma_ratio, guess.omega, guess.q.tobytes(), guess.force.tobytes()))
        known = self._failed.get(key)
        if known is not None:
            return known
        found = attempt()
        if found.solution is None:
            self._failed[key] = found.light()
            forget_oldest(self._failed, _KEPT)
        return found
