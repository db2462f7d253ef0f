"""Folders of results that go with what was made of them."""

from __future__ import annotations

import shutil
import weakref
from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI


@dataclass(frozen=True, eq=False)
class Folder:
    """A folder of results, for as long as something holds this.

    Attributes:
        path: The folder.
    """

    path: Path

    def removed_at_last(self) -> Folder:
        """The same; it is removed when nothing holds it any more."""
        if MPI.COMM_WORLD.rank == 0:
            weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)
        return self
