"""fenics-nnm sweep: run a study with many values of some keys."""

from __future__ import annotations

import argparse
import shlex
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from fenics_nnm.commands.amounts import add_amounts, amounts_of
from fenics_nnm.commands.shared import (
    DONE,
    INCOMPLETE,
    Commands,
    add_study,
    assert_jobs,
    complain,
    console_of,
    show,
    stages_of,
)
from fenics_nnm.interrupts import terminable, uninterrupted
from fenics_nnm.stages import Stages

if TYPE_CHECKING:
    from mpi4py import MPI
    from rich.console import Console

    from fenics_nnm.sweep.case import Outcome, Plan
    from fenics_nnm.sweep.sweep import Sweep


def add_to(commands: Commands) -> None:
    """Add the command."""
    sweep = commands.add_parser("sweep", help="run a study with many values of some keys")
    sweep.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE,...",
        help="values of a key, as in contact.gap=1e-4,2e-4; may be given several times",
    )
    sweep.add_argument(
        "--table",
        type=Path,
        metavar="FILE.csv",
        help="one study a row: keys in the first row, values below",
    )
    sweep.add_argument(
        "--zip",
        action="store_true",
        help="first values of all --set together, then the second ones; not all combinations",
    )
    sweep.add_argument(
        "--gamma",
        type=float,
        nargs="+",
        default=[],
        metavar="RATIO",
        help="gamma ratios in the table (default: continuation.report_at)",
    )
    add_amounts(sweep, ": each study has a point there, and the table its columns")
    sweep.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of all studies and the table (default: results/STUDY-sweep)",
    )
    sweep.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="processes of this machine (default: 1)"
    )
    sweep.add_argument(
        "--response",
        action="store_true",
        help="responses of driven studies, as of fenics-nnm response, in place of backbones",
    )
    way = sweep.add_mutually_exclusive_group()
    way.add_argument(
        "--list", action="store_true", help="run nothing: print a command for each study to run"
    )
    way.add_argument("--collect", action="store_true", help="run nothing: only make the table")
    add_study(sweep)
    sweep.set_defaults(action=_sweep)


def _sweep(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.sweep.sweep import begun  # on all ranks: PETSc begins with all of them

    comm = MPI.COMM_WORLD
    assert_jobs(arguments.jobs, comm)
    sweep = on_root(comm, lambda: begun(_planned(arguments)))
    console = console_of(comm)
    if arguments.list:
        return _list(console, sweep)
    on_root(comm, sweep.make_folder)
    try:
        if not arguments.collect:
            _run(sweep, arguments, console, comm)
    except BaseException:
        if comm.rank == 0:
            with uninterrupted():
                sweep.write_table()
        raise
    sweep.look()
    on_root(comm, _write, sweep)
    return _ended(sweep, console, comm)


def _planned(arguments: argparse.Namespace) -> Plan:
    from fenics_nnm.sweep.asked import Asked
    from fenics_nnm.sweep.backbones import Backbones
    from fenics_nnm.sweep.plan import plan
    from fenics_nnm.sweep.responses import Responses

    kind = Responses() if arguments.response else Backbones()
    return plan(
        arguments.study,
        arguments.output or Path("results") / f"{arguments.study.stem}-sweep",
        arguments.set,
        kind,
        table=arguments.table,
        zipped=arguments.zip,
        asked=Asked(tuple(arguments.gamma), tuple(amounts_of(arguments))),
    )


def _list(console: Console, sweep: Sweep) -> int:
    """Print a command for each study that is not done."""
    for case in sweep.left:
        made = (*sweep.plan.common, *case.settings)
        settings = [word for each in made for word in ("--set", each.argument)]
        words = [str(sweep.plan.file), *settings, "--output", str(case.folder), "--resume"]
        show(console, shlex.join(["fenics-nnm", sweep.plan.kind.command, *words]))
    done = len(sweep.plan.cases) - len(sweep.left)
    if done and not console.quiet:
        complain(f"{done} of {len(sweep.plan.cases)} studies are done, and not in the list")
    return DONE


def _run(
    sweep: Sweep, arguments: argparse.Namespace, console: Console, comm: MPI.Intracomm
) -> None:
    from fenics_nnm.commands.lasting_console import LastingConsole
    from fenics_nnm.sweep.case import RunState

    total, left = len(sweep.plan.cases), len(sweep.left)
    going_on = sum(state is RunState.BEGUN for state in sweep.states.values())
    taken = f", {going_on} of them from points of an earlier run" if going_on else ""
    show(console, f"{total} studies: {total - left} done, {left} to run{taken}")
    here = LastingConsole(force_terminal=False) if comm.size > 1 else console
    sweep.on_outcome = lambda outcome: show(here, _line(outcome, total))

    def stages() -> AbstractContextManager[Stages]:
        return stages_of(console, arguments)

    with terminable():
        if comm.size > 1:
            sweep.run_on_ranks(stages, comm, verbose=arguments.verbose)
        elif arguments.jobs > 1:
            sweep.run_on_processes(arguments.jobs, verbose=arguments.verbose)
        else:
            sweep.run(stages, verbose=arguments.verbose)


def _line(outcome: Outcome, total: int) -> str:
    points = f", {outcome.points} points" if outcome.points else ""
    return f"study {outcome.case.number} of {total}: {outcome.case}: {outcome.status}{points}"


def _write(sweep: Sweep) -> None:
    """Write the table and draw the pictures."""
    from fenics_nnm.errors import OutputError

    sweep.write_table()
    title = sweep.plan.cases[0].study.title or str(sweep.plan.file)
    try:
        sweep.plan.kind.draw(sweep.plan, sweep.in_order, title)
    except OSError as error:
        reason = error.strerror or error
        raise OutputError(f"{sweep.plan.folder}: cannot be written: {reason}") from error


def _ended(sweep: Sweep, console: Console, comm: MPI.Intracomm) -> int:
    from fenics_nnm.sweep.sweep import failures

    found = failures(sweep.in_order)
    if comm.rank == 0:
        for line in found:
            complain(line)
    show(console, f"table in {sweep.plan.folder / 'sweep.csv'}")
    return INCOMPLETE if found else DONE
