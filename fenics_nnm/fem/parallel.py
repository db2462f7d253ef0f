"""Work done on one rank for all of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from mpi4py import MPI

Result = TypeVar("Result")


def on_root(comm: MPI.Comm, work: Callable[[], Result]) -> Result:
    """Do `work` on rank 0; every rank gets its result, or raises its error.

    An error is raised alike on all ranks, so that none of them waits for the others.
    """
    outcome: tuple[Any, Exception | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (work(), None)
        except Exception as error:
            outcome = (None, error)
    result, failure = comm.bcast(outcome, root=0)
    if failure is not None:
        raise failure
    return cast(Result, result)
