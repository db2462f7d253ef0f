"""What a process does that shares the speeds of a Campbell diagram with others.

It is given a speed and answers with the modes there. What these are called is known when all lower
speeds have been answered: then it is told so, and answers with the nonlinear motions, if any are
asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from typing import Generic, TypeVar

from mpi4py import MPI

from fenics_nnm.errors import ConvergenceError, NonlinearModeError
from fenics_nnm.interrupts import terminable
from fenics_nnm.running.campbell_journal import Done
from fenics_nnm.running.nonlinear_lines import motions_of
from fenics_nnm.running.worker_process import begin_work
from fenics_nnm.stages import Stages
from fenics_nnm.structure.campbell import Spinning, spinning_of
from fenics_nnm.structure.motions_at_speed import Target
from fenics_nnm.structure.spinning import Spin
from fenics_nnm.study import Study
from fenics_nnm.study.error_keys import one_line
from fenics_nnm.study.resolution import Resolution

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True)
class Answer(Generic[Value]):
    """What came of something that was asked.

    Attributes:
        values: The result alone; nothing where there is an error.
        errors: The error alone.
    """

    values: tuple[Value, ...] = ()
    errors: tuple[NonlinearModeError, ...] = ()

    @classmethod
    def of(cls, work: Callable[[], Value]) -> Answer[Value]:
        """Do some work; errors of all kinds are told."""
        try:
            return cls(values=(work(),))
        except NonlinearModeError as error:
            return cls(errors=(error,))
        except Exception as error:
            return cls(errors=(ConvergenceError(one_line(error)),))

    def get(self) -> Value:
        """The result.

        Raises:
            NonlinearModeError: the error, where there is one.
        """
        for error in self.errors:
            raise error
        return self.values[0]


@dataclass(frozen=True, slots=True)
class Asked:
    """What a worker is there for.

    Attributes:
        study: Study, at any speed.
        modes: Number of modes to follow.
        targets: Energies and amplitudes of nonlinear lines.
        verbose: Whether it reports its stages.
    """

    study: Study
    modes: int
    targets: tuple[Target, ...]
    verbose: bool = False


@dataclass(frozen=True, slots=True)
class Order:
    """Nonlinear motions that are asked for at the speed that a worker holds.

    Attributes:
        study: The study there, with the number of its mode.
        found: Numbers for "auto", if some were found before.
    """

    study: Study
    found: Resolution | None


def work(connection: Connection, asked: Asked) -> None:
    """Answer until nothing more comes."""
    begin_work(verbose=asked.verbose)
    speeds = _Speeds(asked)
    with suppress(EOFError, BrokenPipeError, KeyboardInterrupt), terminable():
        while True:
            _answered(connection, speeds, connection.recv())


def _answered(connection: Connection, speeds: _Speeds, speed: float) -> None:
    """Answer about a speed: with its modes, then with the motions of each order."""
    found = Answer.of(lambda: speeds.at(speed))
    connection.send(Answer(tuple(spin.modes for spin in found.values), found.errors))
    for order in connection.recv():
        connection.send(Answer.of(partial(speeds.moving, found, order)))


@dataclass(slots=True)
class _Speeds:
    """A structure that is made when it is asked for, and kept."""

    asked: Asked
    _made: tuple[Spinning, ...] = ()

    def at(self, speed: float) -> Spin:
        """The structure at a speed."""
        if not self._made:
            self._made = (spinning_of(self.asked.study, MPI.COMM_SELF, Stages()),)
        return self._made[0].at(speed, self.asked.modes)

    def moving(self, found: Answer[Spin], order: Order) -> Done:
        """Motions at a speed that was found."""
        targets, analyse = self.asked.targets, found.get().analyse
        return motions_of(order.study, analyse, targets, MPI.COMM_SELF, order.found)
