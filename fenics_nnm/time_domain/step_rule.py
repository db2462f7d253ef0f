"""Times and weights of a step of exponential collocation, of some length in a stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.time_domain.exponential_rule import GaussNodes, Weights
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.remainder import Remainder
from fenics_nnm.time_domain.step_series import StepSeries


@dataclass(frozen=True, slots=True)
class Rule:
    """Times and weights of a step.

    What the remainder sees at the nodes, a row for each number and a column for each node, is
    affine in the state at the start and in the pushes at the nodes.

    Attributes:
        step: Length in s.
        nodes: Gauss points, s of them.
        offset: What is seen at x = 0, shape ((3 k + P) s,).
        by_start: What is seen by coordinates at the start, and their velocities below, of shape
            ((3 k + P) s, 2 J).
        by_pushes: What is seen by the pushes, shape ((3 k + P) s, (P + k) s).
        watched: Times at which margins are looked at, the last at the end, shape (d,).
        at_watched: Weights at these.
        series: Series of the motion between these.
        at_end: Weights at the end.
        end_by_start: Coordinates at the end and their velocities by those at the start, without
            pushes, shape (2 J, 2 J).
        end_by_pushes: The same by the pushes, shape (2 J, (P + k) s).
        diagonal: Where a square matrix of pushes, with rows node by node, has each push by itself,
            shape ((P + k) s,).
        onwards: From pushes to a guess at those of a following step of this length, shape (s, s).
    """

    step: float
    nodes: GaussNodes
    offset: Array
    by_start: Array
    by_pushes: Array
    watched: Array
    at_watched: Weights
    series: StepSeries
    at_end: Weights
    end_by_start: Array
    end_by_pushes: Array
    diagonal: Indices
    onwards: Array

    @classmethod
    def of(
        cls, nodes: GaussNodes, nu: Array, remainder: Remainder, step: float, first: float
    ) -> Rule:
        """A step in which margins are looked at a radian of the fastest mode apart, or less.

        Args:
            nodes: Gauss points.
            nu: Circular frequencies of the stage, ascending, shape (J,).
            remainder: Its remainder.
            step: Length in s.
            first: First time at which margins are looked at.
        """
        count = max(8, int(np.ceil(step * nu[-1])))
        watched = step * np.arange(1, count + 1) / count
        watched = np.append(first, watched[watched > first])
        at_nodes = Weights.of(nodes, nu, step, step * nodes.at)
        at_end = Weights.of(nodes, nu, step, np.array([step]))
        offset = np.concatenate([remainder.offset, np.zeros(len(remainder.rate))])
        return cls(
            step=step,
            nodes=nodes,
            offset=np.repeat(offset, len(nodes.at)),
            by_start=_by_start(at_nodes, remainder),
            by_pushes=_by_pushes(at_nodes, remainder),
            watched=watched,
            at_watched=Weights.of(nodes, nu, step, watched),
            series=StepSeries.of(nodes, nu, step, watched, step / count),
            at_end=at_end,
            end_by_start=at_end.by_start,
            end_by_pushes=at_end.by_pushes(remainder.directions),
            diagonal=_diagonal(len(nodes.at), remainder.pushes),
            onwards=nodes.beyond(1 + nodes.at, np.eye(len(nodes.at))),
        )

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        weights = self.at_watched.both, self.at_end.both
        ends = self.end_by_start, self.end_by_pushes
        return bytes_of(self.by_start, self.by_pushes, *ends, *weights) + self.series.nbytes

    def free(self, x: Array, rate: Array) -> Array:
        """What is seen without pushes, from a state of the stage, shape ((3 k + P) s,)."""
        return np.asarray(self.by_start @ np.concatenate([x, rate]) + self.offset)


def _diagonal(nodes: int, pushes: int) -> Indices:
    """Flat places of a square matrix, rows by node and push, columns by push and node."""
    columns = np.arange(nodes * pushes).reshape(pushes, nodes).T.ravel()
    return np.arange(nodes * pushes) * (nodes * pushes) + columns


def _by_start(weights: Weights, remainder: Remainder) -> Array:
    """Shape ((3 k + P) s, 2 J)."""
    both = np.stack([weights.by_x, weights.by_rate])
    places, rates = np.split(both, 2, axis=2)
    parts = [
        np.einsum("ij,bjt->itbj", rows, at)
        for rows, at in ((remainder.position, places), (remainder.rate, rates))
    ]
    return np.concatenate(parts).reshape(-1, 2 * both.shape[1])


def _by_pushes(weights: Weights, remainder: Remainder) -> Array:
    """Shape ((3 k + P) s, (P + k) s)."""
    nodes, pushes = weights.both.shape[2], remainder.pushes
    parts = []
    for rows, both in (
        (remainder.position, weights.both[:, :nodes]),
        (remainder.rate, weights.both[:, nodes:]),
    ):
        along = (rows[:, None, :] * remainder.directions.T).reshape(
            len(rows) * pushes, len(weights.both)
        )
        found = along @ both.reshape(len(weights.both), nodes**2)
        parts.append(found.reshape(len(rows), pushes, nodes, nodes))
    # (row, node, push, node of the push)
    whole = np.concatenate(parts).transpose(0, 2, 1, 3)
    return np.ascontiguousarray(whole).reshape(nodes * remainder.seen, nodes * pushes)
