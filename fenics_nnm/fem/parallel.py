"""Work done on one rank for all of them."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self, TypeVar, cast

from mpi4py import MPI

Result = TypeVar("Result")
Argument = TypeVar("Argument")
Outcome = TypeVar("Outcome")


def on_root(comm: MPI.Comm, work: Callable[[], Result]) -> Result:
    """Do `work` on rank 0; every rank gets its result, or raises its error.

    An error is raised alike on all ranks, so that none of them waits for the others.
    """
    outcome: tuple[Any, Exception | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (work(), None)
        except Exception as error:
            comm.bcast((None, error), root=0)
            raise  # with its own traceback
    result, failure = comm.bcast(outcome, root=0)
    if failure is not None:
        raise failure
    return cast(Result, result)


def all_arrive(comm: MPI.Comm, *, seconds: float = 5.0) -> bool:
    """Whether all ranks call this within some seconds of each other.

    Args:
        comm: Communicator that nothing else uses, as ranks that do not come may wait elsewhere.
        seconds: How long to wait for the others.
    """
    arrival = comm.Ibarrier()
    end = time.monotonic() + seconds
    while not arrival.Test():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


class HeldTogether(ABC):
    """A context manager of what all ranks hold together, and must be there to free."""

    def __init__(self, comm: MPI.Intracomm) -> None:
        """Prepare for the ranks of `comm`."""
        self._apart = comm.Dup()  # in `comm` ranks may wait for one that fails alone

    @abstractmethod
    def release(self) -> None:
        """Free it, on all ranks."""

    def __enter__(self) -> Self:
        """Enter the context."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Free it, if all ranks are there to do so."""
        if error is None or all_arrive(self._apart):
            self.release()
            self._apart.Free()


def conducted(
    comm: MPI.Comm,
    conduct: Callable[[Callable[[Argument], Result]], Outcome],
    joint: Callable[[Argument], Result],
) -> Outcome:
    """Do `conduct` on rank 0, with a function whose calls all ranks join.

    Args:
        comm: Communicator of the joint work.
        conduct: Work of rank 0; it is given `joint`, to be called as often as it likes.
        joint: Work that all ranks do together, such as a solution of the mesh's equations.

    Returns:
        What `conduct` gave, on every rank; or its error is raised on every rank.

    An error of `joint` on some ranks alone is raised there, and leaves the others waiting.
    """
    apart = comm.Dup()  # in `comm` the others may wait for one that fails alone

    def call(argument: Argument) -> Result:
        comm.bcast((argument,), root=0)
        try:
            return joint(argument)
        except Exception:
            all_arrive(apart)
            raise

    def lead() -> Outcome:
        try:
            return conduct(call)
        finally:
            comm.bcast(None, root=0)

    if comm.rank > 0:
        while (call_of_root := comm.bcast(None, root=0)) is not None:
            try:
                joint(*call_of_root)
            except Exception:
                if not all_arrive(apart):
                    raise
                # rank 0 meets it too, and tells
    outcome = on_root(comm, lead)
    apart.Free()
    return outcome
