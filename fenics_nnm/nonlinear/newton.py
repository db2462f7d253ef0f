"""Damped semismooth Newton for one point of a branch."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.nonlinear.condensed import Border, condensed_solution, pays
from fenics_nnm.nonlinear.equations import Energies, HarmonicEquations
from fenics_nnm.nonlinear.full_order import Equations


class Constraint(Protocol):
    """The equation that picks one motion of the branch."""

    def value(self, equations: Equations, q: Array, omega: float) -> float:
        """Left-hand side, of order one where violated."""

    def gradient(self, equations: Equations, q: Array, omega: float) -> tuple[Array, float]:
        """Derivatives of the left-hand side by q, shape (N + 1, J), and by omega."""


@dataclass(frozen=True, slots=True)
class FixedEnergy:
    """gamma / target - 1 = 0."""

    gamma: float

    def value(self, equations: Equations, q: Array, omega: float) -> float:
        """Relative distance from the wanted gamma."""
        return equations.gamma(q, omega) / self.gamma - 1

    def gradient(self, equations: Equations, q: Array, omega: float) -> tuple[Array, float]:
        """Derivatives by q and omega."""
        by_q, by_omega = equations.gamma_gradient(q, omega)
        return by_q / self.gamma, by_omega / self.gamma


@dataclass(frozen=True, slots=True)
class FixedFrequency:
    """omega / target - 1 = 0."""

    omega: float

    def value(self, equations: Equations, q: Array, omega: float) -> float:
        """Relative distance from the wanted frequency."""
        return omega / self.omega - 1

    def gradient(self, equations: Equations, q: Array, omega: float) -> tuple[Array, float]:
        """Derivatives by q and omega."""
        return np.zeros_like(q), 1 / self.omega


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
        free: Harmonics of the free displacement of the contact points, shape (N + 1, n_c); what
            they move is this less R lambda.
        energies: Energies.
        residual: Relative residual.
        iterations: Newton steps taken.
        failure: Empty where converged, else why not and which parameter would help.
    """

    q: Array
    omega: float
    forces: ContactForces
    free: Array
    energies: Energies
    residual: float
    iterations: int
    failure: str = ""

    @property
    def converged(self) -> bool:
        """Whether the tolerance was met."""
        return not self.failure

    def thinned(self) -> Solution:
        """The same without the derivative of its forces, which is most of its memory."""
        return replace(self, forces=ContactForces.alone(self.forces.force))

    def completed(self, equations: Equations) -> Solution:
        """The same with the derivative of its forces."""
        return replace(self, forces=equations.forces(self.q, self.omega, self.forces))


@dataclass(frozen=True, slots=True)
class Unknowns:
    """Coefficients, frequency, and the drift that goes with a fixed phase, else 0."""

    q: Array
    omega: float
    drift: float = 0.0

    def moved(self, step: Unknowns, fraction: float) -> Unknowns:
        """These, and a fraction of a step."""
        return Unknowns(
            self.q + fraction * step.q,
            self.omega + fraction * step.omega,
            self.drift + fraction * step.drift,
        )


@dataclass(frozen=True, slots=True)
class _Trial:
    at: Unknowns
    forces: ContactForces
    residual: Array
    constraint: float
    relative: float

    @property
    def merit(self) -> float:
        return float(np.hypot(self.relative, self.constraint))


def solve(
    equations: Equations,
    constraint: Constraint,
    q: Array,
    omega: float,
    *,
    options: Newton | None = None,
) -> Solution:
    """Solve harmonic equations and constraint from a guess; never raises for non-convergence.

    The phase of a general series is fixed: steps are orthogonal to a shift of the guess in time.
    """
    iteration = _Iteration(equations, constraint, options or Newton(), phase_row(equations, q))
    return iteration.run(Unknowns(q, omega))


def phase_row(equations: Equations, q: Array) -> Array:
    """Unit vector of a small shift in time, shape (size of q,); empty where the phase is fixed."""
    if not equations.series.free_phase:
        return np.empty(0)
    shift = equations.drift_column(q).ravel()
    return np.asarray(shift / max(float(np.linalg.norm(shift)), np.finfo(float).tiny))


def bordered_jacobian(
    equations: Equations, constraint: Constraint, at: Unknowns, forces: ContactForces, phase: Array
) -> Array:
    """Derivative of equations, constraint and, in a general series, the phase.

    Columns are q, omega and the drift; the equations are divided by their row scale.

    Args:
        equations: Harmonic equations.
        constraint: Constraint.
        at: Where to differentiate.
        forces: Contact forces there.
        phase: Row of the phase condition of a general series, else empty; see `phase_row`.
    """
    scale = equations.row_scale(at.omega).ravel()
    size, free_phase = at.q.size, bool(phase.size)
    matrix = np.zeros((size + 1 + free_phase, size + 1 + free_phase))
    jacobian = equations.jacobian(at.omega, forces, at.drift)
    column = equations.frequency_column(at.q, at.omega, forces)
    matrix[:size, :size] = jacobian / scale[:, None]
    matrix[:size, size] = column.ravel() / scale
    by_q, by_omega = constraint.gradient(equations, at.q, at.omega)
    matrix[size, :size] = by_q.ravel()
    matrix[size, size] = by_omega
    if free_phase:
        matrix[:size, size + 1] = equations.drift_column(at.q).ravel() / scale
        matrix[size + 1, :size] = phase
    return matrix


def bordered_solution(
    equations: Equations,
    constraint: Constraint,
    at: Unknowns,
    forces: ContactForces,
    phase: Array,
    residual: Array,
    violation: float,
) -> Unknowns | None:
    """The unknowns that the bordered Jacobian takes to a residual; None where it is singular.

    Args:
        equations: Harmonic equations.
        constraint: Constraint.
        at: Where to differentiate.
        forces: Contact forces there.
        phase: As for `bordered_jacobian`.
        residual: Left-hand sides of the equations, shape of q.
        violation: Left-hand side of the constraint; that of a phase condition is zero.
    """
    below = np.array([violation, 0.0] if phase.size else [violation])
    try:
        if isinstance(equations, HarmonicEquations) and pays(equations, forces):
            border = _border(equations, constraint, at, forces, phase, residual, below)
            solved = condensed_solution(equations, at.omega, forces, border, at.drift)
        else:
            matrix = bordered_jacobian(equations, constraint, at, forces, phase)
            scaled = (residual / equations.row_scale(at.omega)).ravel()
            solved = np.linalg.solve(matrix, np.concatenate([scaled, below]))
    except np.linalg.LinAlgError:
        return None
    if not np.all(np.isfinite(solved)):
        return None
    size = at.q.size
    drift = float(solved[size + 1]) if phase.size else 0.0
    return Unknowns(solved[:size].reshape(at.q.shape), float(solved[size]), drift)


def _border(
    equations: HarmonicEquations,
    constraint: Constraint,
    at: Unknowns,
    forces: ContactForces,
    phase: Array,
    residual: Array,
    below: Array,
) -> Border:
    """What borders the Jacobian of the equations, as in `bordered_jacobian`."""
    columns = [equations.frequency_column(at.q, at.omega, forces)]
    by_q, by_omega = constraint.gradient(equations, at.q, at.omega)
    rows, corner = [by_q], np.zeros((len(below), len(below)))
    corner[0, 0] = by_omega
    if phase.size:
        columns.append(equations.drift_column(at.q))
        rows.append(phase.reshape(at.q.shape))
    return Border(np.array(columns), np.array(rows), corner, residual, below)


@dataclass(frozen=True, slots=True)
class _Iteration:
    equations: Equations
    constraint: Constraint
    options: Newton
    phase: Array

    def run(self, start: Unknowns) -> Solution:
        trial, failure, leaps = self.evaluated(start), "", 0
        for iteration in range(self.options.iterations + 1):
            if trial.merit <= self.options.tolerance:
                break
            if iteration == self.options.iterations:
                failure = f"no convergence in {iteration} Newton steps"
                break
            step = self.bounded_step(trial)
            if step is None:
                failure = "the Jacobian is singular: a bifurcation or a fold in gamma"
                break
            better = self.line_search(trial, step)
            if better is None and trial.merit <= self.options.round_off:
                break
            if better is None and leaps < self.options.leaps:
                leaps += 1
                better = self.evaluated(trial.at.moved(step, 1.0), trial.forces)
            if better is None:
                failure = "the line search stalled"
                break
            trial = better
        return Solution(
            q=trial.at.q,
            omega=trial.at.omega,
            forces=trial.forces,
            free=self.equations.free_harmonics(trial.at.q, trial.at.omega),
            energies=self.equations.energies(trial.at.q, trial.at.omega, trial.forces),
            residual=trial.relative,
            iterations=iteration,
            failure=f"{failure} (residual {trial.relative:.1e})" if failure else "",
        )

    def evaluated(self, at: Unknowns, near: ContactForces | None = None) -> _Trial:
        forces = self.equations.forces(at.q, at.omega, near)
        residual = self.equations.residual(at.q, at.omega, forces, at.drift)
        return _Trial(
            at=at,
            forces=forces,
            residual=residual,
            constraint=self.constraint.value(self.equations, at.q, at.omega),
            relative=self.equations.relative_residual(at.q, at.omega, residual),
        )

    def bounded_step(self, trial: _Trial) -> Unknowns | None:
        """Newton's step, shortened to the largest step allowed; None where it has no solution."""
        solved = bordered_solution(
            self.equations,
            self.constraint,
            trial.at,
            trial.forces,
            self.phase,
            trial.residual,
            trial.constraint,
        )
        if solved is None:
            return None
        size_of_motion = float(np.linalg.norm(self.equations.motion(trial.at.q)))
        longest = self.options.largest_motion_step * size_of_motion
        widest = self.options.largest_frequency_step * trial.at.omega
        shrink = min(
            1.0,
            widest / max(abs(solved.omega), 1e-300),
            longest / max(float(np.linalg.norm(solved.q)), 1e-300),
        )
        return Unknowns(-shrink * solved.q, -shrink * solved.omega, -shrink * solved.drift)

    def line_search(self, trial: _Trial, step: Unknowns) -> _Trial | None:
        """The longest of the fractions 1, 1/2, 1/4 ... that lowers the merit, or None."""
        fraction = 1.0
        while fraction >= self.options.shortest_fraction:
            candidate = self.evaluated(trial.at.moved(step, fraction), trial.forces)
            if candidate.merit < (1 - 1e-4 * fraction) * trial.merit:
                return candidate
            fraction /= 2
        return None
