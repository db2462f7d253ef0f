"""Results of a run, read, with the folder that they are in."""

from __future__ import annotations

import shutil
import weakref
from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI

from fenics_nnm.errors import OutputError
from fenics_nnm.output.pictures.results import Results, read_results
from fenics_nnm.results.kinds import is_response
from fenics_nnm.results.stored_branch import StoredBranch


@dataclass(frozen=True, eq=False)
class Loaded:
    """What a branch and its points share.

    Attributes:
        folder: Folder of the results.
        results: What is in it.
    """

    folder: Path
    results: Results

    def body(self, what: str) -> StoredBranch:
        """The branch on its mesh.

        Args:
            what: What it is asked for, for the message.

        Raises:
            OutputError: if it is of matrices.
        """
        if self.results.body is None:
            raise OutputError(f"{what}: needs a mesh: the study has [matrices]")
        return self.results.body


def loaded(folder: Path, *, temporary: bool = False) -> Loaded:
    """Read results, whose folder is removed when they are not used any more if it is temporary.

    Raises:
        OutputError: if they cannot be read, or are of a response.
    """
    if is_response(folder):
        raise OutputError(f"{folder}: has the results of a response: must be those of a run")
    found = Loaded(folder, read_results(folder))
    if temporary and MPI.COMM_WORLD.rank == 0:
        weakref.finalize(found, shutil.rmtree, folder, ignore_errors=True)
    return found
