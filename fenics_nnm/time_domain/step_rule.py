"""Times and weights of a step of exponential collocation, of some length in a stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.exponential_rule import GaussNodes, Weights
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.remainder import Remainder


@dataclass(frozen=True, slots=True)
class Rule:
    """Times and weights of a step.

    What the remainder sees at the nodes, node by node, is affine in the state at the start and in
    the pushes at the nodes.

    Attributes:
        step: Length in s.
        nodes: Gauss points, s of them.
        offset: What is seen at x = 0, shape (3 k + P,).
        by_start: What is seen by coordinates at the start, and their velocities below, of shape
            (s (3 k + P), 2 J).
        by_pushes: What is seen by the pushes, shape (s (3 k + P), s (P + k)).
        watched: Times at which margins are looked at, the last at the end, shape (d,).
        at_watched: Weights at these.
        at_end: Weights at the end.
    """

    step: float
    nodes: GaussNodes
    offset: Array
    by_start: Array
    by_pushes: Array
    watched: Array
    at_watched: Weights
    at_end: Weights

    @classmethod
    def of(cls, nodes: GaussNodes, nu: Array, remainder: Remainder, step: float) -> Rule:
        """Times apart by no more than a radian of the fastest mode."""
        count = max(8, int(np.ceil(step * nu[-1])))
        watched = step * np.arange(1, count + 1) / count
        at_nodes = Weights.of(nodes, nu, step, step * nodes.at)
        return cls(
            step=step,
            nodes=nodes,
            offset=np.concatenate([remainder.offset, np.zeros(len(remainder.rate))]),
            by_start=_by_start(at_nodes, remainder),
            by_pushes=_by_pushes(at_nodes, remainder),
            watched=watched,
            at_watched=Weights.of(nodes, nu, step, watched),
            at_end=Weights.of(nodes, nu, step, watched[-1:]),
        )

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        weights = self.at_watched.both, self.at_end.both
        return bytes_of(self.by_start, self.by_pushes, *weights)

    def free(self, x: Array, rate: Array) -> Array:
        """What is seen without pushes, from a state in coordinates of the stage, (s, 3 k + P)."""
        seen = self.by_start @ np.concatenate([x, rate])
        return np.asarray(seen.reshape(len(self.nodes.at), len(self.offset)) + self.offset)

    def seen_of(self, pushes: Array) -> Array:
        """What is seen of pushes (s, P + k), shape (s, 3 k + P)."""
        return np.asarray((self.by_pushes @ pushes.ravel()).reshape(len(pushes), len(self.offset)))


def _by_start(weights: Weights, remainder: Remainder) -> Array:
    """Shape (s (3 k + P), 2 J)."""
    cosine, sine, nu = weights.cosine.T[:, None], weights.sine.T[:, None], weights.nu
    position, rate = remainder.position, remainder.rate
    places = np.concatenate([position * cosine, position * (sine / nu)], axis=2)
    rates = np.concatenate([rate * (-sine * nu), rate * cosine], axis=2)
    rows = len(places) * remainder.seen
    return np.concatenate([places, rates], axis=1).reshape(rows, 2 * len(nu))


def _by_pushes(weights: Weights, remainder: Remainder) -> Array:
    """Shape (s (3 k + P), s (P + k))."""
    nodes, pushes = weights.both.shape[2], remainder.pushes
    parts = []
    for rows, both in (
        (remainder.position, weights.both[:, :nodes]),
        (remainder.rate, weights.both[:, nodes:]),
    ):
        along = (rows[:, None, :] * remainder.directions.T).reshape(
            len(rows) * pushes, len(weights.nu)
        )
        found = along @ both.reshape(len(weights.nu), nodes**2)
        parts.append(found.reshape(len(rows), pushes, nodes, nodes))
    # (row, push, node, node of the push)
    whole = np.concatenate(parts).transpose(2, 0, 3, 1)
    return np.ascontiguousarray(whole).reshape(nodes * remainder.seen, nodes * pushes)
