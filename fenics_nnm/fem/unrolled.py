"""Degrees of freedom one by one, of blocks that have one for each axis."""

from __future__ import annotations

import numpy as np
from dolfinx import fem

from fenics_nnm.arrays import Indices


def unrolled(blocks: Indices, size: int) -> Indices:
    """Degrees of freedom of blocks of a size, shape (blocks size,)."""
    return np.asarray((blocks[:, None] * size + np.arange(size)).ravel(), dtype=blocks.dtype)


def owned_rows(space: fem.FunctionSpace, local: Indices) -> Indices:
    """Rows of a matrix of those of some degrees of freedom that this rank owns.

    Args:
        space: Displacement space.
        local: Local degrees of freedom, ghosts included, unrolled.
    """
    size, index_map = space.dofmap.index_map_bs, space.dofmap.index_map
    own = local[local < index_map.size_local * size]
    return np.asarray(own + index_map.local_range[0] * size, dtype=local.dtype)
