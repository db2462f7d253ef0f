"""Speeds of a Campbell diagram spread over processes of this machine.

Each process computes the modes of a speed. They are named here, from the lowest speed up, as soon
as all lower speeds are there; then the same process goes on with the nonlinear motions, so that it
needs no second static state. The numbers are those of one process.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fenics_nnm.errors import ConvergenceError, ModelError, NonlinearModeError
from fenics_nnm.running.campbell_journal import CampbellJournal, Done, key_of
from fenics_nnm.running.campbell_worker import Answer, Asked, Order, work
from fenics_nnm.running.nonlinear_lines import failed_motions
from fenics_nnm.running.worker_process import (
    WorkerDied,
    WorkerProcess,
    few_threads,
    ready_of,
)
from fenics_nnm.stages import Stages
from fenics_nnm.structure.campbell import AtSpeed, at_speed, spun, with_followed, without_modes
from fenics_nnm.structure.motions_at_speed import MotionAtSpeed
from fenics_nnm.structure.spinning import FollowedModes, SpinModes
from fenics_nnm.study.resolution import Resolution

Go = tuple[int, tuple[Order, ...]]
"""Number of a speed, from 0, and what the worker that holds it is to do before it lets it go."""


#: What a worker is asked for.
_MODES, _MOTIONS = "modes", "motions"


@dataclass(frozen=True, slots=True)
class _Named:
    """A speed whose modes have their names.

    Attributes:
        number: Its number, from 0.
        study: The study there, with the number of its mode.
        point: What is known of it without its motions.
    """

    number: int
    study: Any
    point: AtSpeed


@dataclass(slots=True)
class Board:
    """What is known of all speeds, and what is to be done next.

    Attributes:
        asked: What is asked for.
        speeds: Speeds in rad/s, ascending.
        journal: Keeps the motions of speeds that are done.
        points: Speeds that are done, by their number from 0.
    """

    asked: Asked
    speeds: Sequence[float]
    journal: CampbellJournal
    points: dict[int, AtSpeed] = field(default_factory=dict)
    _followed: FollowedModes = field(init=False)
    _modes: dict[int, Answer[SpinModes]] = field(default_factory=dict)
    _next: int = 0
    _named: list[_Named] = field(default_factory=list)
    _moving: dict[int, tuple[_Named, str]] = field(default_factory=dict)
    _resolution: Resolution | None = None

    def __post_init__(self) -> None:
        self._followed = FollowedModes(self.asked.modes, _product)

    @property
    def complete(self) -> bool:
        """Whether all speeds are done."""
        return len(self.points) == len(self.speeds)

    def modes_came(self, number: int, answer: Answer[SpinModes]) -> None:
        """Take the modes at a speed."""
        self._modes[number] = answer

    def motions_came(self, number: int, answer: Answer[Done]) -> None:
        """Take the motions at a speed.

        Raises:
            NonlinearModeError: if they could not be looked for.
        """
        named, key = self._moving.pop(number)
        try:
            done = answer.get()
        except (ConvergenceError, ModelError) as error:
            self._end(named, failed_motions(self.asked.targets, error))
        else:
            self.journal.add(key, done)
            self._take(named, done)

    def orders(self) -> Iterator[Go]:
        """What workers are to do with the speeds that they hold, as far as that is known.

        Raises:
            NonlinearModeError: if the structure has no modes.
        """
        while self._next in self._modes:
            yield from self._name(self._next, self._modes.pop(self._next))
            self._next += 1
        while self._named and not self._awaits_numbers(self._named[0]):
            yield self._order(self._named.pop(0))

    def _name(self, number: int, answer: Answer[SpinModes]) -> Iterator[Go]:
        """Name the modes of the next speed; without any it is done."""
        speed = self.speeds[number]
        try:
            modes = answer.get()
        except NonlinearModeError as error:
            self.points[number] = without_modes(speed, error, self._followed)
            yield number, ()
        else:
            kept = self._followed.at(modes)
            study = with_followed(spun(self.asked.study, speed), kept)
            self._named.append(_Named(number, study, at_speed(self.asked.study, modes, kept, ())))

    def _awaits_numbers(self, named: _Named) -> bool:
        """Whether numbers that are "auto" are being found at another speed."""
        return bool(named.study.automatic and self._moving and not self._resolution)

    def _order(self, named: _Named) -> Go:
        """What is to be done at a speed; nothing where its motions are known or not asked for."""
        if not self.asked.targets:
            self._end(named, ())
            return named.number, ()
        found = self._resolution if named.study.automatic else None
        key = key_of(named.study, self.asked.targets, found)
        known = self.journal.known.get(key)
        if known is not None:
            self._take(named, known)
            return named.number, ()
        self._moving[named.number] = (named, key)
        return named.number, (Order(named.study, self._resolution),)

    def _take(self, named: _Named, done: Done) -> None:
        self._resolution = done.resolution
        self._end(named, done.motions)

    def _end(self, named: _Named, motions: tuple[MotionAtSpeed, ...]) -> None:
        self.points[named.number] = replace(named.point, motions=motions)


def _product(left: Any, right: Any) -> Any:
    return np.asarray(left.T @ right)


@dataclass(slots=True)
class _Worker:
    """A process, the speed that it holds, and what it is asked; nothing between two of them."""

    process: WorkerProcess
    holds: tuple[int, ...] = ()
    asked: tuple[str, ...] = ()


def lines_on_processes(board: Board, jobs: int, stages: Stages) -> tuple[AtSpeed, ...]:
    """Speeds of a diagram, as `structure.campbell.campbell_lines` has them.

    A worker that dies takes its present speed with it alone: another one takes its place.

    Args:
        board: What is asked for.
        jobs: Number of processes.
        stages: Timings and progress.

    Raises:
        NonlinearModeError: as `structure.campbell.campbell_lines`.
    """
    with few_threads(jobs), stages.stage("speeds"):
        crew = _Crew(board, min(jobs, len(board.speeds)))
        try:
            while not board.complete:
                crew.step()
                stages.report(len(board.points) / len(board.speeds))
        finally:
            crew.stop()
    return tuple(board.points[number] for number in range(len(board.speeds)))


class _Crew:
    """Workers, and the speeds that none of them has taken."""

    def __init__(self, board: Board, count: int) -> None:
        self._board = board
        self._left = list(range(len(board.speeds)))
        self._workers = [_Worker(self._started()) for _ in range(count)]

    def step(self) -> None:
        """Give speeds to those that have none, and take what comes next."""
        for worker in self._workers:
            if not worker.holds and self._left:
                self._give(worker, self._left.pop(0))
        busy = [worker for worker in self._workers if worker.asked]
        for index in ready_of([worker.process for worker in busy]):
            self._take(busy[index])
        for number, orders in self._board.orders():
            self._go(number, orders)

    def stop(self) -> None:
        """End all."""
        for worker in self._workers:
            worker.process.stop(busy=bool(worker.asked))

    def _started(self) -> WorkerProcess:
        return WorkerProcess.started(work, self._board.asked)

    def _give(self, worker: _Worker, number: int) -> None:
        worker.holds, worker.asked = (number,), (_MODES,)
        worker.process.send(self._board.speeds[number])

    def _take(self, worker: _Worker) -> None:
        """Take an answer."""
        (number,), (kind,) = worker.holds, worker.asked
        try:
            answer = worker.process.received()
        except WorkerDied as death:
            answer, worker.process, worker.holds = Answer(errors=(death,)), self._started(), ()
        worker.asked = ()
        if kind == _MODES:
            self._board.modes_came(number, answer)
        else:
            worker.holds = ()
            self._board.motions_came(number, answer)

    def _go(self, number: int, orders: tuple[Order, ...]) -> None:
        """Have the worker of a speed go on, if it has not died."""
        for worker in self._workers:
            if worker.holds == (number,):
                worker.process.send(orders)
                worker.asked = (_MOTIONS,) if orders else ()
                worker.holds = worker.holds if orders else ()
