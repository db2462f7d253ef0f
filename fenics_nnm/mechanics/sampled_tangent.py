"""Derivatives of harmonics by harmonics, from derivatives at the samples."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array


def sampled_tangent(analysis: Array, synthesis: Array, blocks: Array) -> Array:
    """sum_k A_nk B_k S_kn' over samples k, shape (c I, d J), rows by (n, i), columns by (n', j).

    Args:
        analysis: A, samples to coefficients, shape (c, s).
        synthesis: S, coefficients to samples, shape (s, d).
        blocks: B, derivatives at the samples, shape (s, I, J).
    """
    rows, columns = len(analysis), synthesis.shape[1]
    at, high, wide = blocks.shape
    mixing = analysis[:, None, :] * synthesis.T[None, :, :]
    mixed = mixing.reshape(rows * columns, at) @ blocks.reshape(at, high * wide)
    whole = mixed.reshape(rows, columns, high, wide).swapaxes(1, 2)
    return np.asarray(whole.reshape(rows * high, columns * wide))


def tangent_of_few(analysis: Array, synthesis: Array, blocks: Array) -> Array:
    """The same of few forces and coordinates, shape (c, I, d, J)."""
    moved = blocks.transpose(1, 2, 0)[..., None] * synthesis
    return np.asarray((analysis @ moved).transpose(2, 0, 3, 1))
