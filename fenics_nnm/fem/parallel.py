"""Work done on one rank for all of them."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from types import TracebackType
from typing import Any, ParamSpec, Self, TypeVar, cast

from mpi4py import MPI

Given = ParamSpec("Given")
Result = TypeVar("Result")
Argument = TypeVar("Argument")
Outcome = TypeVar("Outcome")


def on_root(
    comm: MPI.Comm, work: Callable[Given, Result], *given: Given.args, **named: Given.kwargs
) -> Result:
    """Do `work` on rank 0; every rank gets its result, or raises its error.

    Args:
        comm: Communicator of the ranks.
        work: Work of rank 0.
        given: Its arguments.
        named: Its keyword arguments.

    An error is raised alike on all ranks, so that none of them waits for the others.
    """
    outcome: tuple[Any, Exception | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (work(*given, **named), None)
        except Exception as error:
            comm.bcast((None, error), root=0)
            raise  # with its own traceback
    result, failure = comm.bcast(outcome, root=0)
    if failure is not None:
        raise failure
    return cast(Result, result)


def each_own(comm: MPI.Intracomm, steps: Iterable[Result]) -> list[Result]:
    """Do the steps of this rank, none of which waits for another rank, and give their results.

    An error is raised on all ranks, of several errors that of the lowest rank: the others stop
    after the step that they are at.
    """
    apart = comm.Dup()
    results: list[Result] = []
    failure: Exception | None = None
    try:
        for result in steps:
            results.append(result)
            if apart.Iprobe():
                break
    except Exception as error:
        failure = error
    others = [rank for rank in range(comm.size) if failure is not None and rank != comm.rank]
    sent = [apart.isend(None, dest=rank) for rank in others]
    failures = apart.allgather(failure)
    for rank, found in enumerate(failures):
        if found is not None and rank != comm.rank:
            apart.recv(source=rank)
    MPI.Request.waitall(sent)
    apart.Free()
    for rank, found in enumerate(failures):
        if found is not None:
            raise failure if failure is not None and rank == comm.rank else found
    return results


def beside_root(comm: MPI.Intracomm) -> tuple[range, int]:
    """Which of the ranks on the machine of rank 0 this one is, in a range, and how many these are.

    The range of a rank on another machine is empty.
    """
    machine = comm.Split_type(MPI.COMM_TYPE_SHARED)
    beside = machine.allreduce(comm.rank, op=MPI.MIN) == 0
    own = range(machine.rank, machine.rank + 1) if beside else range(0)
    count = comm.bcast(machine.size, root=0)
    machine.Free()
    return own, count


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
                # rank 0 meets it too, and reports
    outcome = on_root(comm, lead)
    apart.Free()
    return outcome
