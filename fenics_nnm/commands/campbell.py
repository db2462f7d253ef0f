"""fenics-nnm campbell: linear and nonlinear frequencies over speed."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fenics_nnm.commands.place import place_line
from fenics_nnm.commands.shared import (
    DONE,
    INCOMPLETE,
    Commands,
    add_settings,
    add_study,
    asked_study,
    assert_jobs,
    complain,
    console_of,
    show,
    stages_of,
)
from fenics_nnm.errors import StudyError
from fenics_nnm.interrupts import terminable

if TYPE_CHECKING:
    from fenics_nnm.running.campbell_journal import CampbellJournal
    from fenics_nnm.running.campbell_worker import Asked
    from fenics_nnm.stages import Stages
    from fenics_nnm.structure.campbell import AtSpeed

#: Most speeds of a diagram, and digits of an engine order.
_MOST, _DIGITS = 10_000, 6


def add_to(commands: Commands) -> None:
    """Add the command."""
    campbell = commands.add_parser(
        "campbell", help="linear and nonlinear frequencies over speed, with engine orders"
    )
    campbell.add_argument(
        "--speeds", required=True, metavar="FROM:TO:STEP", help="speeds in rad/s, both ends too"
    )
    campbell.add_argument("--rpm", action="store_true", help="speeds are turns per minute")
    campbell.add_argument("--modes", type=int, default=6, metavar="N", help="modes (default: 6)")
    campbell.add_argument(
        "--orders", default="1,2,3,4", metavar="LIST", help="engine orders (default: 1,2,3,4)"
    )
    campbell.add_argument(
        "--energies",
        default="",
        metavar="LIST",
        help="nonlinear lines of the mode of the study at these energies in J, as in 0.5,1",
    )
    campbell.add_argument(
        "--amplitudes",
        default="",
        metavar="LIST",
        help='nonlinear lines at these largest displacements, as in "1 mm,2 mm"',
    )
    campbell.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of the results (default: results/STUDY-campbell)",
    )
    campbell.add_argument(
        "--resume", action="store_true", help="take over nonlinear motions of speeds that are done"
    )
    campbell.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="processes of this machine (default: 1)"
    )
    add_settings(campbell)
    add_study(campbell)
    campbell.set_defaults(action=_campbell)


def _campbell(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.commands.campbell_targets import targets_of
    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.output.campbell_report import write_campbell
    from fenics_nnm.results.own_files import CAMPBELL, assert_writable
    from fenics_nnm.running.campbell_journal import CampbellJournal
    from fenics_nnm.running.campbell_worker import Asked
    from fenics_nnm.running.nonlinear_lines import assert_has_lines

    comm = MPI.COMM_WORLD
    assert_jobs(arguments.jobs, comm)
    speeds, orders = speeds_from(arguments.speeds, turns=arguments.rpm), orders_of(arguments.orders)
    if arguments.modes < 1:
        raise StudyError(f"--modes {arguments.modes}: must be 1 or more")
    (study, _), console = asked_study(arguments), console_of(comm)
    targets = targets_of(arguments.energies, arguments.amplitudes, study.length_unit)
    if targets:
        assert_has_lines(study, arguments.modes)
    folder = arguments.output or Path("results") / f"{arguments.study.stem}-campbell"
    on_root(comm, assert_writable, folder, CAMPBELL)
    journal = on_root(comm, CampbellJournal.begun, folder, resume=arguments.resume)
    with terminable(), stages_of(console, arguments) as stages:
        asked = Asked(study, arguments.modes, targets, verbose=arguments.verbose)
        points = _lines(asked, speeds, arguments.jobs, journal, stages)
        title, turns, lobes = study.title, arguments.rpm, study.contact.passing_orders
        found = on_root(
            comm,
            write_campbell,
            folder,
            points,
            orders,
            title=title,
            turns=turns,
            lobes=lobes,
        )
    for each in found:
        show(
            console,
            f"{_order_name(each.order, lobes)} meets {each.line} at {each.speed:.6g} rad/s "
            f"({each.speed * 30 / math.pi:.6g} rpm), {each.frequency:.6g} Hz",
        )
    show(console, place_line(folder))
    missing = list(_missing(points))
    if comm.rank == 0:
        for line in missing:
            complain(line)
    return INCOMPLETE if missing else DONE


def _lines(
    asked: Asked, speeds: Sequence[float], jobs: int, journal: CampbellJournal, stages: Stages
) -> tuple[AtSpeed, ...]:
    """The diagram at all speeds, by all ranks together or by processes of this machine."""
    from mpi4py import MPI

    from fenics_nnm.running.campbell_jobs import Board, lines_on_processes
    from fenics_nnm.running.nonlinear_lines import NonlinearLines
    from fenics_nnm.structure.campbell import campbell_lines

    if jobs > 1:
        return lines_on_processes(Board(asked, speeds, journal), jobs, stages)
    motions = NonlinearLines(asked.targets, MPI.COMM_WORLD, journal)
    return campbell_lines(asked.study, speeds, asked.modes, MPI.COMM_WORLD, stages, motions)


def _order_name(order: int, lobes: Sequence[int]) -> str:
    return f"{order} lobes x speed" if order in lobes else f"engine order {order}"


def _missing(points: Sequence[AtSpeed]) -> Iterator[str]:
    """Lines about speeds without frequencies, and about motions that are missing."""
    without = [point for point in points if point.reason]
    if without:
        yield (
            f"incomplete: {len(without)} of {len(points)} speeds without frequencies, the first at "
            f"{without[0].speed:g} rad/s: {without[0].reason}"
        )
    motions = [(point.speed, motion) for point in points for motion in point.motions]
    failed = [(speed, motion) for speed, motion in motions if motion.failed]
    if failed:
        speed, motion = failed[0]
        yield (
            f"incomplete: {len(failed)} of {len(motions)} nonlinear motions failed, the first at "
            f"{speed:g} rad/s, {motion.target}: {motion.reason}"
        )


def speeds_from(text: str, *, turns: bool = False) -> list[float]:
    """Speeds in rad/s of FROM:TO:STEP in rad/s, or in turns per minute, with both ends.

    Raises:
        StudyError: if it is not of this form.
    """
    import numpy as np

    from fenics_nnm.structure.campbell import FASTEST

    try:
        start, stop, step = (float(part) for part in text.split(":"))
    except ValueError as error:
        raise StudyError(f"--speeds {text}: must be FROM:TO:STEP, three numbers") from error
    if not (0 <= start < stop <= FASTEST and 0 < step < math.inf):
        raise StudyError(
            f"--speeds {text}: must rise from 0 or more to {FASTEST:g} at most, by a positive step"
        )
    if (stop - start) / step > _MOST - 1:
        raise StudyError(f"--speeds {text}: are too many speeds: must be {_MOST} at most")
    steps = math.ceil((stop - start) / step - 1e-9)
    unit = math.pi / 30 if turns else 1.0
    return [float(each) * unit for each in np.linspace(start, stop, steps + 1)]


def orders_of(text: str) -> list[int]:
    """Engine orders of a list with commas, which may be empty.

    Raises:
        StudyError: if they are not positive integers, each once.
    """
    parts = [part.strip() for part in text.split(",") if part.strip()]
    right = all(part.isdecimal() and len(part) <= _DIGITS and int(part) for part in parts)
    if not right or len({int(part) for part in parts}) < len(parts):
        raise StudyError(
            f"--orders {text}: must be different positive integers of {_DIGITS} digits at most, as "
            "in 1,2,4"
        )
    return [int(part) for part in parts]
