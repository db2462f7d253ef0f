"""Margins of contact points in a smooth stage, and their rates, from its own coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.linear_stage import LinearStage
from fenics_nnm.time_domain.master_pairs import MasterPairs, tensors_of


@dataclass(frozen=True, slots=True)
class StageMargins:
    """Margins of p - gap with p = Phi q + 1/2 q^T Theta q, q = rest + V x, see `mechanics.closed`.

    Attributes:
        pairs: Pairs of masters.
        points: Number of contact points.
        by_x: Margins by x, but for what bends, and masters below, shape (n_c + k, J).
        at_rest: The same at x = 0, shape (n_c + k, 1).
        squared: Margins by products of masters, shape (n_c, P).
        gap: Gaps in m, shape (n_c,).
    """

    pairs: MasterPairs
    points: int
    by_x: Array
    at_rest: Array
    squared: Array
    gap: Array

    @classmethod
    def of(cls, model: ReducedModel, linear: LinearStage, margin: Array) -> StageMargins:
        """Those of a stage, and its margins by p - gap."""
        masters = model.kinematics.masters
        pairs = MasterPairs.of(len(masters))
        rows = np.vstack([margin @ model.Phi, np.eye(model.modes)[masters]])
        at_rest = rows @ linear.rest
        at_rest[: model.points] -= margin @ model.gap
        return cls(
            pairs=pairs,
            points=model.points,
            by_x=rows @ linear.V,
            at_rest=at_rest[:, None],
            squared=margin @ pairs.weighted(tensors_of(model)[0]) / 2,
            gap=model.gap,
        )

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return bytes_of(self.by_x, self.at_rest, self.squared)

    def at(self, x: Array) -> Array:
        """Margins at coordinates of the stage, (J, t), shape (n_c, t)."""
        return self._margins(self.by_x @ x + self.at_rest)

    def along(self, motion: Array) -> tuple[Array, Array, Array]:
        """Margins, their rates, and the sizes of what they are differences of.

        Args:
            motion: Coordinates of the stage and, beside them, their velocities, shape (J, 2 t).

        Returns:
            Shapes (n_c, t), (n_c, t) and (n_c,).
        """
        moved, count = self.by_x @ motion, motion.shape[1] // 2
        places, rates = moved[:, :count] + self.at_rest, moved[:, count:]
        turns = self.pairs.product_rates(places[self.points :], rates[self.points :])
        margins = self._margins(places)
        size = np.abs(margins).max(axis=1) + self.gap
        return margins, rates[: self.points] + self.squared @ turns, size

    def of_point(self, point: int, state: Array) -> tuple[float, float]:
        """Margin of a contact point and its rate at a state, coordinates and velocities (J, 2)."""
        place, rate = self.by_x[point] @ state
        masters = self.by_x[self.points :] @ state
        q, velocity = masters[:, 0] + self.at_rest[self.points :, 0], masters[:, 1]
        squared = self.squared[point]
        margin = place + self.at_rest[point, 0] + squared @ self.pairs.monomials(q)
        return float(margin), float(rate + squared @ self.pairs.product_rates(q, velocity))

    def _margins(self, places: Array) -> Array:
        """Margins from their linear part and the masters, (n_c + k, t)."""
        bent = self.squared @ self.pairs.monomials(places[self.points :])
        return np.asarray(places[: self.points] + bent)
