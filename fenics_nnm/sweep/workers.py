"""Studies of a sweep spread over processes of this machine."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from fenics_nnm.sweep.dealing import Hand, LocalCounters
from fenics_nnm.sweep.outcome import RunState
from fenics_nnm.sweep.plan import Case
from fenics_nnm.sweep.running import Ran

#: What mpirun says to its processes: a worker must not take itself for one of them.
_OF_MPIRUN = ("OMPI_", "PMIX_", "PMI_", "PRTE_")

#: Seconds that workers have to keep their points when all is stopped.
_PATIENCE = 60.0


@dataclass(slots=True)
class Worker:
    """A process that runs one study after the other.

    Attributes:
        process: The process.
        connection: Where studies go and what was run comes back.
        hand: What it takes.
        case: Study that it runs; None between two.
    """

    process: BaseProcess
    connection: Connection
    hand: Hand
    case: Case | None = None


def run_on_processes(
    groups: Sequence[Sequence[Case]],
    states: Mapping[int, RunState],
    jobs: int,
    on_ran: Callable[[Ran], None],
    *,
    verbose: bool = False,
) -> None:
    """Run all studies.

    A worker that dies takes its present study with it alone: another one takes its place.

    Args:
        groups: Studies by groups that share a linear analysis.
        states: How far each study is, by its number.
        jobs: Number of processes.
        on_ran: Called with each study that was run.
        verbose: Whether the processes report their stages and where errors come from.
    """
    counters = LocalCounters([0] * len(groups))
    with _few_threads(jobs):
        workers = [
            _started(Hand(groups, counters, number % len(groups)), verbose)
            for number in range(min(jobs, sum(map(len, groups))))
        ]
        try:
            for worker in workers:
                _give(worker, states)
            while busy := [worker for worker in workers if worker.case is not None]:
                for ready in wait([worker.connection for worker in busy]):
                    worker = next(each for each in busy if each.connection is ready)
                    ran = _received(worker)
                    on_ran(ran)
                    if not worker.process.is_alive():
                        workers.remove(worker)
                        worker = _started(worker.hand, verbose)
                        workers.append(worker)
                    _give(worker, states)
        finally:
            for worker in workers:
                _stop(worker)


def _started(hand: Hand, verbose: bool) -> Worker:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=work, args=(theirs, verbose), daemon=True)
    with _without_mpirun():
        process.start()
    theirs.close()
    return Worker(process, ours, hand)


def _give(worker: Worker, states: Mapping[int, RunState]) -> None:
    worker.case = worker.hand.take()
    if worker.case is not None:
        with suppress(BrokenPipeError):  # it is dead: found when its answer is read
            worker.connection.send((worker.case, states[worker.case.number]))


def _received(worker: Worker) -> Ran:
    assert worker.case is not None
    try:
        ran: Ran = worker.connection.recv()
        return ran
    except (EOFError, ConnectionResetError):
        worker.process.join()
        return Ran(worker.case.number, _death(worker.process.exitcode or 0))


def _death(code: int) -> str:
    if code >= 0:
        return f"its process ended with exit code {code}"
    name = signal.Signals(-code).name
    advice = ": out of memory? use fewer --jobs" if name == "SIGKILL" else ""
    return f"its process was ended by {name}{advice}"


def _stop(worker: Worker) -> None:
    """Let a worker end: at once where it waits, else as soon as it has kept its points."""
    if worker.case is not None:
        worker.process.terminate()
    worker.connection.close()
    worker.process.join(_PATIENCE)
    if worker.process.is_alive():
        worker.process.kill()


def work(connection: Connection, verbose: bool) -> None:
    """What a worker does until nothing more comes."""
    logging.basicConfig(format="fenics-nnm: %(message)s")
    logging.getLogger("fenics_nnm").setLevel(logging.INFO if verbose else logging.WARNING)
    from fenics_nnm.fem import petsc_options
    from fenics_nnm.interrupts import terminable
    from fenics_nnm.stages import Stages
    from fenics_nnm.sweep.running import Runner

    petsc_options.begin()
    runner = Runner(lambda: nullcontext(Stages()), verbose=verbose)
    with suppress(EOFError, BrokenPipeError, KeyboardInterrupt), terminable():
        while True:
            case, state = connection.recv()
            connection.send(runner.run(case, state))


@contextmanager
def _few_threads(jobs: int) -> Iterator[None]:
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
    taken = {key: value for key, value in os.environ.items() if key.startswith(_OF_MPIRUN)}
    kept = {key: value for key, value in taken.items() if "MCA" in key or "ALLOW" in key}
    for key in taken.keys() - kept.keys():
        del os.environ[key]
    try:
        yield
    finally:
        os.environ.update(taken)
