r"""Changes of the state along a step of exponential collocation, with second-order kinematics.

The variational equations have the remainder n_q dq + n_v dq', where n_q is zero but in columns and
rows of the masters, and n_v in columns of these. With y_i = (dq_m, dq'_m, rows of n_q . dq) at node
i, k numbers each, the remainder there is B_i y_i, and what it does to y at all nodes is a matrix:

    y = h + A y,      h: y of the oscillators without remainder,

3 k s equations for all changes at once, in place of an iteration on all coordinates.
"""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.time_domain.exponential_rule import Weights


def varied(
    masters: Indices, V: Array, weights: Weights, tangents: tuple[Array, Array], changes: Array
) -> Array:
    """Remainder of the variational equations at the nodes, in coordinates of the stage.

    Args:
        masters: Places of the masters, shape (k,).
        V: Modes of the stage as columns, shape (J, J).
        weights: Weights at the s nodes.
        tangents: n_q and n_v at the nodes, each of shape (s, J, J).
        changes: Changes of the coordinates of the stage at the start, and below them those of
            their velocities, shape (2 J, c).

    Returns:
        Shape (J, s, c).
    """
    by_q, by_velocity = tangents
    nodes, k = len(by_q), len(masters)
    pushes = _pushes(masters, V, by_q, by_velocity)
    seen = np.tile(V[masters], (nodes, 1, 1))
    rows = by_q[:, masters]  # a copy
    rows[:, :, masters] = 0.0
    position = np.concatenate([seen, rows @ V], axis=1)
    free = _free(weights, position, seen, changes)
    both = weights.both.transpose(1, 2, 0)  # times and velocities below, nodes, J
    parts = (position[:, :, None] * both[:nodes, None], seen[:, :, None] * both[nodes:, None])
    # (node, row, node of the push, J), rows dq_m, dq'_m, rows of n_q
    seen_there = np.concatenate([parts[0][:, :k], parts[1], parts[0][:, k:]], axis=1)
    size, count = nodes * 3 * k, changes.shape[1]
    by_node = seen_there.transpose(2, 0, 1, 3).reshape(nodes, size, len(V)) @ pushes
    A = by_node.transpose(1, 0, 2).reshape(size, size)
    found = np.linalg.solve(np.eye(size) - A, free.reshape(size, count))
    remainder = pushes @ found.reshape(nodes, 3 * k, count)
    return np.asarray(remainder.swapaxes(0, 1))


def _pushes(masters: Indices, V: Array, by_q: Array, by_velocity: Array) -> Array:
    """V^T B_i, shape (s, J, 3 k)."""
    nodes, k = len(by_q), len(masters)
    B = np.zeros((nodes, len(V), 3 * k))
    B[:, :, :k], B[:, :, k : 2 * k] = by_q[:, :, masters], by_velocity[:, :, masters]
    B[:, masters, 2 * k + np.arange(k)] = 1.0
    return V.T @ B


def _free(weights: Weights, position: Array, seen: Array, changes: Array) -> Array:
    """H: what is seen of the oscillators without remainder, shape (s, 3 k, c)."""
    k = seen.shape[1]
    cosine, sine = weights.cosine.T[:, None], weights.sine.T[:, None]
    places = np.concatenate([position * cosine, position * (sine / weights.nu)], axis=2)
    rates = np.concatenate([seen * (-sine * weights.nu), seen * cosine], axis=2)
    rows = np.concatenate([places[:, :k], rates, places[:, k:]], axis=1)
    return np.asarray(rows @ changes)
