"""Unknowns of harmonic equations: coefficients of a motion, and the parameters of the problem."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array


@dataclass(frozen=True, slots=True)
class Unknowns:
    """Coefficients and parameters; a step, or a derivative by them, has the same form.

    Attributes:
        q: Coefficients of the motion, shape (c, J).
        parameters: Parameters in the order of the names that the equations give them, shape (p,);
            the circular frequency comes first.
    """

    q: Array
    parameters: Array

    @classmethod
    def of(cls, q: Array, *parameters: float) -> Unknowns:
        """Coefficients and single parameters."""
        return cls(q, np.array(parameters))

    @property
    def omega(self) -> float:
        """Circular frequency."""
        return float(self.parameters[0])

    def moved(self, step: Unknowns, fraction: float) -> Unknowns:
        """These, and a fraction of a step, whose missing parameters do not change."""
        change = step.completed(len(self.parameters)).parameters
        return Unknowns(self.q + fraction * step.q, self.parameters + fraction * change)

    def times(self, factor: float) -> Unknowns:
        """All of them times a factor."""
        return Unknowns(factor * self.q, factor * self.parameters)

    def completed(self, count: int) -> Unknowns:
        """The same with `count` parameters: those that are missing are 0."""
        if len(self.parameters) == count:
            return self
        return replace(self, parameters=np.append(self.parameters, [0.0] * count)[:count])
