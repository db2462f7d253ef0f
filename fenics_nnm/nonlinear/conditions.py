"""Conditions that pick one motion of a family, and quantities that can be kept at a value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.equations import OMEGA, Equations
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns


class Condition(Protocol):
    """An equation besides those of the harmonics."""

    def value(self, equations: Equations, at: Unknowns) -> float:
        """Left-hand side, of order one where violated."""

    def gradient(self, equations: Equations, at: Unknowns) -> Unknowns:
        """Derivatives of the left-hand side by coefficients and parameters."""


@dataclass(frozen=True, slots=True)
class FixedEnergy:
    """gamma / target - 1 = 0."""

    gamma: float

    def value(self, equations: Equations, at: Unknowns) -> float:
        """Relative distance from the wanted gamma."""
        return equations.energy.gamma(at) / self.gamma - 1

    def gradient(self, equations: Equations, at: Unknowns) -> Unknowns:
        """Derivatives by coefficients and parameters."""
        slope = equations.energy.gamma_gradient(at)
        return Unknowns(slope.q / self.gamma, slope.parameters / self.gamma)


@dataclass(frozen=True, slots=True)
class FixedFrequency:
    """omega / target - 1 = 0."""

    omega: float

    def value(self, equations: Equations, at: Unknowns) -> float:
        """Relative distance from the wanted frequency."""
        return at.omega / self.omega - 1

    def gradient(self, equations: Equations, at: Unknowns) -> Unknowns:
        """Derivatives by coefficients and parameters."""
        by_parameter = np.zeros(len(at.parameters))
        by_parameter[0] = 1 / self.omega
        return Unknowns(np.zeros_like(at.q), by_parameter)


@dataclass(frozen=True, slots=True)
class FixedPhase:
    """Steps are orthogonal to a small shift in time: row . (q - q0) = 0.

    Attributes:
        row: Unit vector of the shift of q0, shape of q.
        anchor: q0, the motion whose phase is kept.
    """

    row: Array
    anchor: Array

    @classmethod
    def of(cls, equations: Equations, q: Array) -> FixedPhase:
        """The phase of a motion is kept."""
        shift = equations.phase_shift(q)
        size = max(float(np.linalg.norm(shift)), np.finfo(float).tiny)
        return cls(np.asarray(shift / size), q)

    def value(self, equations: Equations, at: Unknowns) -> float:
        """Distance along the shift."""
        return float(np.sum(self.row * (at.q - self.anchor)))

    def gradient(self, equations: Equations, at: Unknowns) -> Unknowns:
        """Derivatives by coefficients and parameters."""
        return Unknowns(self.row, np.zeros(len(at.parameters)))


def own_conditions(equations: Equations, q: Array) -> tuple[Condition, ...]:
    """Conditions that belong to equations: the phase of a free motion, anchored at a guess."""
    return (FixedPhase.of(equations, q),) if equations.free_phase else ()


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number that a motion has, and that can be kept at a value.

    Attributes:
        name: Name.
        value: From a solution to the number.
        fixed: From a number to the condition that a motion has it.
    """

    name: str
    value: Callable[[Solution], float]
    fixed: Callable[[float], Condition]

    def slope(self, equations: Equations, solution: Solution, step: Unknowns) -> float:
        """Relative change of the quantity along a change of the unknowns."""
        by = self.fixed(self.value(solution)).gradient(equations, solution.at)
        count = min(len(by.parameters), len(step.parameters))
        return float(np.sum(by.q * step.q) + by.parameters[:count] @ step.parameters[:count])


GAMMA = Quantity("gamma", lambda solution: solution.energies.gamma, FixedEnergy)
FREQUENCY = Quantity(OMEGA, lambda solution: solution.omega, FixedFrequency)
