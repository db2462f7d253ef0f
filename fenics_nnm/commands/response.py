"""fenics-nnm response: motions of a driven structure over frequency."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

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
    from fenics_nnm.response.driven import ResponsePoint
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
    add_settings(response)
    add_study(response)
    response.set_defaults(action=_response)


def _response(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.output.response_report import write_response
    from fenics_nnm.structure.driven import driven_motions, driven_structure

    (study, _), comm = asked_study(arguments), MPI.COMM_WORLD
    console = console_of(comm)
    folder = arguments.output or Path("results") / f"{arguments.study.stem}-response"
    with terminable(), stages_of(console, arguments) as stages:
        structure = driven_structure(study, comm, stages)
        points = on_root(comm, driven_motions, study, structure, stages)
        on_root(comm, write_response, folder, structure.monitors, points, title=study.title)
    console.print(peak_table(structure, points, study.title))
    show(console, f"results in {folder}")
    missing = [point for point in points if not point.found]
    if missing and comm.rank == 0:
        complain(
            f"incomplete: {len(missing)} of {len(points)} frequencies without amplitudes, the "
            f"first at {missing[0].frequency:g} Hz: {missing[0].reason}"
        )
    return INCOMPLETE if missing else DONE


def peak_table(
    structure: DrivenStructure, points: tuple[ResponsePoint, ...], title: str = ""
) -> Table:
    """Peaks of the excited points, and of the contact point that moves most."""
    from fenics_nnm.response.peaks import most_moved, peaks

    table = Table(title=title or None, box=None, padding=(0, 3, 0, 0))
    for heading in ("peak of", "frequency (Hz)", "amplitude (m)", "phase (deg)"):
        table.add_column(heading, justify="right", no_wrap=True)
    excited, every = len(structure.excited), range(len(structure.monitors))
    for monitor in (*every[:excited], most_moved(points, every[excited:])):
        for peak in peaks(points, monitor):
            table.add_row(
                structure.monitors[monitor],
                f"{peak.frequency:.6g}",
                f"{peak.amplitude:.4g}",
                f"{peak.phase:.2f}",
            )
    return table
