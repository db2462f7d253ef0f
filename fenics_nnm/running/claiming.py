"""The folder that a run makes its results in, for as long as the run needs it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mpi4py import MPI

from fenics_nnm.errors import OutputError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.interrupts import uninterrupted
from fenics_nnm.results.staging import Staging, claim, rescue


@contextmanager
def claimed(folder: Path, comm: MPI.Comm) -> Iterator[Staging]:
    """A folder inside the results folder, which belongs to this run until the context ends.

    Where the context ends by an error, the points found so far are kept, and the error notes where.
    Results that were published before, and older ones, are left alone.

    Raises:
        StudyError: if the results folder cannot be written to.
        OutputError: in place of an error of the operating system.
    """
    staging = on_root(comm, claim, folder)
    try:
        yield staging
    except BaseException as error:
        if comm.rank == 0:
            with uninterrupted():
                _note(error, rescue(staging))
        if isinstance(error, OSError) and not isinstance(error, OutputError):
            raise _unwritable(error, folder) from error
        raise
    finally:
        if comm.rank == 0:
            staging.release()


def _note(error: BaseException, text: str) -> None:
    if text:
        error.add_note(text)


def _unwritable(error: OSError, folder: Path) -> OutputError:
    """The error of the operating system as one of ours."""
    wrapped = OutputError(
        f"{error.filename or folder}: cannot be written: {error.strerror or error}"
    )
    wrapped.__notes__ = getattr(error, "__notes__", [])
    return wrapped
