"""Work of one rank with arrays that all ranks make when it asks for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeVar

from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.blocks import Blocks
from fenics_nnm.fem.parallel import conducted

Key = TypeVar("Key")
Outcome = TypeVar("Outcome")


def led(
    comm: MPI.Comm,
    blocks: Mapping[Key, Blocks],
    work: Callable[[Mapping[Key, Blocks]], Outcome],
) -> Outcome:
    """Do `work` on rank 0 with blocks that all ranks make when it asks for them.

    Args:
        comm: Communicator of the ranks.
        blocks: Arrays that all ranks make together, on all ranks.
        work: Work of rank 0.

    Returns:
        What `work` gave, on every rank; or its error is raised on every rank.
    """

    def joint(asked: tuple[Key, slice]) -> Array:
        name, rows = asked
        return blocks[name].rows(rows)

    def conduct(together: Callable[[tuple[Key, slice]], Array]) -> Outcome:
        def of(name: Key) -> Blocks:
            return replace(blocks[name], rows=lambda rows: together((name, rows)))

        return work({name: of(name) for name in blocks})

    return conducted(comm, conduct, joint)
