"""Results copied to another folder, in the way of a run: older ones are replaced at one instant."""

from __future__ import annotations

import shutil
from pathlib import Path

from mpi4py import MPI

from fenics_nnm.errors import OutputError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.interrupts import uninterrupted
from fenics_nnm.results.folder import assert_replaceable
from fenics_nnm.results.staging import RESULTS, Staging, move_results
from fenics_nnm.running.claiming import claimed


def save(source: Path, folder: Path) -> None:
    """Copy the results of a run; to be called on all ranks.

    Raises:
        StudyError: if the folder has files with names of results that no run has written.
        OutputError: if it cannot be written.
    """
    comm = MPI.COMM_WORLD
    if folder.resolve() == source.resolve():
        return
    on_root(comm, assert_replaceable, folder, [])
    with claimed(folder, comm) as staging:
        on_root(comm, _copied, source, staging)


def _copied(source: Path, staging: Staging) -> None:
    for name in RESULTS:
        _copy(source / name, staging.path / name)
    with uninterrupted():
        move_results(staging.path, staging.results)


def _copy(source: Path, target: Path) -> None:
    """Copy a file or a folder, if it is there.

    Raises:
        OutputError: if it cannot be copied.
    """
    try:
        if source.is_dir():
            shutil.copytree(source, target)
        elif source.exists():
            shutil.copyfile(source, target)
    except OSError as error:  # `shutil.Error` of a tree is one, with all its errors as arguments
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from error
