"""fenics-nnm simulate: a driven structure in time, from rest or from a stored state."""

from __future__ import annotations

import argparse
from dataclasses import replace
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
    complain,
    console_of,
    show,
    stages_of,
)
from fenics_nnm.errors import StudyError
from fenics_nnm.interrupts import terminable

if TYPE_CHECKING:
    from rich.table import Table

    from fenics_nnm.response.structure import DrivenStructure
    from fenics_nnm.structure.simulated import Leg, Simulated, Wanted
    from fenics_nnm.study import Study

_WAYS = ("up", "down", "both")

#: Digits of the number of a branch or a point.
_DIGITS = 9


def add_to(commands: Commands) -> None:
    """Add the command."""
    simulate = commands.add_parser(
        "simulate", help="a driven structure in time, at one frequency or in a sweep"
    )
    simulate.add_argument(
        "--frequency", type=float, metavar="HZ", help="constant frequency (default: a sweep)"
    )
    simulate.add_argument(
        "--way",
        choices=_WAYS,
        default="both",
        help="way through the frequencies of [response] (default: %(default)s, up and then down)",
    )
    simulate.add_argument(
        "--periods",
        type=int,
        metavar="N",
        help="periods in all (default: 500), or at each frequency of a sweep (20)",
    )
    simulate.add_argument(
        "--level", type=float, default=1.0, metavar="X", help="factor of all forces (default: 1)"
    )
    simulate.add_argument(
        "--start",
        type=Path,
        metavar="DIR",
        help="folder of a simulation whose last state is the first of this one, or of a response: "
        "its motion nearest to the first frequency (default: rest)",
    )
    simulate.add_argument(
        "--point",
        metavar="BRANCH:POINT",
        help="with --start of a response: numbers of the motion in response.csv, as in 1:23",
    )
    simulate.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of the results (default: results/STUDY-simulation)",
    )
    add_settings(simulate)
    add_study(simulate)
    simulate.set_defaults(action=_simulate)


def _simulate(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.output.simulation_report import write_simulation
    from fenics_nnm.results.own_files import SIMULATION, assert_writable
    from fenics_nnm.structure.driven import driven_structure
    from fenics_nnm.structure.simulated import asked_of, simulated

    given = arguments
    wanted = asked_of(given.frequency, given.periods, given.way, given.level)
    (study, _), comm = asked_study(arguments), MPI.COMM_WORLD
    console = console_of(comm)
    wanted = on_root(comm, _with_start, arguments, study, wanted)
    if wanted.start and wanted.start.words:
        show(console, wanted.start.words)
    folder = arguments.output or Path("results") / f"{arguments.study.stem}-simulation"
    on_root(comm, assert_writable, folder, SIMULATION)
    with terminable(), stages_of(console, arguments) as stages:
        structure = driven_structure(study, comm, stages, "simulate")
        found = on_root(comm, simulated, study, structure, wanted, stages)
        on_root(comm, write_simulation, folder, structure.monitors, found, title=study.title)
    console.print(simulation_table(structure, found, study.title))
    if found.settled:
        show(console, f"The motion {found.settled}.")
    show(console, place_line(folder))
    if found.failure and comm.rank == 0:
        complain(f"incomplete: {found.failure}")
    return INCOMPLETE if found.failure else DONE


def _with_start(arguments: argparse.Namespace, study: Study, wanted: Wanted) -> Wanted:
    """The same with the state to start from.

    Raises:
        StudyError, OutputError: if it cannot be read, or is not there.
    """
    from fenics_nnm.results.kinds import folder_of
    from fenics_nnm.results.response_file import NAME
    from fenics_nnm.results.response_start import start_of_response
    from fenics_nnm.structure.simulated import STATE_FILE, first_frequency, last_state

    folder = None if arguments.start is None else folder_of(arguments.start)
    place = _place(arguments.point)
    if folder is not None and (folder / NAME).exists():
        frequency = first_frequency(study, wanted)
        return replace(wanted, start=start_of_response(folder, frequency, wanted.level, place))
    if place is not None:
        raise StudyError(f"--point {arguments.point}: needs --start with the folder of a response")
    return wanted if folder is None else replace(wanted, start=last_state(folder / STATE_FILE))


def _place(text: str | None) -> tuple[int, int] | None:
    """Numbers of a branch and a point on it.

    Raises:
        StudyError: if they are not of the form BRANCH:POINT.
    """
    if text is None:
        return None
    branch, _, number = text.partition(":")
    if not all(part.isdecimal() and len(part) <= _DIGITS for part in (branch, number)):
        raise StudyError(f"--point {text}: must be BRANCH:POINT, two numbers, as in 1:23")
    return int(branch), int(number)


def simulation_table(structure: DrivenStructure, found: Simulated, title: str = "") -> Table:
    """Largest amplitude of each way, and the last one, of the excited and further places.

    Where there are none it is that of the contact point that moves most.
    """
    from rich.table import Table

    table = Table(title=title or None, box=None, padding=(0, 3, 0, 0))
    headings = ("way", "amplitude of", "largest (m)", "at (Hz)", "last (m)", "contact")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for leg in found.legs:
        if leg.found.periods:
            for row in _table_rows(structure, leg):
                table.add_row(*row)
    return table


def _table_rows(structure: DrivenStructure, leg: Leg) -> list[tuple[str, ...]]:
    amplitude, contact = leg.found.of("amplitude"), leg.found.of("contact_fraction")
    most = int(amplitude.max(axis=0).argmax())
    top = amplitude.argmax(axis=0)
    return [
        (
            leg.name,
            structure.monitors[place],
            f"{amplitude[top[place], place]:.4g}",
            f"{leg.found.periods[top[place]].frequency:.6g}",
            f"{amplitude[-1, place]:.4g}",
            f"{contact[-1]:.1%}",
        )
        for place in range(structure.watched.before_contact) or [most]
    ]
