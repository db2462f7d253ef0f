"""Margins of contact points in a smooth stage, and their rates, from its own coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.linear_stage import LinearStage
from fenics_nnm.time_domain.master_pairs import MasterPairs, tensors_of


@dataclass(frozen=True, slots=True)
class StageMargins:
    """Margins of p - gap with p = Phi q + 1/2 q^T Theta q, q = rest + V x, see `mechanics.closed`.

    Attributes:
        pairs: Pairs of masters.
        masters: Masters by x, shape (k, J).
        rest: Masters at x = 0, shape (k,).
        linear: Phi V, shape (n_c, J).
        squared: 1/2 Theta by products of masters, shape (P, n_c).
        offset: Phi rest - gap, shape (n_c,).
        margin: Margins by p - gap, shape (n_c, n_c).
        gap: Gaps in m, shape (n_c,).
    """

    pairs: MasterPairs
    masters: Array
    rest: Array
    linear: Array
    squared: Array
    offset: Array
    margin: Array
    gap: Array

    @classmethod
    def of(cls, model: ReducedModel, linear: LinearStage, margin: Array) -> StageMargins:
        """Those of a stage, and its margins by p - gap."""
        masters = model.kinematics.masters
        pairs = MasterPairs.of(len(masters))
        Theta = tensors_of(model)[0]
        return cls(
            pairs=pairs,
            masters=linear.V[masters],
            rest=linear.rest[masters],
            linear=model.Phi @ linear.V,
            squared=pairs.weighted(Theta).T / 2,
            offset=model.Phi @ linear.rest - model.gap,
            margin=margin,
            gap=model.gap,
        )

    def at(self, x: Array, rate: Array) -> tuple[Array, Array, Array]:
        """Margins, their rates, and the sizes of what they are differences of.

        Args:
            x: Coordinates of the stage, shape (t, J).
            rate: Their velocities, shape (t, J).

        Returns:
            Shapes (t, n_c), (t, n_c) and (n_c,).
        """
        q, velocity = x @ self.masters.T + self.rest, rate @ self.masters.T
        excess = x @ self.linear.T + self.pairs.monomials(q) @ self.squared + self.offset
        closing = rate @ self.linear.T + self.pairs.product_rates(q, velocity) @ self.squared
        size = np.abs(excess).max(axis=0) + self.gap
        return excess @ self.margin.T, closing @ self.margin.T, size
