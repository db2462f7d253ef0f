"""Which way a branch is followed at first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.continuation.arc_length import CurvePoint, Metric, Problem, curve_point, null_space
from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.conditions import Quantity
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: A slope below this shows no direction.
_LEVEL = 1e-9


class Heading(Protocol):
    """A direction to set out in."""

    def first(self, problem: Problem, start: Solution) -> CurvePoint:
        """A motion with the tangent that leads the wanted way.

        Raises:
            ModelError: if the heading shows no direction there.
        """


@dataclass(frozen=True, slots=True)
class Along:
    """Along a change of the unknowns.

    Attributes:
        way: The change.
    """

    way: Unknowns

    def first(self, problem: Problem, start: Solution) -> CurvePoint:
        """A motion with the tangent that leads this way."""
        equations = problem.about(start.omega)
        return curve_point(equations, start, Metric.about(equations, start.at).scaled(self.way))


@dataclass(frozen=True, slots=True)
class Rising:
    """The way in which a quantity rises, or falls.

    Attributes:
        quantity: Quantity.
        falls: Whether it falls.
    """

    quantity: Quantity
    falls: bool = False

    def first(self, problem: Problem, start: Solution) -> CurvePoint:
        """A motion with the tangent along which the quantity rises, or falls.

        Raises:
            ModelError: if it does neither.
        """
        equations = problem.about(start.omega)
        metric = Metric.about(equations, start.at)
        _, vectors = null_space(equations, metric, start)
        first = curve_point(equations, start, vectors[0])
        slope = self.quantity.slope(equations, start, first.metric.unscaled(first.tangent))
        if abs(slope) < _LEVEL:
            raise _level(self.quantity, self.falls)
        return first.turned() if (slope > 0) == self.falls else first


@dataclass(frozen=True, slots=True)
class Uphill(Rising):
    """The way in which a quantity rises, or falls, by its gradient.

    It is that of `Rising` without singular vectors, which take as long as many steps where there
    are hundreds of unknowns.
    """

    def first(self, problem: Problem, start: Solution) -> CurvePoint:
        """A motion with the tangent along which the quantity rises, or falls.

        Raises:
            ModelError: if it does neither to round-off.
        """
        equations = problem.about(start.omega)
        metric = Metric.about(equations, start.at)
        condition = self.quantity.fixed(self.quantity.value(start))
        by, count = condition.gradient(equations, start.at), len(metric.parameters)
        by_parameter = by.parameters[:count] * metric.parameters
        gradient = np.concatenate([(by.q / metric.weight).ravel(), by_parameter])
        with np.errstate(invalid="ignore"):  # at a fold it has no part along the branch
            first = curve_point(equations, start, -gradient if self.falls else gradient)
        if not first.orientation:
            raise _level(self.quantity, self.falls)
        return first


@dataclass(frozen=True, slots=True)
class Away:
    """The way that leads away from another motion nearby.

    Attributes:
        behind: The other motion.
    """

    behind: Unknowns

    def first(self, problem: Problem, start: Solution) -> CurvePoint:
        """A motion with the tangent that leads away from the other one."""
        equations = problem.about(start.omega)
        metric = Metric.about(equations, start.at)
        _, vectors = null_space(equations, metric, start)
        first = curve_point(equations, start, vectors[0])
        ahead = first.tangent @ first.metric.between(self.behind, start.at)
        return first.turned() if ahead < 0 else first


def _level(quantity: Quantity, falls: bool) -> ModelError:
    """A heading that shows no direction."""
    way = "down" if falls else "up"
    return ModelError(
        f'heading "{quantity.name} {way}": the branch is level there; head by another quantity'
    )
