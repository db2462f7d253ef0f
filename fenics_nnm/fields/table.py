"""A table on the disk that parts of a body are written to and fields of the whole are read from."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array, Indices


@dataclass(frozen=True, slots=True)
class PartTable:
    """Rows of numbers, one number for each node, that are kept part by part.

    Attributes:
        path: File of the table.
        parts: Nodes of each part, all of them together.
        rows: Number of rows.
    """

    path: Path
    parts: Sequence[Indices]
    rows: int

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return sum(len(part) for part in self.parts)

    def make(self) -> None:
        """Make the file with all the room that it needs.

        Raises:
            OSError: if there is none.
        """
        size = 8 * self.rows * self.nodes
        with self.path.open("xb") as file:
            if size:
                os.posix_fallocate(file.fileno(), 0, size)

    def put(self, part: int, first: int, values: Array) -> None:
        """Keep rows from `first` on at the nodes of a part, shape (k, nodes of the part).

        Raises:
            OSError: if they cannot be written.
        """
        with self.path.open("r+b") as file:
            file.seek(self._place(part, first))
            file.write(np.ascontiguousarray(values, dtype=np.float64).data)

    def read(self, rows: slice) -> Array:
        """Some rows at all nodes, shape (k, nodes)."""
        count = rows.stop - rows.start
        found = np.empty((count, self.nodes))
        with self.path.open("rb") as file:
            for number, nodes in enumerate(self.parts):
                file.seek(self._place(number, rows.start))
                own = np.frombuffer(file.read(8 * count * len(nodes)))
                found[:, nodes] = own.reshape(count, len(nodes))
        return found

    def _place(self, part: int, row: int) -> int:
        before = sum(len(nodes) for nodes in self.parts[:part])
        return 8 * (before * self.rows + row * len(self.parts[part]))
