"""fenics-nnm convergence: vary harmonics, samples and modes."""

from __future__ import annotations

import argparse
from pathlib import Path

from fenics_nnm.commands.place import place_line
from fenics_nnm.commands.shared import (
    DONE,
    INCOMPLETE,
    Commands,
    add_study,
    console_of,
    show,
    stages_of,
)
from fenics_nnm.interrupts import terminable


def add_to(commands: Commands) -> None:
    """Add the command."""
    convergence = commands.add_parser(
        "convergence", help="vary harmonics, samples and modes, and list the rates"
    )
    convergence.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of the results (default: results/STUDY-convergence)",
    )
    add_study(convergence)
    convergence.set_defaults(action=_convergence)


def _convergence(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.output.convergence_report import convergence_lines, write_convergence
    from fenics_nnm.resolution.auto import choice
    from fenics_nnm.resolution.convergence import convergence
    from fenics_nnm.results.own_files import CONVERGENCE, assert_writable
    from fenics_nnm.structure.mesh_notes import report_notes
    from fenics_nnm.structure.motions import assert_still_gaps, assert_without_coriolis
    from fenics_nnm.study.reading import read_study

    study = read_study(arguments.study)
    assert_without_coriolis(study)
    assert_still_gaps(study)
    console, comm = console_of(MPI.COMM_WORLD), MPI.COMM_WORLD
    folder = arguments.output or Path("results") / f"{arguments.study.stem}-convergence"
    on_root(comm, assert_writable, folder, CONVERGENCE)
    with terminable(), stages_of(console, arguments) as stages:
        chosen = choice(study, comm, stages)
        report_notes(chosen.linear.notes(), comm)
        found = convergence(chosen, comm, stages)
        on_root(comm, write_convergence, folder, found, title=study.title)
    for line in convergence_lines(found):
        show(console, line)
    show(console, place_line(folder))
    return DONE if found.complete else INCOMPLETE
