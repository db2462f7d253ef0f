"""Damped semismooth Newton for one point of a branch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.contact_law import ContactForces
from fenics_nnm.nonlinear.mode import HarmonicEquations


class Constraint(Protocol):
    """The equation that picks one motion of the branch."""

    def value(self, equations: HarmonicEquations, q: Array, omega: float) -> float:
        """Left-hand side, of order one where violated."""

    def gradient(self, equations: HarmonicEquations, q: Array, omega: float) -> tuple[Array, float]:
        """Derivatives of the left-hand side by q, shape (N + 1, J), and by omega."""


@dataclass(frozen=True, slots=True)
class FixedEnergy:
    """gamma / target - 1 = 0."""

    gamma: float

    def value(self, equations: HarmonicEquations, q: Array, omega: float) -> float:
        """Relative distance from the wanted gamma."""
        return equations.gamma(q) / self.gamma - 1

    def gradient(self, equations: HarmonicEquations, q: Array, omega: float) -> tuple[Array, float]:
        """Derivatives by q and omega."""
        return equations.gamma_gradient(q) / self.gamma, 0.0


@dataclass(frozen=True, slots=True)
class Newton:
    """Configuration of the damped Newton iteration.

    Attributes:
        tolerance: Residual, relative as in `HarmonicEquations.relative_residual`, that ends it.
        iterations: Largest number of steps.
        largest_frequency_step: Bound on |d omega| / omega of one step.
        largest_motion_step: Bound on |d q| / |q| of one step.
        shortest_fraction: The line search gives up below this part of a step.
        round_off: A residual below this that no step lowers is round-off, and taken as converged.
        leaps: Full steps that may be taken where the line search stalls: the equations are only
            piecewise smooth, and a kink can hide the way down.
    """

    tolerance: float = 1e-10
    iterations: int = 40
    largest_frequency_step: float = 0.1
    largest_motion_step: float = 1.0
    shortest_fraction: float = 2.0**-10
    round_off: float = 1e-8
    leaps: int = 5


@dataclass(frozen=True, slots=True)
class Solution:
    """A motion that Newton's iteration ended with.

    Attributes:
        q: Coefficients, shape (N + 1, J).
        omega: Circular frequency.
        forces: Contact forces at the samples.
        residual: Relative residual.
        iterations: Newton steps taken.
        failure: Empty where converged, else why not and which parameter would help.
    """

    q: Array
    omega: float
    forces: ContactForces
    residual: float
    iterations: int
    failure: str = ""

    @property
    def converged(self) -> bool:
        """Whether the tolerance was met."""
        return not self.failure


@dataclass(frozen=True, slots=True)
class _Trial:
    q: Array
    omega: float
    forces: ContactForces
    residual: Array
    constraint: float
    relative: float

    @property
    def merit(self) -> float:
        return float(np.hypot(self.relative, self.constraint))


def solve(
    equations: HarmonicEquations,
    constraint: Constraint,
    q: Array,
    omega: float,
    *,
    options: Newton | None = None,
) -> Solution:
    """Solve harmonic equations and constraint from a guess; never raises for non-convergence."""
    options = options or Newton()
    trial = _evaluate(equations, constraint, q, omega)
    failure = ""
    leaps = 0
    for iteration in range(options.iterations + 1):
        if trial.merit <= options.tolerance:
            break
        if iteration == options.iterations:
            failure = f"no convergence in {iteration} Newton steps (residual {trial.relative:.1e})"
            break
        step = _bounded_step(equations, constraint, trial, options)
        if step is None:
            failure = "the Jacobian is singular: a bifurcation or a fold in gamma"
            break
        better = _line_search(equations, constraint, trial, step, options)
        if better is None and trial.merit <= options.round_off:
            break
        if better is None and leaps < options.leaps:
            leaps += 1
            better = _evaluate(equations, constraint, trial.q + step[0], trial.omega + step[1])
        if better is None:
            failure = f"the line search stalled (residual {trial.relative:.1e})"
            break
        trial = better
    return Solution(
        q=trial.q,
        omega=trial.omega,
        forces=trial.forces,
        residual=trial.relative,
        iterations=iteration,
        failure=failure,
    )


def _evaluate(
    equations: HarmonicEquations, constraint: Constraint, q: Array, omega: float
) -> _Trial:
    forces = equations.forces(q)
    residual = equations.residual(q, omega, forces)
    return _Trial(
        q=q,
        omega=omega,
        forces=forces,
        residual=residual,
        constraint=constraint.value(equations, q, omega),
        relative=equations.relative_residual(q, omega, residual),
    )


def _bounded_step(
    equations: HarmonicEquations, constraint: Constraint, trial: _Trial, options: Newton
) -> tuple[Array, float] | None:
    """Newton's step, shortened to the largest step allowed; None where it cannot be solved."""
    scale = equations.row_scale(trial.omega).ravel()
    size = trial.q.size
    matrix = np.empty((size + 1, size + 1))
    matrix[:size, :size] = equations.jacobian(trial.omega, trial.forces) / scale[:, None]
    matrix[:size, size] = equations.frequency_column(trial.q, trial.omega).ravel() / scale
    by_q, by_omega = constraint.gradient(equations, trial.q, trial.omega)
    matrix[size, :size] = by_q.ravel()
    matrix[size, size] = by_omega
    right = np.append(trial.residual.ravel() / scale, trial.constraint)
    try:
        step = -np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return None
    if not np.all(np.isfinite(step)):
        return None
    motion, frequency = step[:size].reshape(trial.q.shape), float(step[size])
    longest = options.largest_motion_step * float(np.linalg.norm(trial.q))
    widest = options.largest_frequency_step * trial.omega
    shrink = min(
        1.0,
        widest / max(abs(frequency), 1e-300),
        longest / max(float(np.linalg.norm(motion)), 1e-300),
    )
    return shrink * motion, shrink * frequency


def _line_search(
    equations: HarmonicEquations,
    constraint: Constraint,
    trial: _Trial,
    step: tuple[Array, float],
    options: Newton,
) -> _Trial | None:
    """The longest of the fractions 1, 1/2, 1/4 ... that lowers the merit; None where none does."""
    fraction = 1.0
    while fraction >= options.shortest_fraction:
        candidate = _evaluate(
            equations, constraint, trial.q + fraction * step[0], trial.omega + fraction * step[1]
        )
        if candidate.merit < (1 - 1e-4 * fraction) * trial.merit:
            return candidate
        fraction /= 2
    return None
