"""Command line: fenics-nnm, its commands and how it ends."""

from __future__ import annotations

import argparse
import logging
import os
import sys
import traceback
from collections.abc import Sequence
from typing import TYPE_CHECKING, NoReturn

from fenics_nnm import __version__
from fenics_nnm.commands import COMMANDS
from fenics_nnm.commands.shared import BAD_INPUT, INCOMPLETE, complain
from fenics_nnm.commands.warnings_shown import show_by_line
from fenics_nnm.errors import ConvergenceError, NoBodyError, NonlinearModeError, OutputError
from fenics_nnm.interrupts import raised
from fenics_nnm.running.beginning import begin

if TYPE_CHECKING:
    from mpi4py import MPI


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    os.environ["PYTHONSAFEPATH"] = "1"  # of all processes that are started from here
    arguments = _parser().parse_args(argv)
    sys.argv = [each.encode("utf-8", "replace").decode() for each in sys.argv]  # dolfinx reads them
    try:
        begin()
    except OutputError as error:
        complain(_line(error))
        return INCOMPLETE
    from mpi4py import MPI

    _configure_logging(verbose=arguments.verbose and MPI.COMM_WORLD.rank == 0)
    raised()
    comm = MPI.COMM_WORLD.Dup() if MPI.COMM_WORLD.size > 1 else MPI.COMM_WORLD
    try:
        return int(arguments.action(arguments))
    except (Exception, KeyboardInterrupt) as error:
        if arguments.verbose:
            traceback.print_exception(error)
        return _ended(comm, *_verdict(error))


def _configure_logging(*, verbose: bool) -> None:
    """Show warnings, and on the way stages and points if asked for; other libraries' never."""
    logging.basicConfig(format="fenics-nnm: %(message)s")
    show_by_line()
    logging.getLogger("fenics_nnm").setLevel(logging.INFO if verbose else logging.WARNING)


def _verdict(error: BaseException) -> tuple[str, int]:
    """One line about an error, and the exit code."""
    code = BAD_INPUT if isinstance(error, NonlinearModeError) else INCOMPLETE
    if isinstance(error, ConvergenceError | OutputError) and not isinstance(error, NoBodyError):
        code = INCOMPLETE
    return _line(error), code


def _line(error: BaseException) -> str:
    """An error in the words of the study file."""
    from fenics_nnm.study.error_keys import one_line

    return one_line(error)


def _ended(comm: MPI.Comm, message: str, code: int) -> int:
    """Say once how a run ended; end all ranks where only some of them fail."""
    from fenics_nnm.fem.parallel import all_arrive

    if comm.size > 1 and not all_arrive(comm):
        complain(f"rank {comm.rank}: {message}")
        comm.Abort(code)
    if comm.rank == 0:
        complain(message)
    comm.Barrier()
    return code


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, as all else does."""

    def error(self, message: str) -> NoReturn:
        """End with a line about arguments."""
        complain(f"{message}: see {self.prog} --help")
        sys.exit(BAD_INPUT)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="fenics-nnm",
        description="Nonlinear modes of elastic structures in unilateral contact.",
        epilog="example:\n  fenics-nnm new plate && fenics-nnm run plate.toml && "
        "fenics-nnm report results/plate\n\n"
        "fenics-nnm COMMAND --help lists the options of a command.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"fenics-nnm {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_to(commands)
    return parser
