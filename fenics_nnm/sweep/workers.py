"""Studies of a sweep spread over processes of this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection

from fenics_nnm.running.worker_process import (
    WorkerDied,
    WorkerProcess,
    begin_work,
    few_threads,
    ready_of,
)
from fenics_nnm.sweep.case import Case, RunState
from fenics_nnm.sweep.dealing import Hand, LocalCounters
from fenics_nnm.sweep.running import Ran


@dataclass(slots=True)
class Worker:
    """A process that runs one study after the other.

    Attributes:
        process: The process.
        hand: What it takes.
        case: Study that it runs; None between two.
    """

    process: WorkerProcess
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
    with few_threads(jobs):
        workers = [
            _started(Hand(groups, counters, number % len(groups)), verbose)
            for number in range(min(jobs, sum(map(len, groups))))
        ]
        try:
            for worker in workers:
                _give(worker, states)
            while busy := [worker for worker in workers if worker.case is not None]:
                for number in ready_of([worker.process for worker in busy]):
                    worker = busy[number]
                    on_ran(_received(worker))
                    if not worker.process.alive:
                        workers.remove(worker)
                        worker = _started(worker.hand, verbose)
                        workers.append(worker)
                    _give(worker, states)
        finally:
            for worker in workers:
                worker.process.stop(busy=worker.case is not None)


def _started(hand: Hand, verbose: bool) -> Worker:
    return Worker(WorkerProcess.started(work, verbose), hand)


def _give(worker: Worker, states: Mapping[int, RunState]) -> None:
    worker.case = worker.hand.take()
    if worker.case is not None:
        worker.process.send((worker.case, states[worker.case.number]))


def _received(worker: Worker) -> Ran:
    assert worker.case is not None
    try:
        ran: Ran = worker.process.received()
        return ran
    except WorkerDied as death:
        return Ran(worker.case.number, str(death))


def work(connection: Connection, verbose: bool) -> None:
    """What a worker does until nothing more comes."""
    begin_work(verbose=verbose)
    from fenics_nnm.interrupts import terminable
    from fenics_nnm.stages import Stages
    from fenics_nnm.sweep.running import Runner

    runner = Runner(lambda: nullcontext(Stages()), verbose=verbose)
    with suppress(EOFError, BrokenPipeError, KeyboardInterrupt), terminable():
        while True:
            case, state = connection.recv()
            connection.send(runner.run(case, state))
