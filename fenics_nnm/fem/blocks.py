"""Arrays of a whole body that no rank holds at once: they are made some rows at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.parallel import conducted

Key = TypeVar("Key")
Outcome = TypeVar("Outcome")

#: Bytes of the rows that are made together, unless one row has more.
AT_ONCE = 2**24


@dataclass(frozen=True, slots=True)
class Blocks:
    """An array of floats whose rows all ranks make together.

    Attributes:
        shape: Its shape.
        rows: Makes a slice of its rows, whole on rank 0; to be called on all ranks.
    """

    shape: tuple[int, ...]
    rows: Callable[[slice], Array]

    @property
    def bytes_(self) -> int:
        """Size of the whole array in bytes."""
        return 8 * math.prod(self.shape)

    def slices(self) -> Iterator[slice]:
        """Slices of the rows, one after the other, of no more than `AT_ONCE` bytes or one row."""
        of_row = 8 * math.prod(self.shape[1:])
        step = max(1, AT_ONCE // max(1, of_row))
        for start in range(0, self.shape[0], step):
            yield slice(start, min(start + step, self.shape[0]))


Data = Mapping[str, Array | Blocks]
"""Data sets by their place in a file, such as "mesh/points"."""


def led(
    comm: MPI.Comm,
    data: Mapping[Key, Array | Blocks],
    work: Callable[[Mapping[Key, Any]], Outcome],
) -> Outcome:
    """Do `work` on rank 0 with data sets whose blocks all ranks make when it asks for them.

    Args:
        comm: Communicator of the ranks.
        data: Data sets; the blocks are on all ranks.
        work: Work of rank 0.

    Returns:
        What `work` gave, on every rank; or its error is raised on every rank.
    """
    blocks = {name: each for name, each in data.items() if isinstance(each, Blocks)}

    def joint(asked: tuple[Key, slice]) -> Array:
        name, rows = asked
        return blocks[name].rows(rows)

    def conduct(together: Callable[[tuple[Key, slice]], Array]) -> Outcome:
        def of(name: Key) -> Blocks:
            return replace(blocks[name], rows=lambda rows: together((name, rows)))

        return work({**data, **{name: of(name) for name in blocks}})

    return conducted(comm, conduct, joint)
