"""Command line: fenics-nnm run, check, convergence."""

from __future__ import annotations

import argparse
import logging
import sys
import traceback
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from fenics_nnm import __version__
from fenics_nnm.errors import ConvergenceError, NonlinearModeError, OutputError
from fenics_nnm.interrupts import terminable
from fenics_nnm.progress import progress
from fenics_nnm.stages import Stages
from fenics_nnm.study import Study, read_study

if TYPE_CHECKING:
    from mpi4py import MPI

    from fenics_nnm.continuation.branch import Encounter
    from fenics_nnm.run import RunResult

#: Exit codes: all that was asked for, stopped early or something missing, bad input.
DONE, INCOMPLETE, BAD_INPUT = 0, 1, 2


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    arguments = _parser().parse_args(argv)
    from mpi4py import MPI

    _configure_logging(verbose=arguments.verbose and MPI.COMM_WORLD.rank == 0)
    comm = MPI.COMM_WORLD.Dup() if MPI.COMM_WORLD.size > 1 else MPI.COMM_WORLD
    try:
        study = read_study(arguments.study)
        return int(arguments.action(study, arguments))
    except (Exception, KeyboardInterrupt) as error:
        if arguments.verbose:
            traceback.print_exception(error)
        return _ended(comm, *_verdict(error))


def _configure_logging(*, verbose: bool) -> None:
    """Show warnings, and on the way stages and points if asked for; other libraries' never."""
    logging.basicConfig(format="fenics-nnm: %(message)s")
    logging.getLogger("fenics_nnm").setLevel(logging.INFO if verbose else logging.WARNING)


def _verdict(error: BaseException) -> tuple[str, int]:
    """One line about an error, and the exit code."""
    code = BAD_INPUT if isinstance(error, NonlinearModeError) else INCOMPLETE
    if isinstance(error, ConvergenceError | OutputError):
        code = INCOMPLETE
    message = "; ".join([_message(error), *getattr(error, "__notes__", ())])
    return " ".join(message.split()), code


def _message(error: BaseException) -> str:
    if isinstance(error, NonlinearModeError):
        return str(error)
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, MemoryError):
        return "out of memory: use a coarser mesh or fewer reduction.modes"
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    return (
        f"this is a defect of fenics-nnm, please report it: {type(error).__name__}: {error} "
        "(--verbose shows where)"
    )


def _ended(comm: MPI.Comm, message: str, code: int) -> int:
    """Say once how a run ended; end all ranks where only some of them fail."""
    from fenics_nnm.fem.parallel import all_arrive

    if comm.size > 1 and not all_arrive(comm):
        _write(f"rank {comm.rank}: {message}")
        comm.Abort(code)
    if comm.rank == 0:
        _write(message)
    comm.Barrier()
    return code


