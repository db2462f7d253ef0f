"""How long an analysis of many contact points is going to take, from costs measured on the spot."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.stages import duration

#: With fewer contact points than this an analysis is short.
MANY = 300

#: Columns that are solved for to measure, and rows of the matrices that are multiplied.
_COLUMNS, _ROWS = 16, 400

#: Static solutions of the contact points that an analysis makes, and large products of them.
_SOLUTIONS, _PRODUCTS = 2, 4

#: Cubes of the number of points in operations: of the models of all levels, and of each motion.
_MODELS, _MOTION = 14.0, 8.0

#: Shorter times than this, in s, are not worth a line.
_WORTH = 10.0


@dataclass(frozen=True, slots=True)
class Costs:
    """What is measured.

    Attributes:
        solution: Seconds of a static solution, of several at once.
        operation: Seconds of a floating-point operation in a product of matrices.
    """

    solution: float
    operation: float

    @classmethod
    def measured(cls, static: Callable[[Array], Array], forces: Array) -> Costs:
        """Measure; to be called on all ranks.

        Args:
            static: From columns of forces to static displacements.
            forces: Columns of forces, shape (n, k).
        """
        few = forces[:, :_COLUMNS]
        solution = _seconds(lambda: static(few)) / few.shape[1]
        square = np.ones((_ROWS, _ROWS))
        return cls(solution, _seconds(lambda: square @ square) / (2 * _ROWS**3))

    def attachments(self, points: int, unknowns: int) -> float:
        """Seconds to the reduced model of n_c points, with n degrees of freedom on this rank."""
        products = _PRODUCTS * 2.0 * unknowns * points**2
        return _SOLUTIONS * points * self.solution + products * self.operation

    def branch(self, points: int, motions: int) -> float:
        """Seconds to a branch of some motions of n_c points."""
        return (_MODELS + _MOTION * motions) * points**3 * self.operation


def expectation(costs: Costs, points: int, unknowns: int, motions: int) -> str:
    """How long is going to take what, in a line; empty if it is short.

    Args:
        costs: What was measured.
        points: Number of contact points.
        unknowns: Degrees of freedom on this rank.
        motions: Motions that are wanted at least.
    """
    static, branch = costs.attachments(points, unknowns), costs.branch(points, motions)
    if static + branch < _WORTH:
        return ""
    return (
        f"{points} contact points: about {duration(static + branch)} from here on, "
        f"{duration(static)} of them for static displacements and {duration(branch)} for "
        f"{motions} motions; hard contact may take longer"
    )


def _seconds(work: Callable[[], object]) -> float:
    """Seconds of some work, the second time that it is done."""
    work()
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun
