"""Damped semismooth Newton for one motion of a family."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.conditions import Condition, own_conditions
from fenics_nnm.nonlinear.equations import Equations
from fenics_nnm.nonlinear.solution import Solution, relative_residual
from fenics_nnm.nonlinear.unknowns import Unknowns


@dataclass(frozen=True, slots=True)
class Newton:
    """Configuration of the damped Newton iteration.

    Attributes:
        tolerance: Residual, relative as in `solution.relative_residual`, that ends it.
        iterations: Largest number of steps.
        largest_frequency_step: Bound on |d omega| / omega of one step.
        largest_motion_step: Bound on |d q| / |q| of one step.
        shortest_fraction: The line search gives up below this part of a step.
        round_off: A residual below this that no step lowers is round-off, and taken as converged.
        leaps: Full steps that may be taken where the line search stalls: the equations are only
            piecewise smooth, and a kink can hide the way down.
        wildest_leap: A full step to a residual above this ends it.
        crawls: So many parts of steps below 1/8 on end count as a stall; 0 for any number.
        patience: After so many steps it ends unless it is near a solution; 0 for any number.
        wild: From the fourth step on it ends at a residual above this.
    """

    tolerance: float = 1e-10
    iterations: int = 40
    largest_frequency_step: float = 0.1
    largest_motion_step: float = 1.0
    shortest_fraction: float = 2.0**-10
    round_off: float = 1e-8
    leaps: int = 5
    wildest_leap: float = float("inf")
    crawls: int = 0
    patience: int = 0
    wild: float = float("inf")


#: A shorter part of a step crawls.
_CRAWL = 1 / 8

#: Below this residual a full step that raises it is followed by so many further ones before it is
#: shortened: it may have crossed a kink that the line search only crawls to (a watchdog; R. M.
#: Chamberlain et al., Math. Program. Study 16 (1982) 1-17).
_NEAR, _AHEAD = 1e-2, 2

#: From so many steps on a residual may be too wild to come back from.
_SETTLED = 4


@dataclass(frozen=True, slots=True)
class _Trial:
    at: Unknowns
    forces: ContactForces
    residual: Array
    violations: Array
    relative: float
    crawled: int = 0

    @property
    def merit(self) -> float:
        return float(np.hypot(self.relative, self.violations[0]))


def solve(
    equations: Equations, condition: Condition, guess: Unknowns, *, options: Newton | None = None
) -> Solution:
    """Solve harmonic equations and a condition from a guess; never raises for non-convergence.

    The phase of a free motion in a general series is fixed: steps are orthogonal to a shift of the
    guess in time. Parameters that the guess does not have begin at 0.
    """
    conditions = (condition, *own_conditions(equations, guess.q))
    iteration = _Iteration(equations, conditions, options or Newton())
    return iteration.run(guess.completed(len(equations.parameters)))


def bordered_jacobian(
    equations: Equations, conditions: Sequence[Condition], at: Unknowns, forces: ContactForces
) -> Array:
    """Derivative of equations and conditions by coefficients and parameters.

    The equations are divided by their row scale.

    Args:
        equations: Harmonic equations.
        conditions: As many conditions as parameters.
        at: Where to differentiate.
        forces: Contact forces there.
    """
    border = _border(equations, conditions, at, forces, np.zeros_like(at.q))
    return border.around(equations.jacobian(at, forces), equations.row_scale(at.omega))


def bordered_solution(
    equations: Equations,
    conditions: Sequence[Condition],
    at: Unknowns,
    forces: ContactForces,
    residual: Array,
    violations: Array,
) -> Unknowns | None:
    """The unknowns that the bordered Jacobian takes to a residual; None where it is singular.

    Args:
        equations: Harmonic equations.
        conditions: As many conditions as parameters.
        at: Where to differentiate.
        forces: Contact forces there.
        residual: Left-hand sides of the equations, shape of q.
        violations: Left-hand sides of the conditions, shape (p,).
    """
    try:
        border = _border(equations, conditions, at, forces, residual, violations)
        solved = equations.solved(at, forces, border)
    except np.linalg.LinAlgError:
        return None
    if not np.all(np.isfinite(solved)):
        return None
    size = at.q.size
    return Unknowns(solved[:size].reshape(at.q.shape), solved[size:])


def _border(
    equations: Equations,
    conditions: Sequence[Condition],
    at: Unknowns,
    forces: ContactForces,
    residual: Array,
    violations: Array | None = None,
) -> Border:
    """What borders the Jacobian of the equations."""
    gradients = [condition.gradient(equations, at) for condition in conditions]
    return Border(
        columns=equations.slopes(at, forces),
        rows=np.array([gradient.q for gradient in gradients]),
        corner=np.array([gradient.parameters for gradient in gradients]),
        right=residual,
        below=np.zeros(len(conditions)) if violations is None else violations,
    )


@dataclass(frozen=True, slots=True)
class _Iteration:
    equations: Equations
    conditions: tuple[Condition, ...]
    options: Newton

    def run(self, start: Unknowns) -> Solution:
        trial, failure, leaps = self.evaluated(start), "", 0
        for iteration in range(self.options.iterations + 1):
            if trial.merit <= self.options.tolerance:
                break
            if self.lost(trial, iteration) or iteration == self.options.iterations:
                failure = f"no convergence in {iteration} Newton steps"
                break
            step = self.bounded_step(trial)
            if step is None:
                failure = "the Jacobian is singular: a bifurcation or a fold in gamma"
                break
            better = self.line_search(trial, step)
            stalled = better is None or self.crawls(better)
            if better is None and trial.merit <= self.options.round_off:
                break
            if stalled and leaps < self.options.leaps:
                leaps += 1
                better = self.leap(trial, step) or better
            if better is None:
                failure = "the line search stalled"
                break
            trial = better
        return Solution(
            at=trial.at,
            forces=trial.forces,
            free=self.equations.free_harmonics(trial.at),
            energies=self.equations.energy.energies(trial.at, trial.forces),
            residual=trial.relative,
            iterations=iteration,
            failure=f"{failure} (residual {trial.relative:.1e})" if failure else "",
        )

    def lost(self, trial: _Trial, iteration: int) -> bool:
        """Whether an iteration will hardly come to an end."""
        impatient = iteration == self.options.patience > 0 and trial.merit > _NEAR
        return impatient or (iteration >= _SETTLED and trial.merit > self.options.wild)

    def evaluated(self, at: Unknowns, near: ContactForces | None = None) -> _Trial:
        forces = self.equations.forces(at, near)
        residual = self.equations.residual(at, forces)
        return _Trial(
            at=at,
            forces=forces,
            residual=residual,
            violations=np.array([each.value(self.equations, at) for each in self.conditions]),
            relative=relative_residual(self.equations, at, residual),
        )

    def bounded_step(self, trial: _Trial) -> Unknowns | None:
        """Newton's step, shortened to the largest step allowed; None where it has no solution."""
        solved = bordered_solution(
            self.equations,
            self.conditions,
            trial.at,
            trial.forces,
            trial.residual,
            trial.violations,
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
        return solved.times(-shrink)

    def crawls(self, better: _Trial) -> bool:
        """Whether steps have become too short to get anywhere, short of the end."""
        enough = 0 < self.options.crawls <= better.crawled
        return enough and better.merit > self.options.round_off

    def leap(self, trial: _Trial, step: Unknowns) -> _Trial | None:
        """A full step, or None where it leads far astray."""
        leapt = self.evaluated(trial.at.moved(step, 1.0), trial.forces)
        return leapt if leapt.merit <= self.options.wildest_leap else None

    def line_search(self, trial: _Trial, step: Unknowns) -> _Trial | None:
        """The longest of the fractions 1, 1/2, 1/4 ... that lowers the merit, or None."""
        fraction = 1.0
        while fraction >= self.options.shortest_fraction:
            candidate = self.evaluated(trial.at.moved(step, fraction), trial.forces)
            if candidate.merit < (1 - 1e-4 * fraction) * trial.merit:
                crawled = trial.crawled + 1 if fraction < _CRAWL else 0
                return replace(candidate, crawled=crawled)
            beyond = self.beyond(trial, candidate) if fraction == 1.0 else None
            if beyond is not None:
                return beyond
            fraction /= 2
        return None

    def beyond(self, trial: _Trial, leapt: _Trial) -> _Trial | None:
        """A motion of half the merit that further full steps lead to from a full one, or None."""
        far = trial.merit > _NEAR or leapt.merit > self.options.wildest_leap
        if not self.options.leaps or trial.crawled or far:
            return None
        for _ in range(_AHEAD):
            step = self.bounded_step(leapt)
            if step is None:
                return None
            leapt = self.evaluated(leapt.at.moved(step, 1.0), leapt.forces)
            if leapt.merit < trial.merit / 2:
                return leapt
        return None
