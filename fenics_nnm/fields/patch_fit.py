"""Least-squares polynomials through values at the points of many patches at once.

In coordinates in which the points of a patch have no mean and unit covariance, constant and linear
terms L are orthogonal: L^T L = n. With quadratic terms Q the fit c of values b is

    c_Q = (Q - L P)^+ b,    c_L = L^T b / n - P c_Q,    P = L^T Q / n.

The pseudoinverse leaves out what the points do not settle. What remains depends neither on the axes
nor on the size of the patch.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: A patch whose points lie in a plane, or on a line, to this part of its size does not settle how
#: stress changes across.
_FLAT = 1e-6

#: A combination of quadratic terms that is smaller than this part of the largest one at the points
#: of a patch, once constant and linear terms are taken out, is not settled by them and left out:
#: with two layers of points across a thin body, the square of the coordinate across.
_SETTLED = 1e-3


def fitted(points: Array, places: Array, patch: Indices, degree: int) -> Array:
    """Weights, in the values of polynomials at places, of values at the points of their patches.

    Args:
        points: Points of patches that have as many, shape (patches, points, dim).
        places: Places, shape (places, dim).
        patch: The patch whose polynomial is wanted at each of them, shape (places,).
        degree: Degree of the polynomials, 1 or 2.

    Returns:
        Shape (places, points).
    """
    mean = points.mean(axis=1, keepdims=True)
    scaling = _whitening(points - mean)
    L, Q = _terms((points - mean) @ scaling, degree)
    L_at, Q_at = _terms((places[:, None] - mean[patch]) @ scaling[patch], degree)
    linear = np.swapaxes(L, 1, 2) / points.shape[1]
    weights = L_at @ linear[patch]
    if degree > 1:
        P = linear @ Q
        weights += (Q_at - L_at @ P[patch]) @ np.linalg.pinv(Q - L @ P, rcond=_SETTLED)[patch]
    return np.asarray(weights[:, 0])


def _whitening(points: Array) -> Array:
    """Symmetric matrices that give points without mean unit covariance, zero across a plane."""
    variance, axes = np.linalg.eigh(np.swapaxes(points, 1, 2) @ points / points.shape[1])
    spread = variance > _FLAT**2 * variance[:, -1:]
    size = np.sqrt(np.where(spread, variance, np.inf))
    return np.asarray((axes / size[:, None]) @ np.swapaxes(axes, 1, 2))


def _terms(x: Array, degree: int) -> tuple[Array, Array]:
    """Constant and linear terms at points, and quadratic ones whose norm no rotation changes."""
    columns = np.moveaxis(x, -1, 0)
    pairs = combinations_with_replacement(columns, 2) if degree > 1 else ()
    quadratic = [a * b * (1.0 if a is b else np.sqrt(2.0)) for a, b in pairs]
    linear = np.stack([np.ones_like(columns[0]), *columns], axis=-1)
    return linear, np.stack(quadratic, axis=-1) if quadratic else np.empty((*x.shape[:-1], 0))
