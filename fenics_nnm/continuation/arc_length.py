r"""Pseudo-arclength: the geometry of a branch near one of its points.

Distances along a branch are measured in scaled unknowns, about a motion (q0, omega0):

    y = (D q / |D q0|, omega / omega0, ..),      D_nj = sqrt(c_n (omega_j^2 + n^2 omega0^2)),

with c_n the mean square of the basis function n, and q0 counted from the state of rest. |D q|^2 is
twice the mean energy that the modes have without contact, so a step ds is a relative change of the
motion in the energy norm, or of the frequency, whichever is larger: where energy changes at
constant frequency, as in the tongue of an internal resonance, the motion measures the step, and
where a frequency runs at constant energy that does. Rows of the equations are scaled by the same D,
which makes the Jacobian of a cosine series symmetric, with entries of order one.

H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", in
Applications of Bifurcation Theory, Academic Press, 1977, 359-384.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.signed_factor import SignedFactor
from fenics_nnm.nonlinear.conditions import Condition, own_conditions
from fenics_nnm.nonlinear.equations import Equations
from fenics_nnm.nonlinear.newton import Newton, bordered_jacobian, solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: Largest number of times that equations are renewed about the frequency of a solution.
_RENEWALS = 6


@dataclass(frozen=True, slots=True)
class Metric:
    """Scaled unknowns y about a motion.

    Attributes:
        weight: D / |D q0|, shape of q.
        parameters: Sizes of the parameters, shape (k,): all but the drift of a free phase, which is
            0 on every motion.
    """

    weight: Array
    parameters: Array

    @classmethod
    def about(cls, equations: Equations, at: Unknowns) -> Metric:
        """The scales of a motion that is not at rest."""
        mean_square = equations.series.mean_square[:, None]
        weight = np.sqrt(mean_square * equations.row_scale(at.omega))
        motion = equations.motion(at.q)
        count = len(equations.parameters) - equations.free_phase
        size = float(np.linalg.norm(weight * motion))
        return cls(weight / size, np.abs(at.parameters[:count]))

    def scaled(self, change: Unknowns) -> Array:
        """A change of the unknowns as a vector, shape (size of q + k,)."""
        by_parameter = change.parameters[: len(self.parameters)] / self.parameters
        return np.concatenate([(self.weight * change.q).ravel(), by_parameter])

    def unscaled(self, vector: Array) -> Unknowns:
        """The change that a vector stands for."""
        size = self.weight.size
        q = vector[:size].reshape(self.weight.shape) / self.weight
        return Unknowns(q, vector[size:] * self.parameters)

    def between(self, first: Unknowns, second: Unknowns) -> Array:
        """The scaled way from the first to the second."""
        count = len(self.parameters)
        change = second.parameters[:count] - first.parameters[:count]
        return self.scaled(Unknowns(second.q - first.q, change))


@dataclass(frozen=True, slots=True)
class FixedArc:
    """direction . (y - y0) - length = 0.

    Attributes:
        metric: Scaled unknowns.
        base: The point y0.
        direction: Unit vector in scaled unknowns.
        length: Distance along it.
    """

    metric: Metric
    base: Unknowns
    direction: Array
    length: float

    def value(self, equations: Equations, at: Unknowns) -> float:
        """What is missing of the length, the other way round."""
        return float(self.direction @ self.metric.between(self.base, at)) - self.length

    def gradient(self, equations: Equations, at: Unknowns) -> Unknowns:
        """Derivatives by coefficients and parameters."""
        size = at.q.size
        by_q = self.metric.weight * self.direction[:size].reshape(at.q.shape)
        by_parameter = np.zeros(len(at.parameters))
        by_parameter[: len(self.metric.parameters)] = self.direction[size:] / self.metric.parameters
        return Unknowns(by_q, by_parameter)


@dataclass(frozen=True, slots=True)
class Problem:
    """Harmonic equations about any frequency, and how they are solved.

    Attributes:
        about: From a frequency to equations that are accurate about it. Those of a reduced model
            are the same everywhere; at full order it gives the same object as long as the
            flexibility is accurate.
        newton: Newton's configuration.
    """

    about: Callable[[float], Equations]
    newton: Newton

    @classmethod
    def of(cls, equations: Equations, newton: Newton) -> Problem:
        """Equations that hold at all frequencies."""
        return cls(lambda omega: equations, newton)

    def roughly(self, tolerance: float) -> Problem:
        """The same solved to a tolerance, if that is larger."""
        own = self.newton.tolerance
        return replace(self, newton=replace(self.newton, tolerance=max(own, tolerance)))

    def solve(self, condition: Condition, guess: Unknowns) -> Solution:
        """A motion that obeys equations and a condition; never raises for non-convergence."""
        equations = self.about(guess.omega)
        for _ in range(_RENEWALS):
            found = solve(equations, condition, guess, options=self.newton)
            renewed = self.about(found.omega) if found.converged else equations
            if renewed is equations:
                break
            equations, guess = renewed, found.at
        return found


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """A point of a branch and the way on from it.

    Attributes:
        solution: Motion.
        metric: Scaled unknowns about it.
        tangent: Unit tangent in them.
        orientation: Sign of the determinant of the Jacobian bordered by the tangent. Along a branch
            it changes at simple branch points and nowhere else, neither at folds nor at kinks.
    """

    solution: Solution
    metric: Metric
    tangent: Array
    orientation: float

    @property
    def at(self) -> Unknowns:
        """Its unknowns."""
        return self.solution.at

    def turned(self) -> CurvePoint:
        """The same point, the other way."""
        return CurvePoint(self.solution, self.metric, -self.tangent, -self.orientation)


def scaled_jacobian(
    equations: Equations, metric: Metric, solution: Solution, direction: Array
) -> Array:
    """Jacobian of the equations in scaled unknowns, bordered by a direction.

    Args:
        equations: Harmonic equations.
        metric: Scaled unknowns.
        solution: Motion at which they are differentiated.
        direction: Row below the equations, shape (size of q + k,).

    Returns:
        A square matrix: columns q, parameters and, of a free phase, the drift; rows the equations,
        the direction and the phase condition.
    """
    at, size = solution.at, solution.q.size
    count = size + len(metric.parameters)
    row = FixedArc(metric, at, direction, 0.0)
    conditions = (row, *own_conditions(equations, at.q))
    whole = at.completed(len(equations.parameters))
    matrix = bordered_jacobian(equations, conditions, whole, solution.forces)
    weight = metric.weight.ravel()
    matrix[:size] *= weight[:, None]
    matrix[:, :size] /= weight
    matrix[:, size:count] *= metric.parameters
    for column, line in zip(range(count, len(matrix)), range(size + 1, len(matrix)), strict=True):
        matrix[:size, column] /= np.linalg.norm(matrix[:size, column])
        matrix[line] /= np.linalg.norm(matrix[line])
    return matrix


def curve_point(equations: Equations, solution: Solution, along: Array) -> CurvePoint:
    """A point with its tangent, oriented along a direction in the scaled unknowns about it.

    Where the tangent is not unique to round-off, at a branch point, it is the part of the direction
    in the null space.
    """
    metric = Metric.about(equations, solution.at)
    direction = along / np.linalg.norm(along)
    matrix = scaled_jacobian(equations, metric, solution, direction)
    size = solution.q.size
    right = np.zeros(len(matrix))
    right[size] = 1.0
    factor = SignedFactor.of(matrix)
    if not factor.sign:
        return CurvePoint(solution, metric, _projected(matrix, size, direction), 0.0)
    tangent = factor.solution(right)[: direction.size]
    return CurvePoint(solution, metric, tangent / np.linalg.norm(tangent), factor.sign)


def null_space(equations: Equations, metric: Metric, solution: Solution) -> tuple[Array, Array]:
    """Singular values of the scaled Jacobian of the equations, and the directions of the smallest.

    Returns:
        All singular values, ascending, of which the first belongs to the tangent and is 0; and the
        right singular vectors in the same order as rows, without their part along the drift.
    """
    size = solution.q.size
    count = size + len(metric.parameters)
    matrix = scaled_jacobian(equations, metric, solution, np.zeros(count))
    equations_alone = np.delete(matrix, size, axis=0)
    _, values, vectors = np.linalg.svd(equations_alone)
    return np.append(values, 0.0)[::-1], vectors[::-1, :count]


def _projected(matrix: Array, size: int, direction: Array) -> Array:
    """Part of a direction in the null space of the equations, of unit length."""
    _, values, vectors = np.linalg.svd(np.delete(matrix, size, axis=0))
    null = vectors[np.append(values, 0.0) < 1e-9 * values[0], : direction.size]
    part = null.T @ (null @ direction)
    return np.asarray(part / np.linalg.norm(part))
