"""The piece of a branch between two of its points: motions on it, and where a function is zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import CurvePoint, FixedArc, Metric, Problem, curve_point
from fenics_nnm.nonlinear.conditions import Condition
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: A motion that is farther from its guess than this part of the segment is not on it.
_FARTHEST = 0.5

#: A tangent closer than this to the chord is the slope of the interpolation there.
_SMALLEST_COSINE = 0.3


class NotOnSegmentError(ArithmeticError):
    """No motion was found between two points of a branch."""


@dataclass(frozen=True, slots=True)
class Segment:
    """Motions between two points, by the fraction of the chord that leads to them.

    Attributes:
        problem: Equations.
        first: Point at fraction 0.
        second: Point at fraction 1; its tangent leads away from the first.
    """

    problem: Problem
    first: CurvePoint
    second: CurvePoint

    @property
    def chord(self) -> Array:
        """From the first to the second in the scaled unknowns about the first."""
        return self.metric.between(self.first.at, self.second.at)

    @property
    def metric(self) -> Metric:
        """Scaled unknowns about the first."""
        return self.first.metric

    @property
    def length(self) -> float:
        """Length of the chord."""
        return float(np.linalg.norm(self.chord))

    def at(self, fraction: float) -> CurvePoint:
        """The point over a fraction of the chord.

        Raises:
            NotOnSegmentError: if there is none.
        """
        if fraction in (0.0, 1.0):
            return self.second if fraction else self.first
        direction = self.chord / self.length
        arc = FixedArc(self.metric, self.first.at, direction, fraction * self.length)
        return self.solved(arc, self.guess(fraction))

    def solved(self, condition: Condition, guess: Unknowns) -> CurvePoint:
        """The point of the segment that obeys a condition.

        Raises:
            NotOnSegmentError: if there is none near the guess.
        """
        found = self.problem.solve(condition, guess)
        distance = np.linalg.norm(self.metric.between(guess, found.at))
        if not found.converged or distance > _FARTHEST * self.length:
            raise NotOnSegmentError(found.failure or "another motion")
        return self._placed(found)

    def guess(self, fraction: float) -> Unknowns:
        """Cubic interpolation between the points along their tangents."""
        chord = self.chord
        first, second = (
            slope - chord for slope in (self._slope(self.first), self._slope(self.second))
        )
        s, rest = fraction, 1 - fraction
        way = s * chord + s * rest * (rest * first - s * second)
        return self.first.at.moved(self.metric.unscaled(way), 1.0)

    def zero(
        self, function: Callable[[CurvePoint], float], low: float, high: float, tolerance: float
    ) -> float:
        """Fraction where a function of the points, of opposite signs at the ends, changes sign.

        Args:
            function: Function of a point of the segment.
            low: Fraction at one end.
            high: Fraction at the other.
            tolerance: Length to which it is located.

        Raises:
            NotOnSegmentError: if a motion on the way is not found.
        """
        from scipy.optimize import brentq  # takes 0.1 s, which `check` has no use for

        width = max(tolerance / self.length, 4 * np.finfo(float).eps)
        return float(brentq(lambda fraction: function(self.at(fraction)), low, high, xtol=width))

    def _slope(self, point: CurvePoint) -> Array:
        """Derivative of y by the fraction at an end; the chord where the tangent is across it."""
        chord, length = self.chord, self.length
        tangent = self.metric.scaled(point.metric.unscaled(point.tangent))
        cosine = float(tangent @ chord) / (length * float(np.linalg.norm(tangent)))
        if cosine < _SMALLEST_COSINE:
            return chord
        return np.asarray(tangent * length / (float(np.linalg.norm(tangent)) * cosine))

    def _placed(self, found: Solution) -> CurvePoint:
        equations = self.problem.about(found.omega)
        metric = Metric.about(equations, found.at)
        return curve_point(equations, found, metric.scaled(self.metric.unscaled(self.chord)))