def _write(message: str) -> None:
    with suppress(OSError):  # stderr may be a file on a full disk
        sys.stderr.write(f"fenics-nnm: {message}\n")
        sys.stderr.flush()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fenics-nnm",
        description="Nonlinear modes of elastic structures in unilateral contact.",
    )
    parser.add_argument("--version", action="version", version=f"fenics-nnm {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="follow the nonlinear mode of a study")
    run.add_argument("--output", type=Path, metavar="DIR", help="folder of the results")
    run.add_argument(
        "--resume",
        action="store_true",
        help="go on from the points of a stopped, or finished, run of the same study",
    )
    run.set_defaults(action=_run)
    check = commands.add_parser("check", help="show what a study means, up to its linear modes")
    check.set_defaults(action=_check)
    convergence = commands.add_parser(
        "convergence", help="vary harmonics, samples and modes, and tell the rates"
    )
    convergence.add_argument("--output", type=Path, metavar="DIR", help="folder of the results")
    convergence.set_defaults(action=_convergence)
    for command in (run, check, convergence):
        command.add_argument("study", type=Path, metavar="STUDY.toml", help="study file")
        command.add_argument("-v", "--verbose", action="store_true", help="tell more on the way")
    return parser


def _run(study: Study, arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.run import run_study

    console = _console(MPI.COMM_WORLD)
    folder = arguments.output or study.output.folder or Path("results") / arguments.study.stem
    with terminable(), _stages(console, arguments) as stages:
        text = arguments.study.read_text("utf-8")
        result = run_study(study, text, folder, resume=arguments.resume, stages=stages)
    if console.is_terminal:
        console.print(_result_table(result, study))
        for encounter in result.branch.encounters:
            console.print(_told(encounter), highlight=False, markup=False, soft_wrap=True)
        if result.told:
            console.print(result.told, highlight=False, markup=False, soft_wrap=True)
        closing = f"{result.branch.reason}; results in {result.folder}"
        console.print(closing, highlight=False, markup=False, soft_wrap=True)
    if not result.branch.complete:
        if MPI.COMM_WORLD.rank == 0:
            _write(f"incomplete: {result.branch.reason}")
        return INCOMPLETE
    return DONE


def _check(study: Study, arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.output.description import describe
    from fenics_nnm.resolution.auto import provisional

    console = _console(MPI.COMM_WORLD)
    with _stages(console, arguments) as stages:
        shown = provisional(study, MPI.COMM_WORLD, stages)
        text = describe(shown.study, shown.analysis)
    if study.automatic:
        text += (
            f'\n\n{", ".join(study.automatic)} = "auto": a run finds what a tolerance of '
            f"{study.tolerance:g} needs; this is with {shown.study.resolution}"
        )
    console.print(text, highlight=False, markup=False, soft_wrap=True)
    return DONE


def _convergence(study: Study, arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.output.convergence_report import convergence_lines, write_convergence
    from fenics_nnm.resolution.auto import choice
    from fenics_nnm.resolution.convergence import convergence

    console, comm = _console(MPI.COMM_WORLD), MPI.COMM_WORLD
    folder = arguments.output or Path("results") / f"{arguments.study.stem}-convergence"
    with terminable(), _stages(console, arguments) as stages:
        found = convergence(choice(study, comm, stages), comm, stages)
        on_root(comm, lambda: write_convergence(folder, found, title=study.title))
    for line in convergence_lines(found):
        console.print(line, highlight=False, markup=False, soft_wrap=True)
    console.print(f"results in {folder}", highlight=False, markup=False, soft_wrap=True)
    return DONE if found.complete else INCOMPLETE


def _stages(console: Console, arguments: argparse.Namespace) -> AbstractContextManager[Stages]:
    """Progress bars on a terminal; lines of the log in their place if asked for."""
    return nullcontext(Stages()) if arguments.verbose else progress(console)


def _console(comm: MPI.Comm) -> Console:
    """Console of rank 0; mpirun's terminals are taken for none, as it makes them for log files."""
    return Console(quiet=comm.rank > 0, force_terminal=False if comm.size > 1 else None)


def _told(encounter: Encounter) -> str:
    """What became of an internal resonance, in a line."""
    entered, skipped = (
        f"{what} at gamma ratio {', '.join(f'{ratio:g}' for ratio in ratios)}" if ratios else ""
        for what, ratios in (("entered", encounter.entered), ("skipped", encounter.skipped))
    )
    told = "; ".join(text for text in (entered, skipped) if text)
    return f"internal resonance with {encounter.name} near {encounter.frequency:.6g} Hz: {told}"


def _result_table(result: RunResult, study: Study) -> Table:
    """A few points of the branch: those reported, or evenly spread ones."""
    table = Table(title=study.title or None, box=None, padding=(0, 3, 0, 0))
    for heading in ("gamma ratio", "frequency (Hz)", "ratio", "status"):
        table.add_column(heading, justify="right", no_wrap=True)
    points = result.branch.points
    reported = [p for p in points if p.gamma_ratio in study.continuation.report_at]
    for point in reported or points[:: max(1, len(points) // 10)]:
        table.add_row(
            f"{point.gamma_ratio:g}",
            f"{point.frequency:.4f}",
            f"{point.frequency_ratio:.5f}",
            point.status,
        )
    return table
