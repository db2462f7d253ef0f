"""Whether a step along a branch has stayed on it: a jump to another family is refused."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.equations import Equations
from fenics_nnm.nonlinear.solution import Solution


@dataclass(frozen=True, slots=True)
class Continuity:
    """Refuses a step in which harmonic content jumps, or contact does not change above grazing.

    Attributes:
        largest_change: Bound on the change of any share of the kinetic energy, by harmonic or by
            mode and harmonic.
        grazing_gamma: From this gamma on contact may not be lost; infinity if it may. It is 1/4
            for the followed mode of a dimensionless model, k^2 times as much for a motion written
            in its k-th harmonic.
        to_rest: Whether the branch is followed down a linear mode without contact.
    """

    largest_change: float = 0.1
    grazing_gamma: float = 0.25
    to_rest: bool = False

    def refusal(self, equations: Equations, before: Solution, after: Solution) -> str:
        """Why a step is refused; empty where it is not."""
        change = self._change(equations, before, after)
        if change > self.largest_change:
            return (
                f"the share of the kinetic energy in one harmonic jumps by {change:.2g}, more than"
                f" largest_change = {self.largest_change:g}"
            )
        lost = before.energies.contact and not after.energies.contact
        if lost and after.energies.gamma > self.grazing_gamma * (1 + 1e-9):
            return "contact is lost above the energy of grazing, as on a linear mode in a harmonic"
        return ""

    def end(self, before: Solution, after: Solution) -> str:
        """Why the branch ends after a step: there is nothing to be found on the way to rest."""
        free = not (before.energies.contact or after.energies.contact)
        if free and after.energies.gamma < before.energies.gamma and not self.to_rest:
            return "the branch has come to a linear mode without contact, and leads down to rest"
        return ""

    def _change(self, equations: Equations, before: Solution, after: Solution) -> float:
        """Largest change of a share, by harmonic or by mode and harmonic."""
        change = kinetic_shares(equations, after.q) - kinetic_shares(equations, before.q)
        return float(max(np.abs(change).max(), np.abs(change.sum(axis=1)).max()))


def kinetic_shares(equations: Equations, q: Array) -> Array:
    """Shares of the kinetic energy by harmonic 0..N and mode, shape (N + 1, J).

    At full order the energy of the residual shapes is left out.
    """
    series = equations.series
    coefficients = equations.modal(q)
    kinetic = (series.mean_square * series.order**2)[:, None] * coefficients**2
    shares = np.zeros((series.harmonics + 1, coefficients.shape[1]))
    np.add.at(shares, series.order.astype(int), kinetic)
    return np.asarray(shares / kinetic.sum())
