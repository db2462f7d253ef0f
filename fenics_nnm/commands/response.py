"""fenics-nnm response: motions of a driven structure over frequency."""

from __future__ import annotations

import argparse
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
from fenics_nnm.interrupts import terminable

if TYPE_CHECKING:
    from rich.table import Table

    from fenics_nnm.response.levels import Response
    from fenics_nnm.response.structure import DrivenStructure


def add_to(commands: Commands) -> None:
    """Add the command."""
    response = commands.add_parser(
        "response", help="amplitude and phase of a driven structure over frequency"
    )
    response.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of the results (default: results/STUDY-response)",
    )
    response.add_argument(
        "--resume",
        action="store_true",
        help="go on from the levels of an interrupted, or finished, response of the same study",
    )
    add_settings(response)
    add_study(response)
    response.set_defaults(action=_response)


def _response(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.output.response_lines import short_of
    from fenics_nnm.running.responding import ResponseJob, respond

    (study, text), comm = asked_study(arguments), MPI.COMM_WORLD
    console = console_of(comm)
    folder = arguments.output or Path("results") / f"{arguments.study.stem}-response"
    with terminable(), stages_of(console, arguments) as stages:
        done = respond(ResponseJob(study, text, arguments.resume, comm, stages), folder)
    found = done.found
    console.print(peak_table(done.structure, found, study.title))
    if found.backbone.points:
        console.print(resonance_table(found))
    for line in done.notes:
        show(console, line)
    for reason in short_of(found.backbone):
        show(console, f"damped backbone: {reason}")
    show(console, place_line(folder))
    if comm.rank == 0:
        for line in done.missing:
            complain(f"incomplete: {line}")
    return INCOMPLETE if done.missing else DONE


def peak_table(structure: DrivenStructure, found: Response, title: str = "") -> Table:
    """Peaks of each curve, of the excited and further places and the contact point moved most."""
    from rich.table import Table

    levels = len({point.level for point in found.points}) > 1
    table = Table(title=title or None, box=None, padding=(0, 3, 0, 0))
    headings = ("peak of", "frequency (Hz)", "amplitude (m)", "phase (deg)")
    for heading in (*(["level"] if levels else []), *headings):
        table.add_column(heading, justify="right", no_wrap=True)
    for peak in found.peaks:
        table.add_row(
            *([f"{peak.level:g}"] if levels else []),
            structure.monitors[peak.monitor],
            f"{peak.frequency:.6g}",
            f"{peak.amplitude:.4g}",
            f"{peak.phase:.2f}",
        )
    return table


def resonance_table(found: Response) -> Table:
    """Phase resonances at the levels of the curves."""
    from rich.table import Table

    table = Table(box=None, padding=(0, 3, 0, 0))
    for heading in ("phase resonance at level", "frequency (Hz)", "force (N)", "damping ratio"):
        table.add_column(heading, justify="right", no_wrap=True)
    levels = {point.level for point in found.points}
    for each in found.backbone.points:
        if each.point.level in levels:
            table.add_row(
                f"{each.point.level:g}",
                f"{each.point.frequency:.6g}",
                f"{each.force:.4g}",
                f"{each.damping_ratio:.4g}",
            )
    return table
