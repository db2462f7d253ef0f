"""Command line: fenics-nnm run, check."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from fenics_nnm import __version__
from fenics_nnm.errors import ConvergenceError, NonlinearModeError, OutputError
from fenics_nnm.progress import progress
from fenics_nnm.study import Study, read_study

if TYPE_CHECKING:
    from fenics_nnm.run import RunResult

#: Exit codes: all that was asked for, stopped early or something missing, bad input.
DONE, INCOMPLETE, BAD_INPUT = 0, 1, 2


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    arguments = _parser().parse_args(argv)
    logging.basicConfig(
        format="fenics-nnm: %(message)s",
        level=logging.INFO if arguments.verbose else logging.WARNING,
    )
    computing = False
    try:
        study = read_study(arguments.study)
        computing = True
        return int(arguments.action(study, arguments))
    except NonlinearModeError as error:
        stopped = isinstance(error, ConvergenceError | OutputError) and computing
        return _ended(str(error), INCOMPLETE if stopped else BAD_INPUT)
    except KeyboardInterrupt:
        return _ended("interrupted", INCOMPLETE)
    except MemoryError:
        return _ended("out of memory: use a coarser mesh or fewer reduction.modes", INCOMPLETE)


def _ended(message: str, code: int) -> int:
    sys.stderr.write(f"fenics-nnm: {message}\n")
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fenics-nnm",
        description="Nonlinear modes of elastic structures in unilateral contact.",
    )
    parser.add_argument("--version", action="version", version=f"fenics-nnm {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="follow the nonlinear mode of a study")
    run.add_argument("--output", type=Path, metavar="DIR", help="folder of the results")
    run.set_defaults(action=_run)
    check = commands.add_parser("check", help="show what a study means, up to its linear modes")
    check.set_defaults(action=_check)
    for command in (run, check):
        command.add_argument("study", type=Path, metavar="STUDY.toml", help="study file")
        command.add_argument("-v", "--verbose", action="store_true", help="tell more on the way")
    return parser


def _run(study: Study, arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.run import run_study

    console = Console(quiet=MPI.COMM_WORLD.rank > 0)
    folder = arguments.output or study.output.folder or Path("results") / arguments.study.stem
    with _mpi_guard(MPI.COMM_WORLD), progress(console) as stages:
        result = run_study(study, arguments.study.read_text(), folder, stages=stages)
    if console.is_terminal:
        console.print(_result_table(result, study))
        console.print(f"{result.branch.reason}; results in {result.folder}")
    if not result.branch.complete:
        if MPI.COMM_WORLD.rank == 0:
            sys.stderr.write(f"fenics-nnm: incomplete: {result.branch.reason}\n")
        return INCOMPLETE
    return DONE


def _check(study: Study, arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.analysis import linear_analysis
    from fenics_nnm.output.description import describe

    console = Console(quiet=MPI.COMM_WORLD.rank > 0, soft_wrap=True)
    with _mpi_guard(MPI.COMM_WORLD), progress(console) as stages:
        analysis = linear_analysis(study, MPI.COMM_WORLD, stages)
        text = describe(study, analysis)
    console.print(text, highlight=False, markup=False)
    return DONE


@contextmanager
def _mpi_guard(comm: object) -> Iterator[None]:
    """End all ranks where one of several fails; the others would wait for ever."""
    try:
        yield
    except BaseException as error:
        if comm.size == 1:  # type: ignore[attr-defined]
            raise
        sys.stderr.write(f"fenics-nnm: rank {comm.rank}: {error}\n")  # type: ignore[attr-defined]
        sys.stderr.flush()
        code = BAD_INPUT if isinstance(error, NonlinearModeError) else INCOMPLETE
        comm.Abort(code)  # type: ignore[attr-defined]


def _result_table(result: RunResult, study: Study) -> Table:
    """A few points of the branch: those reported, or evenly spread ones."""
    table = Table(title=study.title or None)
    for heading in (
        "gamma ratio",
        "frequency (Hz)",
        "ratio",
        "Rayleigh (Hz)",
        "energy (J)",
        "status",
    ):
        table.add_column(heading, justify="right")
    points = result.branch.points
    reported = [p for p in points if p.gamma_ratio in study.continuation.report_at]
    for point in reported or points[:: max(1, len(points) // 10)]:
        table.add_row(
            f"{point.gamma_ratio:g}",
            f"{point.frequency:.4f}",
            f"{point.frequency_ratio:.5f}",
            f"{point.rayleigh_frequency:.4f}",
            f"{point.energy:.4g}",
            point.status,
        )
    return table
