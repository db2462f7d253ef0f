r"""Arc-length: damped motions of one energy along a number that their damping depends on.

A number s joins the unknowns of `time_domain.resonant_map`. With x = (Y, omega, level, s) in its
units and t the unit tangent at the motion before,

    F(x) = 0,        t . (x - x_before) = length,

so that a family is followed where it turns back in s, and where it changes much over little of s.
The derivative by s is a difference. H. B. Keller, "Numerical solution of bifurcation and nonlinear
eigenvalue problems", in Applications of Bifurcation Theory, Academic Press, 1977, 359-384.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.resonant_map import Course, ResonantMap

#: Difference of s from which the slope by it follows.
_DIFFERENCE = 1e-6

#: Miss that ends Newton's iteration, its most steps, the longest one, and the least part that a
#: step is to lower the miss by.
_TOLERANCE, _STEPS, _LONGEST, _LOWERS = 1e-9, 8, 0.5, 0.7

#: Cosine of the angle by which a family may turn over a step, the same for steps below a length, as
#: it turns with the square root of the way where a contact begins; and what the way from one motion
#: to the next may be longer than the step.
_TURN, _BEND, _SHORT, _LONGER = 0.8, 0.2, 1e-3, 2.0


@dataclass(frozen=True, slots=True)
class ArcPoint:
    """A motion of the family.

    Attributes:
        x: Unknowns, shape (2 J + 3,).
        tangent: Unit tangent there, in the direction of the way, shape (2 J + 3,).
        course: Its period.
        iterations: Newton steps taken.
    """

    x: Array
    tangent: Array
    course: Course
    iterations: int = 0

    @property
    def s(self) -> float:
        """The number."""
        return float(self.x[-1])

    @property
    def heading(self) -> float:
        """Change of the number along the way."""
        return float(self.tangent[-1])


@dataclass(frozen=True, slots=True)
class ResonantArc:
    """Motions of one energy over a number.

    Attributes:
        equations: Their equations at a value of the number, in the same units at all of them.
    """

    equations: Callable[[float], ResonantMap]

    def first(self, x: Array, sense: float) -> ArcPoint:
        """A known motion, with the tangent along which the number changes in a sense."""
        _, jacobian, course = self._linearised(x)
        own = np.linalg.lstsq(jacobian[:, :-1], -jacobian[:, -1], rcond=None)[0]
        tangent = np.append(own, 1.0)
        return ArcPoint(x, sense * tangent / np.linalg.norm(tangent), course)

    def next(self, before: ArcPoint, length: float) -> ArcPoint | None:
        """The motion a length farther; None if Newton's iteration does not find one that follows.

        Args:
            before: A motion with its tangent.
            length: Length of the step.
        """
        tangent = before.tangent
        guess = before.x + length * tangent
        x = guess
        largest = np.inf
        for iteration in range(_STEPS + 1):
            values, jacobian, course = self._linearised(x)
            missed = np.append(values, tangent @ (x - guess))
            size = float(np.linalg.norm(missed))
            if size <= _TOLERANCE:
                return _following(before, x, jacobian, course, length, iteration)
            if not size <= _LOWERS * largest:
                return None
            largest = size
            change = _solved(jacobian, tangent, -missed)
            if change is None or np.linalg.norm(change) > _LONGEST or x[-2] + change[-2] <= 0:
                return None
            x = x + change
        return None

    def _linearised(self, x: Array) -> tuple[Array, Array, Course]:
        """Left-hand sides, their derivatives by all unknowns, and the period."""
        missed = self.equations(float(x[-1])).linearised(x[:-1])
        ahead = float(x[-1]) + _DIFFERENCE
        change = self.equations(ahead).missed(x[:-1]).values - missed.values
        by_number = change / (ahead - x[-1])
        return missed.values, np.column_stack([missed.jacobian, by_number]), missed.course


def _following(
    before: ArcPoint, x: Array, jacobian: Array, course: Course, length: float, iterations: int
) -> ArcPoint | None:
    """A motion with its tangent; None if it is not where the one before leads."""
    onward = np.zeros(len(x))
    onward[-1] = 1.0
    tangent = _solved(jacobian, before.tangent, onward)
    if tangent is None:
        return None
    tangent = tangent / np.linalg.norm(tangent)
    turned = float(tangent @ before.tangent) < (_TURN if length > _SHORT else _BEND)
    far = np.linalg.norm(x - before.x) > _LONGER * length
    return None if turned or far else ArcPoint(x, tangent, course, iterations)


def _solved(jacobian: Array, border: Array, right: Array) -> Array | None:
    """Solution of the bordered equations; None if they are singular."""
    try:
        found = np.linalg.solve(np.vstack([jacobian, border]), right)
    except np.linalg.LinAlgError:
        return None
    return np.asarray(found) if np.isfinite(found).all() else None
