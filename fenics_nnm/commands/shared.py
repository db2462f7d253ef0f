"""What commands share: exit codes, the console, progress and the study they are about."""

from __future__ import annotations

import argparse
import sys
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fenics_nnm.errors import StudyError
from fenics_nnm.stages import Stages

if TYPE_CHECKING:
    from mpi4py import MPI
    from rich.console import Console

    from fenics_nnm.study import Study
    from fenics_nnm.study.settings import Setting

Commands = Any
"""What `argparse` calls subparsers; its type is private."""

#: Exit codes: all that was asked for, stopped early or something missing, bad input.
DONE, INCOMPLETE, BAD_INPUT = 0, 1, 2


class _NoCache(argparse.Action):
    """Turns the cache off."""

    def __init__(self, **given: Any) -> None:
        super().__init__(nargs=0, **given)

    def __call__(self, *given: object) -> None:
        from fenics_nnm.files.cache import turn_off

        turn_off()


def add_study(command: argparse.ArgumentParser) -> None:
    """Arguments of a command that reads a study file."""
    command.add_argument("study", type=Path, metavar="STUDY.toml", help="study file")
    command.add_argument(
        "--no-cache",
        action=_NoCache,
        help="compute meshes and modes anew, and keep none: see fenics-nnm cache",
    )
    add_verbose(command)


def add_settings(command: argparse.ArgumentParser) -> None:
    """The option that sets keys of the study."""
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a key in place of that of the study, as in contact.gap=2e-4; may be given again",
    )


def asked_study(arguments: argparse.Namespace) -> tuple[Study, str]:
    """The study that is asked for with the keys that are set, and the text of its study file.

    Raises:
        StudyError: if file, key or value is wrong.
    """
    from fenics_nnm.study.reading import read_study, read_values
    from fenics_nnm.study.settings import study_with

    file: Path = arguments.study
    settings = tuple(_only(text) for text in arguments.set)
    if settings:
        return study_with(read_values(file), file, settings)
    return read_study(file), file.read_text("utf-8-sig")


def _only(text: str) -> Setting:
    from fenics_nnm.study.settings import settings_from

    settings = settings_from(text)
    if len(settings) > 1:
        raise StudyError(
            f"--set {text}: has {len(settings)} values: fenics-nnm sweep takes several"
        )
    return settings[0]


def assert_jobs(jobs: int, comm: MPI.Comm) -> None:
    """Refuse numbers of processes that cannot be.

    Raises:
        StudyError: if there are less than one, or more under mpirun.
    """
    if jobs < 1:
        raise StudyError(f"--jobs {jobs}: must be at least 1")
    if jobs > 1 and comm.size > 1:
        raise StudyError(f"--jobs {jobs}: does not go with mpirun: the ranks share")


def add_verbose(command: argparse.ArgumentParser) -> None:
    """The option that reports more on the way."""
    command.add_argument("-v", "--verbose", action="store_true", help="report more on the way")


def stages_of(console: Console, arguments: argparse.Namespace) -> AbstractContextManager[Stages]:
    """Progress bars on a terminal, else lines; those of the log in their place if asked for."""
    from fenics_nnm.progress import progress

    return nullcontext(Stages()) if arguments.verbose else progress(console, complain)


def console_of(comm: MPI.Comm) -> Console:
    """Console of rank 0; mpirun's terminals are taken for none, as it makes them for log files."""
    from fenics_nnm.commands.lasting_console import LastingConsole

    return LastingConsole(quiet=comm.rank > 0, force_terminal=False if comm.size > 1 else None)


def show(console: Console, text: str) -> None:
    """Print text as it is."""
    console.print(text, highlight=False, markup=False, soft_wrap=True)


def printable(text: str) -> str:
    """Text without what moves the cursor or turns the writing round: these as escapes."""
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text
    )


def complain(message: str) -> None:
    """Write a line to stderr."""
    with suppress(OSError):  # stderr may be a file on a full disk
        sys.stderr.write(f"fenics-nnm: {printable(message)}\n")
        sys.stderr.flush()
