"""The least stiffness of one matrix relative to another one whose factors are known, by Lanczos.

The eigenvalues of K_T phi = ratio K phi are one where loads do not change the stiffness, so that
the few others, and one below zero above all, are found in few steps. B. N. Parlett, The Symmetric
Eigenvalue Problem, 1998, chapter 13.
"""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc
from scipy.linalg import eigh_tridiagonal

from fenics_nnm.arrays import Array
from fenics_nnm.fem.block import product
from fenics_nnm.reduction.operators import Product

#: The least ratio is known when it is off by this part of it at most; so many steps at most.
_ACCURACY, _LEAST_STEPS, _MOST_STEPS = 0.1, 6, 40

#: What starts the search: any vector that is not free of the lowest mode.
_SEED = 20


def least_ratio(tangent: PETSc.Mat, solve: Product, enough: float = np.inf) -> float:
    """A lower bound of the least eigenvalue of K^-1 K_T to some 10 per cent; on all ranks.

    Args:
        tangent: K_T, symmetric.
        solve: K^-1 of columns of forces, K symmetric and positive definite.
        enough: A bound above this is taken however close it is.

    Returns:
        The bound; minus infinity if it is not found in 40 steps.
    """
    comm = tangent.comm.tompi4py()
    rng = np.random.default_rng(_SEED + comm.rank)
    rows = tangent.getLocalSize()[0]
    force = rng.normal(size=rows)
    shape = solve(force[:, None])[:, 0]
    diagonal: list[float] = []
    beside: list[float] = []
    kept: list[tuple[Array, Array]] = []  # v and K v
    size = float(np.sqrt(comm.allreduce(float(shape @ force))))
    for step in range(1, _MOST_STEPS + 1):
        shape, force = shape / size, force / size
        kept.append((shape, force))
        image = product(tangent, shape[:, None])[:, 0]
        diagonal.append(float(comm.allreduce(float(shape @ image))))
        next_shape = solve(image[:, None])[:, 0]
        for _ in range(2):
            for other, pulled in kept:
                part = float(comm.allreduce(float(pulled @ next_shape)))
                next_shape, image = next_shape - part * other, image - part * pulled
        size = float(np.sqrt(max(0.0, comm.allreduce(float(next_shape @ image)))))
        values, vectors = eigh_tridiagonal(np.array(diagonal), np.array(beside))
        error = size * abs(float(vectors[-1, 0]))
        lowest = float(values[0])
        close = error <= _ACCURACY * abs(lowest) or lowest - error > enough
        if close and (step >= _LEAST_STEPS or not size):
            return lowest - error
        if lowest + error < 0:
            return lowest
        beside.append(size)
        shape, force = next_shape, image
    return -np.inf
