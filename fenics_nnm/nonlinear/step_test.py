"""Whether a step along a branch has stayed on it: a jump to another family is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.full_order import Equations
from fenics_nnm.nonlinear.newton import Solution

StepTest = Callable[[Equations, Solution, Solution], str]
"""From equations and the motions before and after a step to why it is refused, or nothing."""


@dataclass(frozen=True, slots=True)
class Continuity:
    """Refuses a step in which harmonic content jumps, or contact is lost for good above grazing.

    Tongues end near a linear mode written in a harmonic, where it grazes: contact may be lost there
    for a moment. Further down that linear mode there is nothing to be found.

    Attributes:
        largest_change: Bound on the change of any share of the kinetic energy, by harmonic or by
            mode and harmonic.
        grazing_gamma: Up to this gamma a motion may be without contact. It is 1/4 for the followed
            mode of a dimensionless model, k^2 times as much for a motion written in its k-th
            harmonic; infinity refuses nothing.
        clearance: Above it, a motion without contact may clear its gap by this part of it.
    """

    largest_change: float = 0.1
    grazing_gamma: float = 0.25
    clearance: float = 0.05

    def __call__(self, equations: Equations, before: Solution, after: Solution) -> str:
        """Why a step is refused; empty where it is not."""
        change = self._change(equations, before, after)
        if change > self.largest_change:
            return (
                f"the share of the kinetic energy in one harmonic jumps by {change:.2g}, more than"
                f" largest_change = {self.largest_change:g}"
            )
        above = after.energies.gamma > self.grazing_gamma * (1 + 1e-9)
        if above and not after.forces.force.any() and _clearance(equations, after) > self.clearance:
            return "contact is lost above the energy of grazing, as on a linear mode in a harmonic"
        return ""

    def _change(self, equations: Equations, before: Solution, after: Solution) -> float:
        """Largest change of a share, by harmonic or by mode and harmonic."""
        change = kinetic_shares(equations, after.q) - kinetic_shares(equations, before.q)
        return float(max(np.abs(change).max(), np.abs(change.sum(axis=1)).max()))


def _clearance(equations: Equations, solution: Solution) -> float:
    """Smallest distance from the obstacle of a motion without contact, relative to the gap."""
    approach = equations.series.synthesis @ solution.free / equations.model.gap
    return float(1 - approach.max())


def kinetic_shares(equations: Equations, q: Array) -> Array:
    """Shares of the kinetic energy by harmonic 0..N and mode, shape (N + 1, J).

    At full order the energy of the residual shapes is left out.
    """
    series = equations.series
    coefficients = q[:, : equations.model.modes]
    kinetic = (series.mean_square * series.order**2)[:, None] * coefficients**2
    shares = np.zeros((series.harmonics + 1, coefficients.shape[1]))
    np.add.at(shares, series.order.astype(int), kinetic)
    return np.asarray(shares / kinetic.sum())
