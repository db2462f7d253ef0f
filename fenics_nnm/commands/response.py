"""fenics-nnm response: motions of a driven structure over frequency."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

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
    from collections.abc import Iterator

    from rich.table import Table

    from fenics_nnm.response.levels import Response
    from fenics_nnm.response.phase_resonance import DampedBackbone
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
        found = on_root(comm, driven_motions, study, structure, stages)
        on_root(comm, write_response, folder, structure.monitors, found, title=study.title)
    console.print(peak_table(structure, found, study.title))
    if found.backbone.points:
        console.print(resonance_table(found))
    for reason in _short_of(found.backbone):
        show(console, f"damped backbone: {reason}")
    show(console, f"results in {folder}")
    if comm.rank == 0:
        for line in _incomplete(found):
            complain(f"incomplete: {line}")
    return INCOMPLETE if any(_incomplete(found)) else DONE


def _incomplete(found: Response) -> Iterator[str]:
    """What is missing of a response, a line each."""
    missing = found.missing
    if missing:
        yield (
            f"{len(missing)} of {len(found.points)} points without amplitudes, the first at "
            f"{missing[0].frequency:g} Hz: {missing[0].reason}"
        )
    refuted = found.refuted
    if refuted:
        yield (
            f"{len(refuted)} of {len(found.points)} points are no motions, the first at "
            f"{refuted[0].frequency:g} Hz: {refuted[0].reason}"
        )
    for reason in found.reasons:
        yield f"the curve ends: {reason}"


def _short_of(backbone: DampedBackbone) -> Iterator[str]:
    """What a damped backbone lacks, a line each; the response is complete without."""
    if refuted := backbone.refuted:
        yield (
            f"{len(refuted)} of {len(backbone.points)} points are no motions, the first at level "
            f"{refuted[0].point.level:g}: {refuted[0].point.reason}"
        )
    yield from backbone.reasons


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
