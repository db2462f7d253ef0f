"""How cells are cut into parts of about one size with few facets between them, by SCOTCH.

F. Pellegrini, J. Roman, SCOTCH, Proc. HPCN Europe 1996, 493-498; as dolfinx has it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from dolfinx import cpp
from mpi4py import MPI

from fenics_nnm.arrays import Indices

#: Seed of SCOTCH.
_SEED = 0

#: SCOTCH's variable for its threads: several give other parts each time.
_THREADS = "SCOTCH_PTHREAD_NUMBER"

#: Makes the function that cuts graphs into parts; none where dolfinx was built without SCOTCH.
_partitioner: Callable[..., Any] | None = getattr(cpp.graph, "partitioner_scotch", None)


def can_cut() -> bool:
    """Whether there is SCOTCH."""
    return _partitioner is not None


def cut(beside: Any, parts: int, imbalance: float) -> Indices:
    """Part of each cell, shape (cells,); the same each time. To be called where `can_cut`.

    Args:
        beside: Cells that each cell shares a facet with, of `pairs_listed`.
        parts: Number of parts; halves of halves have consecutive numbers.
        imbalance: Sizes of parts may differ by about this part.
    """
    assert _partitioner is not None
    with _one_thread():
        return np.asarray(_partitioner(imbalance, _SEED)(MPI.COMM_SELF, parts, beside, False).array)


def pairs_listed(pairs: Indices, cells: int) -> Any:
    """The cells beside each of some cells, as a list of dolfinx's.

    Args:
        pairs: Cells that share a facet, shape (pairs, 2).
        cells: Number of cells.
    """
    both = np.concatenate([pairs, pairs[:, ::-1]])
    first = np.r_[0, np.cumsum(np.bincount(both[:, 0], minlength=cells))].astype(np.int32)
    beside = both[np.argsort(both[:, 0], kind="stable"), 1].astype(np.int64)
    return cpp.graph.AdjacencyList_int64(beside, first)


def sharing_facets(cells: Indices, facets: Sequence[Sequence[int]]) -> Indices:
    """Pairs of cells that share a facet, shape (pairs, 2).

    Args:
        cells: Vertices of the cells, shape (cells, vertices a cell).
        facets: Which of them each facet of a cell has.
    """
    width = max(map(len, facets))
    corners = np.full((len(cells), len(facets), width), -1)
    for place, facet in enumerate(facets):
        corners[:, place, : len(facet)] = cells[:, facet]
    each = np.sort(corners.reshape(-1, width), axis=1)
    order = np.lexsort(each.T)
    same = (each[order[1:]] == each[order[:-1]]).all(axis=1)
    return np.stack([order[:-1][same], order[1:][same]], axis=1) // len(facets)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let SCOTCH have one thread inside, so that its parts are always the same."""
    before = os.environ.get(_THREADS)
    os.environ[_THREADS] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_THREADS]
        else:
            os.environ[_THREADS] = before
