"""Sparse rows over the displacement blocks of all ranks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from scipy.sparse import coo_array, csr_array

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.solid import Solid


@dataclass(frozen=True, slots=True)
class Entries:
    """Entries of a sparse matrix that this rank knows of.

    Attributes:
        rows: Row of each entry.
        blocks: Global displacement block of each entry.
        values: Value of each entry.
    """

    rows: Indices
    blocks: Indices
    values: Array

    def minus(self, other: Entries) -> Entries:
        """These entries less others."""
        return Entries(
            np.concatenate([self.rows, other.rows]),
            np.concatenate([self.blocks, other.blocks]),
            np.concatenate([self.values, -other.values]),
        )

    @classmethod
    def joined(cls, parts: Iterable[tuple[Indices, Indices, Array]]) -> Entries:
        """All parts together."""
        none = (np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))
        rows, blocks, values = zip(none, *parts, strict=True)
        return cls(np.concatenate(rows), np.concatenate(blocks), np.concatenate(values))


def owned_rows(solid: Solid, entries: Entries, count: int) -> csr_array:
    """Columns of the blocks that this rank owns, of a matrix whose entries all ranks bring.

    Blocks that are held in all directions are left out: they do not move.

    Args:
        solid: Assembled body.
        entries: Entries that this rank knows of, each on one rank.
        count: Number of rows.
    """
    comm: MPI.Comm = solid.tagged.mesh.comm
    first, last = solid.space.dofmap.index_map.local_range
    rows, blocks, values = (
        np.concatenate(comm.allgather(part))
        for part in (entries.rows, entries.blocks, entries.values)
    )
    block, directions = np.unique(solid.clamped // solid.tagged.dim, return_counts=True)
    held = block[directions == solid.tagged.dim]
    mine = (blocks >= first) & (blocks < last) & ~np.isin(blocks - first, held)
    at = (rows[mine], blocks[mine] - first)
    return csr_array(coo_array((values[mine], at), shape=(count, last - first)))


def along_axes(weights: csr_array, local: Array, dim: int, comm: MPI.Comm) -> Array:
    """Displacements of places along the axes; arguments as of `along`.

    Returns:
        Shape (n, dim, k), the same on all ranks.
    """
    own = [weights @ local[axis::dim] for axis in range(dim)]
    return np.asarray(comm.allreduce(np.stack(own, axis=1)))


def along(directions: Array, weights: csr_array, local: Array, comm: MPI.Comm) -> Array:
    """Displacements of places along their directions.

    Args:
        directions: Unit vectors, shape (n, dim).
        weights: Weights of the owned blocks in the displacement of each place, (n, owned blocks).
        local: Columns of owned degrees of freedom, shape (n_owned, k).
        comm: Communicator.

    Returns:
        Shape (n, k), the same on all ranks.
    """
    dim = directions.shape[1]
    parts = (directions[:, axis, None] * (weights @ local[axis::dim]) for axis in range(dim))
    return np.asarray(comm.allreduce(sum(parts)))
