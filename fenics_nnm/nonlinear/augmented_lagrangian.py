"""Augmented Lagrangian for contact points that carry mass.

Laxalde and Legrand, Computational Mechanics 47 (2011) 469-478, Algorithms 1 to 3.

Each outer step solves the harmonic equations under the law lambda = kappa (g + theta)_+ with the
common Newton iteration, then moves the multipliers: theta += max(g, -theta). Where Powell's measure
|max(g, -theta)| has not fallen by alpha, the penalty grows and the multiplier shrinks by beta,
which leaves the force kappa theta as it is.

What differs from the paper, and why:

* kappa is a stiffness of the harmonic equations. In the paper's Lagrangian, which is divided by
  m^ / 2, the same penalty is kappa / gamma.
* h carries n^2 (Eqs. 11b, 12); Eq. (24c) drops it.
* The frequency is an unknown of the inner solve. "exact" keeps h = 0 as a row, the limit of an
  infinite kappa_e. "penalised" is the literal form: stationarity of

      L = r + <kappa (g + theta)_+^2> / 2 + kappa_e (h + theta_e)^2 / 2

  by U_n gives the harmonic equations with omega^2 = base - kappa_e (h + theta_e) m^ / 2. The base
  is r of the motion itself (Algorithm 1, "simultaneous") or a predicted omega^2 that is kept
  (Algorithm 2, "sequential"); the multiplier absorbs the difference, so both end in the same point.
* Penalties begin anew at each point, with theta = force / kappa: those carried along a branch only
  ever grow, and the inner problem becomes stiff for nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.penalty_law import AugmentedLagrangian
from fenics_nnm.nonlinear.conditions import Condition, FixedEnergy
from fenics_nnm.nonlinear.equations import Equations
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: First penalty of the normalisation, times gamma^2 over omega^2.
_FIRST_ENERGY_PENALTY = 10.0


@dataclass(frozen=True, slots=True)
class MultiplierLoop:
    """Configuration of Algorithm 3.

    Attributes:
        penalty: First penalty over the static contact stiffness of each point.
        alpha: A measure must fall by this factor in each outer step.
        beta: Growth of a penalty whose measure has not.
        tolerance: Penetration and tension, relative to the smallest gap, that end the loop.
        iterations: Largest number of outer steps.
        normalisation: "exact": h = 0 is a row; "penalised": the literal form.
        algorithm: Base of the penalised form: "simultaneous" (1) or "sequential" (2).
    """

    penalty: float = 10.0
    alpha: float = 4.0
    beta: float = 10.0
    tolerance: float = 1e-10
    iterations: int = 60
    normalisation: Literal["exact", "penalised"] = "exact"
    algorithm: Literal["simultaneous", "sequential"] = "simultaneous"


@dataclass(frozen=True, slots=True)
class PenalisedEnergy:
    """omega^2 - base + kappa_e (h + theta_e) m^ / 2 = 0 with h = m^ / 2 - gamma.

    Attributes:
        gamma: Wanted gamma.
        kappa: Penalty kappa_e.
        theta: Multiplier theta_e.
        base: Squared frequency that is kept (Algorithm 2), or None for r of the motion (1).
    """

    gamma: float
    kappa: float
    theta: float
    base: float | None

    def value(self, equations: Equations, at: Unknowns) -> float:
        """Left-hand side over omega^2."""
        gamma, omega = equations.energy.gamma(at), at.omega
        base = self._rayleigh(equations, at.q, gamma) if self.base is None else self.base
        return (omega**2 - base + self.kappa * (gamma - self.gamma + self.theta) * gamma) / omega**2

    def gradient(self, equations: Equations, at: Unknowns) -> Unknowns:
        """Derivatives by coefficients and parameters."""
        gamma, omega, q = equations.energy.gamma(at), at.omega, at.q
        gradient = equations.energy.gamma_gradient(at).q
        slope = self.kappa * (2 * gamma - self.gamma + self.theta)
        by_q = slope * gradient
        if self.base is None:
            stiffness = (
                equations.series.mean_square[:, None] * equations.mechanics.model.omega**2 * q
            )
            rayleigh = self._rayleigh(equations, q, gamma)
            by_q = by_q - (stiffness - rayleigh * gradient) / gamma
        constant = omega**2 * (1 - self.value(equations, at))
        by_parameter = np.zeros(len(at.parameters))
        by_parameter[0] = 2 * constant / omega**3
        return Unknowns(by_q / omega**2, by_parameter)

    @staticmethod
    def _rayleigh(equations: Equations, q: Array, gamma: float) -> float:
        mean_square = equations.series.mean_square[:, None]
        stiffness = np.sum(mean_square * (equations.mechanics.model.omega * q) ** 2)
        return float(stiffness / (2 * gamma))


class Normalisation(Protocol):
    """How gamma is kept through the outer steps."""

    @property
    def condition(self) -> Condition:
        """The condition of an inner solve."""

    def moved(self, gamma: float, before: float) -> tuple[Normalisation, float]:
        """The one of the next outer step, and |h| / gamma of a motion.

        Args:
            gamma: Gamma of the motion found.
            before: Smallest |h| / gamma so far.
        """


@dataclass(frozen=True, slots=True)
class ExactNormalisation:
    """h = 0 is a row: gamma is exact in each outer step."""

    condition: FixedEnergy

    @classmethod
    def first(cls, loop: MultiplierLoop, gamma: float, omega: float) -> ExactNormalisation:
        """The one to begin with."""
        return cls(FixedEnergy(gamma))

    def moved(self, gamma: float, before: float) -> tuple[Normalisation, float]:
        """It stays as it is."""
        return self, 0.0


@dataclass(frozen=True, slots=True)
class PenalisedNormalisation:
    """h is penalised, and a multiplier takes over."""

    condition: PenalisedEnergy
    loop: MultiplierLoop

    @classmethod
    def first(cls, loop: MultiplierLoop, gamma: float, omega: float) -> PenalisedNormalisation:
        """The one to begin with."""
        base = None if loop.algorithm == "simultaneous" else omega**2
        penalty = _FIRST_ENERGY_PENALTY * omega**2 / gamma**2
        return cls(PenalisedEnergy(gamma, penalty, 0.0, base), loop)

    def moved(self, gamma: float, before: float) -> tuple[Normalisation, float]:
        """With a moved multiplier, and a grown penalty where |h| has not fallen."""
        condition = self.condition
        h = gamma - condition.gamma
        measure = abs(h) / condition.gamma
        factor = self.loop.beta if measure > before / self.loop.alpha else 1.0
        grown = replace(
            condition, kappa=condition.kappa * factor, theta=(condition.theta + h) / factor
        )
        return replace(self, condition=grown), measure


_NORMALISATIONS: dict[str, Callable[[MultiplierLoop, float, float], Normalisation]] = {
    "exact": ExactNormalisation.first,
    "penalised": PenalisedNormalisation.first,
}


def first_law(equations: Equations, loop: MultiplierLoop, force: Array) -> AugmentedLagrangian:
    """Law of the first outer step: first penalties, multipliers that carry given forces."""
    stiffness = loop.penalty / equations.static_flexibility
    penalties = np.tile(stiffness, (len(force), 1))
    return AugmentedLagrangian(equations.mechanics.model.gap, penalties, force / stiffness)


def solve_with_multipliers(
    equations: Equations,
    gamma: float,
    q: Array,
    omega: float,
    force: Array,
    *,
    loop: MultiplierLoop,
    newton: Newton,
) -> Solution:
    """Find the motion of given gamma under Signorini's conditions at the samples.

    Args:
        equations: Harmonic equations of a model with R = 0; their law is replaced.
        gamma: Wanted modal energy coordinate.
        q: Guess, shape (N + 1, J).
        omega: Guess.
        force: Guess of the contact forces, shape (s, n_c).
        loop: Configuration of the multipliers.
        newton: Configuration of the inner iteration.

    Returns:
        A solution whose `failure` names the measure that did not fall, if one did not.
    """
    return _Loop(equations, gamma, loop, newton).run(q, omega, force)


@dataclass(frozen=True, slots=True)
class _Loop:
    equations: Equations
    gamma: float
    loop: MultiplierLoop
    newton: Newton

    def run(self, q: Array, omega: float, force: Array) -> Solution:
        law = first_law(self.equations, self.loop, force)
        kept: Normalisation = _NORMALISATIONS[self.loop.normalisation](self.loop, self.gamma, omega)
        solution = None
        contact = energy = np.inf
        steps = 0
        for _ in range(self.loop.iterations):
            equations = self.equations.with_law(law)
            solution = solve(equations, kept.condition, Unknowns.of(q, omega), options=self.newton)
            steps += solution.iterations
            if not solution.converged:
                return replace(solution, iterations=steps)
            q, omega = solution.q, solution.omega
            law, new_contact = self._moved_law(law, solution.free, contact)
            kept, new_energy = kept.moved(solution.energies.gamma, energy)
            contact, energy = min(contact, new_contact), min(energy, new_energy)
            if max(new_contact, new_energy) <= self.loop.tolerance:
                return replace(solution, iterations=steps)
        assert solution is not None
        measure = "contact" if new_contact > self.loop.tolerance else "energy"
        stalled = max(new_contact, new_energy)
        return replace(
            solution,
            iterations=steps,
            failure=f"the multiplier loop stalled after {self.loop.iterations} steps: the "
            f"{measure} measure stays at {stalled:.1e}, wanted {self.loop.tolerance:.1e}; "
            "raise the iterations or the penalty of the loop",
        )

    def _moved_law(
        self, law: AugmentedLagrangian, displacement: Array, before: float
    ) -> tuple[AugmentedLagrangian, float]:
        """Law with moved multipliers and grown penalties, and the largest contact measure."""
        at_samples = self.equations.series.synthesis @ displacement
        move = np.maximum(at_samples - law.gap, -law.theta)
        measure = np.abs(move) / law.gap.min()
        grown = measure > before / self.loop.alpha
        factor = np.where(grown, self.loop.beta, 1.0)
        moved = replace(law, kappa=law.kappa * factor, theta=(law.theta + move) / factor)
        return moved, float(measure.max())
