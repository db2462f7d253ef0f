"""Where the iteration of a level starts: beside a neighbouring point, or from the level below."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.level_solver import Guess
from fenics_nnm.backbone.levels import Level
from fenics_nnm.nonlinear.solution import Solution


def guesses(
    levels: Sequence[Level],
    below: Sequence[Solution | None],
    gamma_ratio: float,
    neighbour: CascadeSolution | None,
) -> Iterator[Guess]:
    """Guesses for the level above those that are solved, best first.

    Args:
        levels: All levels, coarse to fine.
        below: Solutions of the levels below it at this energy.
        gamma_ratio: The energy.
        neighbour: Solutions at another energy, if there are any.
    """
    level = levels[len(below)]
    lower, here = _last_solved(below)
    beside = neighbour.solutions[len(below)] if neighbour else None
    if neighbour is not None and beside is not None:
        there = neighbour.solutions[lower]
        if here is not None and there is not None:
            yield _moved_along(level, levels[lower], beside, here, there)
        yield level.scaled(beside, gamma_ratio / neighbour.gamma_ratio)
    if here is not None:
        yield level.above(levels[lower], here)


def _last_solved(below: Sequence[Solution | None]) -> tuple[int, Solution | None]:
    """Number and solution of the finest level that has one; the coarsest where none has."""
    return next(
        ((at, below[at]) for at in reversed(range(len(below))) if below[at] is not None), (0, None)
    )


def _moved_along(
    level: Level, lower: Level, beside: Solution, here: Solution, there: Solution
) -> Guess:
    """A neighbour's motion, changed as the motion of a lower level has changed from there."""
    change = level.adopted(lower, here.q - there.q)
    force = beside.forces.force + here.forces.force - there.forces.force
    omega = beside.omega + here.omega - there.omega
    return Guess(beside.q + change, omega, np.maximum(force, 0.0))
