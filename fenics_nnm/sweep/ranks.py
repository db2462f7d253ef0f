"""Studies of a sweep spread over the ranks of mpirun, each study on one rank."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fenics_nnm.sweep.case import Case
from fenics_nnm.sweep.dealing import Hand
from fenics_nnm.sweep.running import Ran


@dataclass(frozen=True, slots=True)
class SharedCounters:
    """Counters in the memory of rank 0, which all ranks change without its help.

    Attributes:
        window: Window of one 64-bit integer a group on rank 0.
        groups: Number of groups.
    """

    window: MPI.Win
    groups: int

    def take(self, group: int) -> int:
        """Count one more study of a group; the number before that."""
        before = np.zeros(1, dtype=np.int64)
        one = np.ones(1, dtype=np.int64)
        self.window.Lock(0)
        self.window.Fetch_and_op(one, before, 0, group * one.itemsize, MPI.SUM)
        self.window.Unlock(0)
        return int(before[0])

    def taken(self) -> Sequence[int]:
        """Studies taken of each group."""
        counts = np.zeros(self.groups, dtype=np.int64)
        self.window.Lock(0)
        self.window.Get(counts, 0)
        self.window.Unlock(0)
        return [int(count) for count in counts]


def run_on_ranks(
    groups: Sequence[Sequence[Case]], run: Callable[[Case], Ran], comm: MPI.Intracomm
) -> list[Ran]:
    """Run all studies; every rank gets what was run on any.

    Args:
        groups: Studies by groups that share a linear analysis.
        run: Runs a study on this rank alone.
        comm: Communicator over which they are spread.
    """
    size = len(groups) * np.dtype(np.int64).itemsize if comm.rank == 0 else 0
    window = MPI.Win.Allocate(size, 1, comm=comm)
    if comm.rank == 0:
        window.Lock(0)
        window.Put(np.zeros(len(groups), dtype=np.int64), 0)
        window.Unlock(0)
    comm.Barrier()
    hand = Hand(groups, SharedCounters(window, len(groups)), comm.rank % len(groups))
    ran = []
    while (case := hand.take()) is not None:
        ran.append(run(case))
    gathered = comm.allgather(ran)
    window.Free()
    return [each for part in gathered for each in part]
