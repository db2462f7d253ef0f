"""Processes of this machine that do one piece of work after the other."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from fenics_nnm.errors import ConvergenceError

#: What mpirun says to its processes: a worker must not take itself for one of them.
_OF_MPIRUN = ("OMPI_", "PMIX_", "PMI_", "PRTE_")

#: Seconds that workers have to keep what they found when all is stopped.
_PATIENCE = 60.0


class WorkerDied(ConvergenceError):
    """The process of a worker has ended while something was asked of it; its text says how."""


@dataclass(frozen=True, slots=True)
class WorkerProcess:
    """A process, and the connection to it.

    Attributes:
        process: The process.
        connection: Where work goes and what came of it returns.
    """

    process: BaseProcess
    connection: Connection

    @classmethod
    def started(cls, work: Callable[..., None], *given: Any) -> WorkerProcess:
        """A process that calls `work` with its connection and what is given."""
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=work, args=(theirs, *given), daemon=True)
        with _without_mpirun():
            process.start()
        theirs.close()
        return cls(process, ours)

    @property
    def alive(self) -> bool:
        """Whether the process has not ended."""
        return self.process.is_alive()

    def send(self, message: object) -> None:
        """Send work; that a process is dead is found when its answer is read."""
        with suppress(BrokenPipeError):
            self.connection.send(message)

    def received(self) -> Any:
        """What it sends.

        Raises:
            WorkerDied: if it has ended.
        """
        try:
            return self.connection.recv()
        except (EOFError, ConnectionResetError) as error:
            self.process.join()
            raise WorkerDied(_death(self.process.exitcode or 0)) from error

    def stop(self, *, busy: bool) -> None:
        """Let it end: at once where it waits, else as soon as it has kept what it found."""
        if busy:
            self.process.terminate()
        self.connection.close()
        self.process.join(_PATIENCE)
        if self.process.is_alive():
            self.process.kill()


def ready_of(workers: Sequence[WorkerProcess]) -> list[int]:
    """Indices of workers that have sent something, or have ended; waits for one at least."""
    sent = wait([worker.connection for worker in workers])
    return [number for number, worker in enumerate(workers) if worker.connection in sent]


def _death(code: int) -> str:
    if code >= 0:
        return f"its process ended with exit code {code}"
    name = signal.Signals(-code).name
    advice = ": out of memory? use fewer --jobs" if name == "SIGKILL" else ""
    return f"its process was ended by {name}{advice}"


def begin_work(*, verbose: bool) -> None:
    """What a worker begins with: its log, and PETSc."""
    logging.basicConfig(format="fenics-nnm: %(message)s")
    logging.getLogger("fenics_nnm").setLevel(logging.INFO if verbose else logging.WARNING)
    from fenics_nnm.fem import petsc_options

    petsc_options.begin()


@contextmanager
def few_threads(jobs: int) -> Iterator[None]:
    """Threads of linear algebra so that all processes together have one a core, unless set."""
    name = "OMP_NUM_THREADS"
    if name in os.environ:
        yield
        return
    os.environ[name] = str(max(1, len(os.sched_getaffinity(0)) // jobs))
    try:
        yield
    finally:
        del os.environ[name]


@contextmanager
def _without_mpirun() -> Iterator[None]:
    """An environment in which a new process is no rank of anything."""
    taken: Mapping[str, str] = {
        key: value for key, value in os.environ.items() if key.startswith(_OF_MPIRUN)
    }
    kept = {key: value for key, value in taken.items() if "MCA" in key or "ALLOW" in key}
    for key in taken.keys() - kept.keys():
        del os.environ[key]
    try:
        yield
    finally:
        os.environ.update(taken)
