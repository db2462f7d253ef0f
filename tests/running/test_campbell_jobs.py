"""Speeds of a Campbell diagram in any order of answers: the same as one after the other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI

from fenics_nnm.errors import ConvergenceError, ModelError
from fenics_nnm.running.campbell_jobs import Board, lines_on_processes
from fenics_nnm.running.campbell_journal import CampbellJournal
from fenics_nnm.running.campbell_worker import Answer, Asked, Order
from fenics_nnm.running.nonlinear_lines import NonlinearLines, motions_of
from fenics_nnm.running.worker_process import WorkerDied
from fenics_nnm.stages import Stages
from fenics_nnm.structure.campbell import AtSpeed, campbell_lines, spinning_of
from fenics_nnm.structure.motions_at_speed import Quantity, Target
from fenics_nnm.structure.spinning import Spin
from fenics_nnm.study import study_from

SPEEDS = [0.0, 0.3, 0.6, 0.9]
TARGETS = (Target(Quantity.ENERGY, 0.55),)


def two_masses(tmp_path: Path, **mode: Any) -> Asked:
    """The first mass meets a stop of stiffness 50; the frequencies of the two cross over speed."""
    np.savez(
        tmp_path / "masses.npz",
        K=[[51.0, -50.0, 0.0], [-50.0, 50.0, 0.0], [0.0, 0.0, 1.2]],
        M=np.diag([1.0, 0.0, 1.0]),
        B=[[0.0, 1.0, 0.0]],
        softening=np.diag([1.17, 0.0, 0.0]),
    )
    study = study_from(
        {
            "matrices": {"file": "masses.npz", "speed": 0.0, "speed_stiffness": "softening"},
            "contact": {"gap": 1.0},
            "reduction": {"modes": 2},
            "mode": {"number": 1, **mode},
        },
        tmp_path / "study.toml",
    )
    return Asked(study, 2, TARGETS)


def spins(asked: Asked) -> list[Answer[Spin]]:
    spinning = spinning_of(asked.study, MPI.COMM_SELF, Stages())
    return [Answer.of(lambda speed=speed: spinning.at(speed, 2)) for speed in SPEEDS]


def moving(spin: Answer[Spin], order: Order) -> Answer[Any]:
    analyse = spin.get().analyse
    return Answer.of(lambda: motions_of(order.study, analyse, TARGETS, MPI.COMM_SELF, order.found))


def modes(spin: Answer[Spin]) -> Answer[Any]:
    return Answer(tuple(each.modes for each in spin.values), spin.errors)


def numbers(points: tuple[AtSpeed, ...]) -> list[tuple[Any, ...]]:
    return [(p.speed, *p.frequencies, p.gap, p.reason, p.mode, p.motions) for p in points]


def in_order(board: Board) -> tuple[AtSpeed, ...]:
    return tuple(board.points[number] for number in range(len(SPEEDS)))


def test_answers_in_any_order_are_named_from_the_lowest_speed_up(tmp_path: Path) -> None:
    asked = two_masses(tmp_path, harmonics=7, samples=64)
    lines = NonlinearLines(TARGETS, MPI.COMM_SELF, CampbellJournal(tmp_path / "one.jsonl"))
    alone = campbell_lines(asked.study, SPEEDS, 2, MPI.COMM_SELF, Stages(), lines)
    assert np.argmax([point.frequencies[0] > point.frequencies[1] for point in alone]) == 2
    board = Board(asked, SPEEDS, CampbellJournal(tmp_path / "two.jsonl"))
    found, going = spins(asked), []
    for number in (3, 1, 0, 2):
        board.modes_came(number, modes(found[number]))
        going += list(board.orders())
    assert [number for number, _ in going] == [0, 1, 2, 3]
    for number, (order,) in reversed(going):
        assert not board.complete
        board.motions_came(number, moving(found[number], order))
    assert board.complete
    assert numbers(in_order(board)) == numbers(alone)


def test_numbers_for_auto_are_found_at_one_speed(tmp_path: Path) -> None:
    """Others wait for them, also where the first speed has none; speeds that are known do not."""
    asked = two_masses(tmp_path, harmonics="auto", samples="auto", tolerance=1e-2)
    board, found = Board(asked, SPEEDS, CampbellJournal(tmp_path / "motions.jsonl")), spins(asked)
    for number, spin in enumerate(found):
        board.modes_came(number, modes(spin))
    ((number, (order,)),) = board.orders()
    assert (number, order.found) == (0, None)
    board.motions_came(0, Answer(errors=(ConvergenceError("lost"),)))
    assert [motion.reason for motion in board.points[0].motions] == ["lost"]
    ((number, (order,)),) = board.orders()
    assert (number, order.found) == (1, None)
    board.motions_came(1, done := moving(found[1], order))
    going = list(board.orders())
    assert [(number, order.found) for number, (order,) in going] == [
        (2, done.get().resolution),
        (3, done.get().resolution),
    ]
    again = Board(asked, SPEEDS[1:], CampbellJournal.begun(tmp_path, resume=True))
    for number, spin in enumerate(found[1:]):
        again.modes_came(number, modes(spin))
    assert [(number, len(orders)) for number, orders in again.orders()] == [(0, 0), (1, 1), (2, 1)]
    assert again.points[0].motions == done.get().motions


def test_beginning_anew_keeps_the_motions_that_are_there(tmp_path: Path) -> None:
    """As one may forget --resume, or the command may be stopped at once."""
    asked = two_masses(tmp_path, harmonics=5)
    lines = NonlinearLines(TARGETS, MPI.COMM_SELF, CampbellJournal.begun(tmp_path, resume=False))
    campbell_lines(asked.study, SPEEDS[:1], 2, MPI.COMM_SELF, Stages(), lines)
    before = (tmp_path / "motions.jsonl").read_text()
    assert not CampbellJournal.begun(tmp_path, resume=False).known
    assert (tmp_path / "motions.jsonl").read_text() == before
    assert len(CampbellJournal.begun(tmp_path, resume=True).known) == 1


def test_a_speed_that_fails_keeps_the_others_unless_it_is_the_first(tmp_path: Path) -> None:
    asked = replace(two_masses(tmp_path, harmonics=5), targets=())
    board, found = Board(asked, SPEEDS, CampbellJournal(tmp_path / "motions.jsonl")), spins(asked)
    wrong = Answer[Any](errors=(ModelError("is wrong"),))
    for number, spin in enumerate(found):
        board.modes_came(number, wrong if number == 2 else modes(spin))
    assert sorted(number for number, _ in board.orders()) == [0, 1, 2, 3]
    assert [point.reason for point in in_order(board)] == ["", "", "is wrong", ""]
    first = Board(asked, SPEEDS, CampbellJournal(tmp_path / "motions.jsonl"))
    first.modes_came(0, wrong)
    with pytest.raises(ModelError, match="is wrong"):
        list(first.orders())


class Dying:
    """A worker in this process, which dies when it is asked for the motions at one speed."""

    def __init__(self, asked: Asked, lethal: float) -> None:
        self._asked, self._lethal = asked, lethal
        self._spinning = spinning_of(asked.study, MPI.COMM_SELF, Stages())
        self.alive, self.given, self.spin = True, 0.0, Answer[Spin]()

    def send(self, message: Any) -> None:
        self.given = message

    def received(self) -> Answer[Any]:
        if self.given == self._lethal:
            raise WorkerDied("its process was ended by SIGKILL")
        if not self.spin.values:
            self.spin = Answer.of(lambda: self._spinning.at(self.given, 2))
            return modes(self.spin)
        (order,) = self.given
        spin, self.spin = self.spin, Answer()
        return moving(spin, order)

    def stop(self, *, busy: bool) -> None:
        self.alive = False


def test_a_worker_that_dies_takes_its_speed_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked, made = two_masses(tmp_path, harmonics=7, samples=64), []

    def started(work: Any, given: Asked) -> Dying:
        made.append(Dying(given, SPEEDS[1]))
        return made[-1]

    monkeypatch.setattr("fenics_nnm.running.campbell_jobs.WorkerProcess.started", started)
    monkeypatch.setattr("fenics_nnm.running.campbell_jobs.ready_of", lambda busy: [len(busy) - 1])
    board = Board(asked, SPEEDS, CampbellJournal(tmp_path / "motions.jsonl"))
    points = lines_on_processes(board, 2, Stages())
    assert [point.reason for point in points] == ["", "its process was ended by SIGKILL", "", ""]
    assert all(len(point.motions) == 1 and not point.motions[0].failed for point in points[::2])
    assert len(made) == 3 and sum(worker.alive for worker in made) == 1  # the one that died
