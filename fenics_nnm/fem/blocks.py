"""Arrays of a whole body that no rank holds at once: they are made some rows at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from fenics_nnm.arrays import Array

#: Bytes of the rows that are made together, unless one row has more.
AT_ONCE = 2**24

#: Place in a file of the mesh as it was read.
KEPT_MESH = "input_mesh"


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


@dataclass(frozen=True, slots=True)
class Data:
    """Data sets by their place in a file, such as "mesh/points".

    Attributes:
        arrays: Those that are in memory, on rank 0 at least.
        blocks: Those that all ranks make together.
        packed: Those that are stored compressed, on rank 0 at least.
    """

    arrays: Mapping[str, Array]
    blocks: Mapping[str, Blocks] = field(default_factory=dict)
    packed: Mapping[str, Any] = field(default_factory=dict)
